"""Does the base oscillate at one frequency, with an amplitude and a phase of its own in each recording?

Whoever starts a recorder does not ask the stand for its phase. At a given frequency the torque of the sway is linear in
its sine and cosine parts, so each recording can have its own, and only the frequency is searched. The model's numbers
are those of all fitted recordings. Each recording is judged by halves: one half with the sway that the other half
shows.

A sway shifted in time is the same sway with another phase, so time-shifted placebos cannot say what is chance here.
These placebos are shifted in frequency, each recording by another amount: what has no line of its own that all
recordings share gains as much from a frequency in one and a neighbouring one in another.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate, candidate_columns
from exoid.diagnosis.evidence.fitted import FittedModel, pooled_rms
from exoid.diagnosis.evidence.gain import RecordingEvidence
from exoid.diagnosis.evidence.swinging import advice_at, swinging
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.ties import least_of
from exoid.optimisation.fitting.phases import phases_of
from exoid.symbolic.effect_catalogue import find_effect
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate
from exoid.symbolic.term import Term, places_of

ENTRY = "base_motion"
NEAR, FINE = 0.25, 4
"""Part of a frequency about it in which that of the sway is searched: swings of the machine itself bend the line that
it leaves; and frequencies per reciprocal duration."""
MOST = 100
"""Frequencies to either side of it at most, for speed: of a long recording the line is sharp."""
ASIDE, APART = 2, 2.0
"""Times that part to which placebos reach, and how far they are shifted at least, in reciprocal durations."""
ROUNDS = 2
"""Times that the model's numbers are fitted: the torque of the sway is proportional to the masses."""


@dataclass(frozen=True, eq=False)
class OwnSway:
    """A sway at `hertz` whose sine and cosine parts are `parts` (R, 4) m/s², forwards and upwards, in each recording.

    `before` and `after` (J,) N·m are the errors on the motion by which a model is judged, `p_value` the share of
    placebos that gain as much, the sway itself counted among them.
    """

    hertz: float
    parts: Float
    before: Float
    after: Float
    p_value: float

    @property
    def nodes(self) -> Float:
        """The only node (R, 1, 2) of the catalogue's entry: this frequency, and the phases."""
        return np.column_stack([np.full(len(self.parts), self.hertz), phases_of(self.parts)])[:, None]

    @property
    def amplitudes(self) -> Float:
        """Amplitudes (R, 2) in m/s², forwards and upwards."""
        return np.hypot(self.parts[:, ::2], self.parts[:, 1::2])

    @property
    def parameters(self) -> dict[str, Estimate]:
        """Frequency and amplitudes, the latter with their range over the recordings."""
        out = {"f": Estimate("f", self.hertz, "Hz", self.hertz, self.hertz)}
        for name, each in zip(("forward", "upward"), self.amplitudes.T, strict=True):
            out[name] = Estimate(name, float(np.median(each)), "m/s²", float(each.min()), float(each.max()))
        return out

    @property
    def share(self) -> float:
        """Share of the squared error that it explains, of all joints together."""
        return float(1.0 - np.sum(self.after**2) / max(float(np.sum(self.before**2)), 1e-300))

    @property
    def advice(self) -> str:
        """Advice to the person who measures."""
        return advice_at(self.hertz)

    @property
    def words(self) -> str:
        """Say what it is."""
        forward, upward = np.median(self.amplitudes, axis=0)
        return (
            f"at {self.hertz:.3g} Hz, {forward:.2g} m/s² forwards and {upward:.2g} m/s² upwards, with a phase of its "
            "own in every recording"
        )


def own_sway(last: FittedModel, noise: Float, rules: Rules = RULES) -> OwnSway | None:
    """Return the sway that explains most of what `last` leaves beyond the `noise` (J,), N·m; None for none."""
    swing = swinging(last) if np.any(last.evaluation_rms > rules.near_noise * noise) else None
    effect, model = find_effect(ENTRY), last.model
    if swing is None or model.moving_base or any(term.effect.id == ENTRY for term in model.terms):
        return None
    if not places_of(effect, model.joints):
        return None
    lasts = [float(item.t[-1] - item.t[0]) for item in last.prepared.all]
    step = 1.0 / (FINE * max(lasts))
    count = min(MOST, int(NEAR * swing.hertz / step))
    tried = _within(swing.hertz, step, count)
    candidate = Candidate(Term(effect, None, model.joints), np.zeros((1, 1, 2)), False)
    blocks = last.evidence(seed=0, draws=0).blocks
    known = {float(f): _read(last, blocks, candidate, float(f)).known for f in tried}
    if not known:
        return None
    found = _read(last, blocks, candidate, least_of(known, lambda f: known[f][0]))
    for finer in (step / 3.0, step / 9.0):
        about = [_read(last, blocks, candidate, found.hertz + side * finer) for side in (-1.0, 1.0)]
        found = least_of([found, *about], lambda one: one.cost)
    for _ in range(ROUNDS - 1):
        numbers = replace(last.fit, linear=last.linear + found.change[: len(last.linear)])
        found = _read(replace(last, fit=numbers), blocks, candidate, found.hertz)
    judged = slice(len(last.prepared.train), None) if last.verified else slice(None)
    before, after = last.evaluation_rms, pooled_rms(found.left[judged], last.prepared.all[judged])
    whole, left = (float(np.sum(np.maximum(rms**2 - noise**2, 0.0))) for rms in (before, after))
    if left > (1.0 - rules.half) * whole:
        return None
    wide = _within(swing.hertz, step, ASIDE * count)
    known |= {f: _read(last, blocks, candidate, f).known for f in map(float, wide) if f not in known}
    gains = np.array([known[f][1] for f in map(float, wide)]).T
    near, apart = np.isin(wide, tried), int(np.ceil(APART / (min(lasts) * step)))
    return OwnSway(found.hertz, np.array(found.parts), before, after, chance_of(gains, near, apart, rules.placebos))


def _within(hertz: float, step: float, count: int) -> Float:
    """Return the frequencies about `hertz` that a sway may have, `count` to either side."""
    shape, frequencies = find_effect(ENTRY).shape["f"], np.array([hertz + k * step for k in range(-count, count + 1)])
    return frequencies[(frequencies >= shape.min) & (frequencies <= shape.max)]


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


@dataclass(frozen=True, eq=False)
class _Reading:
    """The model with a sway at one frequency: squared error of the fitted recordings, the change of the model's
    numbers, and of every recording the columns (J, K, 4) of the sway, its weights, and what it must explain (J, K).
    """

    hertz: float
    cost: float
    change: Float
    swings: list[Float]
    weights: list[Float]
    blocks: Sequence[RecordingEvidence]

    @property
    def wanted(self) -> list[Float]:
        """Residual (J, K) of the changed model in every recording, sway included."""
        return [block.residual - block.columns @ self.change for block in self.blocks]

    @property
    def parts(self) -> list[Float]:
        """Sine and cosine parts (4,) of the sway in every recording."""
        each = zip(self.swings, self.wanted, self.weights, strict=True)
        return [_solved(_flat(swing, weight), (wanted * weight).ravel()) for swing, wanted, weight in each]

    @property
    def known(self) -> tuple[float, list[float]]:
        """The cost, and by how much the weighted squared error of every recording falls, each half by the other."""
        each = zip(self.wanted, self.left, self.weights, strict=True)
        falls = [float(np.sum((wanted * w) ** 2) - np.sum((left * w) ** 2)) for wanted, left, w in each]
        return self.cost, falls

    @property
    def left(self) -> list[Float]:
        """Residual (J, K) of every recording, with the sway of each half as the other half shows it taken off."""
        each = zip(self.swings, self.wanted, self.weights, strict=True)
        return [wanted - _by_halves(swing, wanted, weight) for swing, wanted, weight in each]


def _read(carrier: FittedModel, blocks: Sequence[RecordingEvidence], candidate: Candidate, hertz: float) -> _Reading:
    """Fit the model's numbers and the sway together; `blocks` are the recordings beside the model, `carrier` the masses
    that sway.
    """
    prepared, scale = carrier.prepared, np.maximum(carrier.train_rms, 1e-12)
    nodes, count = np.array([[hertz, 0.0]]), len(prepared.train)
    swings = [candidate_columns(candidate, nodes, item, carrier).full(0, len(scale)) for item in prepared.all]
    weights = [block.use / scale[:, None] for block in blocks]
    rows, rest = [], []
    for swing, block, weight in zip(swings[:count], blocks, weights, strict=False):
        both = _flat(np.concatenate([block.columns, block.residual[:, :, None]], axis=2), weight)
        own = _flat(swing, weight)
        both = both - own @ _solved(own, both)  # whatever sway it has of its own
        rows.append(both[:, :-1])
        rest.append(both[:, -1])
    change = _solved(np.concatenate(rows), np.concatenate(rest))
    cost = float(sum(np.sum((y - x @ change) ** 2) for x, y in zip(rows, rest, strict=True)))
    return _Reading(hertz, cost, change, swings, weights, blocks)


def _by_halves(swing: Float, wanted: Float, weight: Float) -> Float:
    """Return the torque (J, K) of the sway, in each half of a recording as the other half shows it."""
    out, middle = np.zeros_like(wanted), wanted.shape[1] // 2
    for item, other in ((slice(0, middle), slice(middle, None)), (slice(middle, None), slice(0, middle))):
        parts = _solved(_flat(swing[:, other], weight[:, other]), (wanted * weight)[:, other].ravel())
        out[:, item] = swing[:, item] @ parts
    return out


def _flat(columns: Float, weight: Float) -> Float:
    """Return weighted columns (J·K, m) of columns (J, K, m)."""
    return (columns * weight[:, :, None]).reshape(-1, columns.shape[2])


def _solved(columns: Float, wanted: Float) -> Float:
    """Return the least-squares solution, columns of any size and of none."""
    length = np.linalg.norm(columns, axis=0)
    length[length == 0.0] = 1.0
    even = columns / length
    found = np.linalg.pinv(even.T @ even, rcond=1e-12, hermitian=True) @ (even.T @ wanted)
    return np.asarray(found / (length if found.ndim == 1 else length[:, None]))
