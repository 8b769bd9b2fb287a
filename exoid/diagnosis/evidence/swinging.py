"""A swing at one frequency in every recording, whatever the motion: a base that oscillates, an engine, a fan.

Where its phase differs from recording to recording, no function of motion and common clock can describe it. Whoever
starts a recorder does not ask the stand for its phase. So a sway of the base is asked for with an amplitude and a phase
of its own in each recording: at a given frequency its torque is linear in its sine and cosine parts, and only the
frequency is searched. The model's numbers are those of all recordings. Each is judged by halves: one half with the sway
that the other half shows.

A sway shifted in time is the same sway with another phase, so time-shifted placebos cannot say what is chance here.
These placebos are shifted in frequency, each recording by another amount: what has no line of its own that all
recordings share gains as much from a frequency in one and a neighbouring one in another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate, candidate_columns
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.gram import Gram
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.ties import index_of_greatest, least_of
from exoid.optimisation.fitting.phases import phases_of
from exoid.symbolic.effect_catalogue import find_effect
from exoid.symbolic.motion import Float
from exoid.symbolic.term import Term, places_of

SLOWEST = 0.3
"""Hz; below, drifts and the motion itself."""
LOBE = 2.0
"""Half the width of a line behind a Hann window, in reciprocal durations."""
FINE = 4
"""Frequencies per reciprocal duration."""
LEAST, MOST = 0.25, 0.05
"""Share of the power that is left in one line in every recording, at least, and of the torque's own there, at most."""
SHORTEST = 8.0
"""Periods that the shortest recording must hold."""
ENTRY = "base_motion"
NEAR = 0.25
"""Part of a frequency about it in which that of the sway is searched: swings of the machine itself bend the line that
it leaves."""
MOST_TRIED = 100
"""Frequencies to either side of it at most, for speed: of a long recording the line is sharp."""
ASIDE, APART = 2, 2.0
"""Times that part to which placebos reach, and how far they are shifted at least, in reciprocal durations."""
ROUNDS = 2
"""Times that sway and model's numbers are fitted: the torque of the sway is proportional to the masses."""
FINER = 9
"""Parts of a step between frequencies to which the best one is found."""
AT_ONCE = 32
"""Frequencies whose columns are held in memory at once."""


@dataclass(frozen=True)
class Swing:
    """A line at `hertz` in what is left at `joint`: its least `share` of the power in any recording."""

    joint: str
    hertz: float
    share: float

    @property
    def sentence(self) -> str:
        """The swing in words: its share, joint and frequency."""
        return (
            f"at least {100 * self.share:.0f} % of what is left at the {self.joint} swings at {self.hertz:.2g} Hz in "
            "every recording, whatever the motion: does the base oscillate, each time with another phase?"
        )

    @property
    def advice(self) -> str:
        """Advice to the person who measures."""
        return (
            f"clamp the base, or find what moves at {self.hertz:.2g} Hz; if it cannot be stopped, "
            "measure the motion of the base; base_motion describes a sway of the same size in every recording"
        )


def swinging(last: FittedModel) -> Swing | None:
    """Return the clearest line that all recordings have in what `last` leaves; None where there is none."""
    every, found = last.prepared.all, []
    for j, joint in enumerate(last.model.joint_names):
        left = [np.where(item.used[j], r[j], 0.0) for r, item in zip(last.residuals, every, strict=True)]
        if line := common_line(left, [item.torque[j] for item in every], [item.kept_rate for item in every]):
            found.append(Swing(joint, *line))
    return least_of(found, lambda one: -one.share, 1.0) if found else None


def common_line(left: Sequence[Float], torque: Sequence[Float], rates: Sequence[float]) -> tuple[float, float] | None:
    """Return frequency (Hz) and least share of the line that all of `left` have and their `torque` has not."""
    if len(left) < 2:
        return None
    lasts = [len(x) / rate for x, rate in zip(left, rates, strict=True)]
    step, first = 1.0 / (FINE * max(lasts)), max(SLOWEST, SHORTEST / min(lasts))
    top = 0.4 * min(rates)
    if top <= first:
        return None
    grid = np.arange(first, top, step)
    rest, own = (
        np.array([_shares(x, rate, step, grid) for x, rate in zip(some, rates, strict=True)]) for some in (left, torque)
    )
    least = np.where(own.max(axis=0) < MOST, rest.min(axis=0), 0.0)
    best = index_of_greatest(least, 1.0)
    return (float(grid[best]), float(least[best])) if least[best] >= LEAST else None


def _shares(x: Float, rate: float, step: float, grid: Float) -> Float:
    """Return for each frequency of `grid` (Hz) the share of the power of `x` in a line there."""
    count = round(rate / step)
    power = np.abs(np.fft.rfft((x - x.mean()) * np.hanning(len(x)), count)) ** 2
    upto = np.concatenate([[0.0], np.cumsum(power)])
    half = LOBE * rate / len(x)
    places = np.arange(len(power)) * rate / count
    low, high = np.searchsorted(places, grid - half), np.searchsorted(places, grid + half, side="right")
    return np.asarray((upto[high] - upto[low]) / max(upto[-1], 1e-300))


@dataclass(frozen=True, eq=False)
class OwnSway:
    """A sway at `hertz` whose sine and cosine parts are `parts` (R, 4) m/s², forwards and upwards, in each recording.

    `p_value` is the share of placebos that gain as much, the sway itself counted among them.
    """

    hertz: float
    parts: Float
    p_value: float

    @property
    def nodes(self) -> Float:
        """The only node (R, 1, 2) of the catalogue's entry: this frequency, and the phases."""
        return np.column_stack([np.full(len(self.parts), self.hertz), phases_of(self.parts)])[:, None]


def own_sway(last: FittedModel, noise: Float, rules: Rules = RULES) -> OwnSway | None:
    """Return the sway about the clearest line of what `last` leaves, where that is far above the `noise` (J,) in N·m;
    None for none.
    """
    swing = swinging(last) if np.any(last.evaluation_rms > rules.near_noise * noise) else None
    effect, model = find_effect(ENTRY), last.model
    taken = model.moving_base or any(term.effect.id == ENTRY for term in model.terms)
    if swing is None or taken or not places_of(effect, model.joints):
        return None
    every = last.prepared.all
    lasts = [float(item.t[-1] - item.t[0]) for item in every]
    step = 1.0 / (FINE * max(lasts))
    count = min(MOST_TRIED, int(NEAR * swing.hertz / step))
    allowed = effect.shape["f"]
    wide = swing.hertz + step * np.arange(-ASIDE * count, ASIDE * count + 1, dtype=float)
    wide = wide[(wide >= allowed.min) & (wide <= allowed.max)]
    near = np.abs(wide - swing.hertz) <= (count + 0.5) * step
    if not near.any():
        return None
    candidate = Candidate(Term(effect, None, model.joints), np.zeros((1, 1, 2)), False)
    # The halves of all recordings are held out, one after the other.
    blocks = last.evidence(seed=0, draws=0, rules=rules).blocks
    halves = [replace(block, fold=2 * np.arange(len(block.fold)) // len(block.fold)) for block in blocks]
    evidence = Evidence(halves, (), seed=0, draws=0, rules=replace(rules, most_folds=2 * len(halves)))
    gains = _gains(evidence, last, candidate, wide)
    best = wide[near][index_of_greatest(gains.sum(axis=0)[near])]
    finer = best + step / FINER * np.arange(1 - FINER, FINER)
    hertz = float(finer[index_of_greatest(_gains(evidence, last, candidate, finer).sum(axis=0))])
    carrier, joints = last, tuple(range(len(noise)))
    for _ in range(ROUNDS):
        own = [item.full(0, len(noise)) for item in _columns(carrier, candidate, np.array([hertz]))]
        # Those of all recordings beside each other, since all share the numbers of the model.
        each = [np.kron(place, x)[None] for place, x in zip(np.eye(len(own)), own, strict=True)]
        beside = [Columns(joints, np.asarray(x, dtype=float)) for x in each]
        grams = evidence.plain(beside)
        parts, change = evidence.fitted(grams)
        carrier = replace(last, fit=replace(last.fit, linear=last.linear + change[: len(last.linear)]))
    apart = int(np.ceil(APART / (min(lasts) * step)))
    return OwnSway(hertz, parts.reshape(len(every), -1), chance_of(gains, near, apart, rules.placebos))


def _columns(last: FittedModel, candidate: Candidate, hertz: Float) -> list[Columns]:
    nodes = np.column_stack([hertz, np.zeros(len(hertz))])
    return [candidate_columns(candidate, nodes, item, last) for item in last.prepared.all]


def _gains(evidence: Evidence, last: FittedModel, candidate: Candidate, hertz: Float) -> Float:
    """Return by how much a sway at frequencies (F,) lowers the loss of every recording (R, F), each half with the sway
    that the other half shows.
    """
    recordings, out = np.arange(len(evidence.blocks)), []
    for some in np.array_split(hertz, len(hertz) // AT_ONCE + 1):
        grams = evidence.plain(_columns(last, candidate, some))
        own = [Gram(grams.rows * (evidence.of == k)[:, None, None, None]) for k in recordings]
        out.append([evidence.gain(gram).total for gram in own])
    return np.concatenate(out, axis=1)


def chance_of(gains: Float, near: np.ndarray, apart: int, most: int) -> float:
    """Return the p-value of what recordings gain together at the best frequency; `gains` (R, F) are those of each, of
    which those `near` (F,) count. Placebos, `most` of them at most, shift all recordings but the first by `apart`
    frequencies or more.
    """
    recordings, count = gains.shape
    shifts = np.arange(apart, count - apart + 1)
    if not shifts.size:
        return 1.0
    draws = min(most, shifts.size ** (recordings - 1) - 1)  # no more than differ
    drawn = np.random.default_rng(0).choice(shifts, size=(draws, recordings - 1))
    places = np.arange(count)[near]
    each = [gains[r][(places + drawn[:, [r - 1]]) % count] for r in range(1, recordings)]
    placebos = np.max(gains[0, places] + np.sum(each, axis=0), axis=1)
    as_good = int(np.count_nonzero(placebos >= np.max(gains[:, places].sum(axis=0))))
    return (1 + as_good) / (1 + draws)
