"""Changes within a recording: a load is taken up, a zero jumps, a drive warms up and moves easier. And a bound on what
is left of recordings that have numbers of their own, some of them from some moment on, before any are looked for.
"""

from __future__ import annotations

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gram import numbers_of
from exoid.diagnosis.evidence.model_error import sensor_noise
from exoid.diagnosis.own_numbers.fits import Fits
from exoid.diagnosis.own_numbers.state import Claimed, Cuts, State
from exoid.ground.ties import index_of_least
from exoid.optimisation.linear.loss import huber_terms
from exoid.symbolic.motion import Float

PACE = 0.5
"""Seconds between moments at which a change is looked for first."""
LEAST = 2.0
"""Seconds before and after a change that are needed to see it."""


def least_left(last: FittedModel) -> Float:
    """Error (J,) of a model as a multiple of the noise where each joint of every recording has all numbers of its own,
    a zero and a clock among them, and others from some moment on: what belongs to recordings leaves hardly less.
    """
    square, count = np.zeros((2, len(last.model.joints)))
    for k, block in enumerate(last.evidence(seed=0, draws=0).blocks):
        rising = np.gradient(last.torque(k), axis=1)
        for j, (columns, slope, left, used) in enumerate(
            zip(block.columns, rising, block.residual, block.use > 0.0, strict=True)
        ):
            own = np.column_stack([columns, np.ones(len(slope)), slope, left]) * used[:, None]
            _, _, least = best_split(own[None], own[None], block.rate)
            square[j] += least
            count[j] += np.count_nonzero(used)
    return np.asarray(np.sqrt(square / np.maximum(count, 1)) / sensor_noise(last.prepared))


def best_split(columns: Float, weighted: Float, rate: float) -> tuple[float, int, float]:
    """Squared error that columns (J, K, D - 1) at `rate` Hz leave of another one, the last (J, K, D); and the sample
    before and after which they leave least with other numbers, 0 where none can be seen, and how much then.
    """
    least, many = int(LEAST * rate), columns.shape[1]
    places = np.arange(least, many - least, max(1, int(PACE * rate)))
    ends = zip([0, *places], [*places, many], strict=True)
    grams = np.array([np.tensordot(columns[:, a:b], weighted[:, a:b], ((0, 1), (0, 1))) for a, b in ends])
    before = np.cumsum(grams, axis=0)
    whole = float(_left(before[-1]))
    if not len(places):
        return whole, 0, whole
    split = _left(before[:-1]) + _left(before[-1] - before[:-1])
    best = index_of_least(split)
    return whole, int(places[best]), float(split[best])


def _left(grams: Float) -> Float:
    """Squared errors (...) that the columns of Gram matrices (..., D, D) leave of the last one."""
    product = grams[..., :-1, -1]
    return np.maximum(grams[..., -1, -1] - np.sum(product * numbers_of(grams[..., :-1, :-1], product), axis=-1), 0.0)


def changes_of(fits: Fits, state: State) -> Cuts:
    """Kept samples at which recordings are cut, beside what is held of the whole of them: where what may belong to
    recordings, with other numbers before than after, explains at least a little of what is left. A zero that all have
    is the machine's.
    """
    every, known = tuple(range(len(fits.rows))), [held.claim for held in state]
    zeros = [claim for claim in fits.claims if claim.everyone and claim not in known]
    state = (*state, *(Claimed(claim, claim.nodes[0], (every,)) for claim in zeros))
    own = np.concatenate([np.r_[fits.place[claim]] for claim in fits.claims if not claim.common])
    fits.ask_all()
    found: dict[int, int] = {}
    for k, (rows, left) in enumerate(zip(fits.rows, fits.left(state), strict=True)):
        columns = np.concatenate([rows[:, :, own], left[:, :, None]], axis=2) / fits.sigma[:, None, None]
        size = np.maximum(np.abs(columns[:, :, -1]), 1e-300)
        weighted = columns * np.minimum(1.0, fits.rules.robust / size)[:, :, None]
        whole, place, parts = best_split(columns, weighted, fits.now.prepared.all[k].kept_rate)
        if place and parts <= (1.0 - fits.rules.little) * whole:
            found[k] = place
    return found


def sharpened(fits: Fits, state: State) -> Cuts:
    """Cuts of those recordings whose parts differ in what is held, at the sample that fits best."""
    step = fits.together(state)
    own = fits.chosen(state) @ np.append(-step, 1.0)
    found: dict[int, int] = {}
    for k, parts in enumerate(fits.everyone):
        if len(parts) < 2 or np.array_equal(own[parts[0]], own[parts[1]]):
            continue
        rows, losses = np.concatenate([fits.rows[j] for j in parts], axis=1), []
        for j in parts:
            for claim, number in fits.numbers_of(state, step, j).items():
                if claim.moves:  # which bends with its number
                    rows[:, :, fits.place[claim]] = fits.pieces(claim, k, number) * fits.blocks[k].use[:, :, None]
            losses.append(huber_terms(np.abs(rows @ own[j]) / fits.sigma[:, None], fits.rules.robust).sum(axis=0))
        before, after = losses
        least = int(LEAST * fits.now.prepared.all[k].kept_rate)
        change = np.cumsum(before - after)[least - 1 : len(before) - least]
        found[k] = least + int(np.argmin(change))
    return found
