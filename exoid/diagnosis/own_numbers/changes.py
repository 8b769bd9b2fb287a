"""Changes within a recording: a load is taken up, a zero jumps, a drive warms up and moves easier."""

from __future__ import annotations

import numpy as np

from exoid.diagnosis.own_numbers.bound import LEAST, best_split
from exoid.diagnosis.own_numbers.fits import Fits
from exoid.diagnosis.own_numbers.state import Claimed, Cuts, State
from exoid.optimisation.linear.loss import huber_terms


def changes_of(fits: Fits, state: State) -> Cuts:
    """Kept samples at which recordings are cut, beside what is held of the whole of them: where what may belong to
    recordings, with other numbers before than after, explains at least a little of what is left. A zero that all have
    is the machine's.
    """
    every, known = tuple(range(len(fits.rows))), [held.claim for held in state]
    zeros = [claim for claim in fits.claims if claim.everyone and claim not in known]
    state = (*state, *(Claimed(claim, claim.nodes[0], (every,)) for claim in zeros))
    step = fits.together(state)
    own = np.concatenate([np.r_[fits.place[claim]] for claim in fits.claims if not claim.common])
    found: dict[int, int] = {}
    for k, (rows, left) in enumerate(zip(fits.rows, fits.left_by(state, [step, step]), strict=True)):
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
