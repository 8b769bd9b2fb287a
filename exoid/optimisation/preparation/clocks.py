"""Do the clocks of angles and torques run at one rate? Judged by physics, without knowing the machine's numbers.

A torque that was logged by another clock comes later and later, or earlier and earlier: what the rigid machine leaves
of it then holds the torque's own derivative, times the time. A machine that changes meanwhile (it warms up, its sensor
drifts, it takes up a load midway) leaves something like it: what drifting numbers and zeros explain is taken out first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.measurement.finding import EVERY, Finding
from exoid.measurement.signals.conditioning import low_pass
from exoid.optimisation.linear.loss import Bool
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

CLOCKS = "clock_rate"
"""What the finding on them is called."""
GROUPS = 10
"""Parts of a recording that are left out one by one, which tells how far its clocks are known (jackknife)."""
CHANCE: Threshold = 1e-5
"""probability of such a difference where there is none: good recordings would be refused"""
APART: Threshold = 0.004
"""s over a recording by which clocks of different rates come apart: no answer depends on less"""
SHARE: Threshold = 0.1
"""share of what a rigid machine leaves that it explains: a missing effect happens to look so by a few hundredths"""
ALIKE: Threshold = 3.0
"""standard errors within which recordings have one clock: that of a single one would be put right, and no other"""
LEAST_SAMPLES = 200
STEPS, MOST, LATEST = 6, 0.05, 0.3
"""Times that a torque is read anew by the clock found; largest rate and delay (s) that are looked for."""
BAND = 3.0
"""Hz up to which the torque's own derivative is taken: noise in it would make the difference look smaller."""


@dataclass(frozen=True)
class ClockRate:
    """Excess speed of the torques' clock in one recording (`rate`, 0.002 is 0.2 %) with its standard `error`; the
    `share` that it explains of what is left, and how long the recording is. `late` is by how many s the torques come
    late in its middle.
    """

    name: str
    rate: float
    error: float
    share: float
    seconds: float
    late: float = 0.0


def clock_findings(base: Model, prepared: Sequence[PreparedRecording]) -> tuple[Finding, ...]:
    """A warning for each clock of torques that runs at another rate than the angles'.

    Friction that reverses late is a spike beside the model, and tells the clock; other spikes only add noise.
    """
    found = (clock_rate(base, _with_spikes(recording)) for recording in prepared)
    return tuple(map(_finding, clocks_apart([rate for rate in found if rate is not None])))


def clocks_apart(rates: Sequence[ClockRate]) -> tuple[ClockRate, ...]:
    """Clocks of torques that run at another rate than the angles': one for all recordings (`EVERY`), as one logger has
    it, or those of single ones where others contradict.
    """
    if not rates:
        return ()
    together, alone = _together(rates), tuple(item for item in rates if len(rates) > 1 and _is_apart(item, 1))
    alike = alone and all(abs(item.rate - together.rate) <= ALIKE * item.error for item in rates)
    return (together,) if alike or _is_apart(together, len(rates)) else alone


def _with_spikes(one: PreparedRecording) -> PreparedRecording:
    return one if one.read is None else one.without(np.zeros(one.hidden.shape, dtype=bool))


def _together(found: Sequence[ClockRate]) -> ClockRate:
    """The clock of all recordings."""
    weight = np.array([1.0 / item.error**2 for item in found])
    rates = np.array([entry.rate for entry in found])
    mean = float(weight @ rates / weight.sum())
    scatter = float(weight @ (rates - mean) ** 2 / max(1, len(found) - 1))
    error = float(np.sqrt(max(1.0, scatter) / weight.sum()))
    return ClockRate(
        EVERY, mean, error, float(np.median([element.share for element in found])),
        float(np.median([clock.seconds for clock in found])),
    )  # fmt: skip


def _is_apart(one: ClockRate, recordings: int) -> bool:
    if one.share < SHARE or abs(one.rate) * one.seconds < APART:
        return False
    return _no_chance(one.rate, one.error, recordings)


def _no_chance(value: float, error: float, recordings: int) -> bool:
    from scipy.special import stdtr

    return bool(2.0 * stdtr((GROUPS - 1) * recordings, -abs(value) / error) < CHANCE)


def _finding(one: ClockRate) -> Finding:
    apart, way = 1e3 * abs(one.rate) * one.seconds, "faster" if one.rate > 0.0 else "slower"
    what = f"the clock of the torques runs about {100 * abs(one.rate):.1g} % {way} "
    what += f"than that of the angles, {apart:.2g} ms in {one.seconds:.3g} s"
    remedy = "log angles and torques by one clock, or correct the times of one of them in a copy by what both clocks "
    remedy += "show at two events far apart, such as knocks against the machine"
    consequence = "a torque that comes later and later, or earlier, looks like friction that changes"
    return Finding(CLOCKS, "warning", what, one.name, one.rate, None, remedy, consequence, "likely")


def clock_rate(base: Model, one: PreparedRecording) -> ClockRate | None:
    """Clock rate of one recording; None where it is too short, or nothing is driven.

    Where the clocks come far apart a derivative is not enough: the torque is read at the rate found so far, and again.
    What they explain is told as they stand, how far they are known as they are read last.
    """
    motion, use = one.motion, one.used & one.driven[:, None]
    if use.sum() < LEAST_SAMPLES:
        return None
    own = _own_columns(one, base.columns(motion))
    middle = 0.5 * float(motion.t[0] + motion.t[-1])
    found = ClockRate(one.name, 0.0, np.inf, 0.0, 0.0)
    for number in range(STEPS):
        at = middle + (motion.t - middle) * (1.0 - found.rate) + found.late
        torque = np.column_stack([np.interp(at, motion.t, column) for column in one.wide_tau.T])
        if (step := _step(one, own, torque, use)) is None:
            return None
        rate, late = found.rate + step.rate, found.late + step.late
        if abs(rate) > MOST or abs(late) > LATEST:
            return None
        found = replace(step, rate=rate, late=late, share=found.share if number else step.share)
        # One that explains too little is of no use to anybody, however far it is off.
        if abs(step.rate) < step.error or found.share < SHARE:
            return found
    # What the last step still changed is not known either.
    assert step is not None
    return replace(found, error=float(np.hypot(step.error, step.rate)))


def _step(one: PreparedRecording, own: Float, torque: Float, use: Bool) -> ClockRate | None:
    """Return by how much faster the clock of a `torque` (N, J) runs and how late it is, to first order."""
    wanted = one.smooth(torque)
    size = np.array([y[u].std() if u.any() else 0.0 for y, u in zip(wanted, use, strict=True)])
    weight = np.where(use & (size > 0.0)[:, None], 1.0 / np.where(size > 0.0, size, 1.0)[:, None], 0.0)
    rows = np.concatenate([own, _late_columns(one, torque), wanted[:, :, None]], axis=2) * weight[:, :, None]
    parts = np.array_split(rows, GROUPS, axis=1)
    sums = np.array([np.tensordot(part, part, ((0, 1), (0, 1))) for part in parts])
    grams, products, square = sums[:, :-1, :-1], sums[:, :-1, -1], float(sums[:, -1, -1].sum())
    scale = np.sqrt(np.diagonal(grams.sum(axis=0)))
    known = scale > 0.0
    if not known[-2:].all():
        return None
    grams = grams[:, known][:, :, known] / np.outer(scale[known], scale[known])
    products = products[:, known] / scale[known]

    gram, product = grams.sum(axis=0), products.sum(axis=0)
    # All of it first, then without each part.
    inverse = np.linalg.pinv(np.concatenate([gram[None], gram - grams]), rcond=1e-10, hermitian=True)
    numbers = (inverse @ np.concatenate([product[None], product - products])[..., None])[..., 0]
    left = max(square - float(product @ numbers[0]), 0.0)
    gain = float(numbers[0, -1] ** 2 / max(inverse[0, -1, -1], 1e-300))
    (early, rate), *each = numbers[:, -2:] / scale[-2:]
    error = float(np.sqrt((GROUPS - 1) * np.var([rate for _, rate in each])))
    if not error > 0.0 or not left + gain > 0.0:
        return None
    seconds = float(one.motion.t[-1] - one.motion.t[0])
    return ClockRate(one.name, float(rate), error, gain / (left + gain), seconds, -float(early))


def _own_columns(one: PreparedRecording, columns: Float) -> Float:
    """Return a model's `columns` (J, N, P) and each joint's zero, (J, K, P), all of them drifting with time, too."""
    t = one.motion.t
    zeros = np.broadcast_to(np.eye(columns.shape[0])[:, None], (columns.shape[0], len(t), columns.shape[0]))
    columns, drift = np.concatenate([columns, zeros], axis=2), np.linspace(-1.0, 1.0, len(t))[:, None]
    return one.smooth_columns(np.concatenate([columns, drift * columns, drift**2 * columns], axis=2))


def _late_columns(one: PreparedRecording, torque: Float) -> Float:
    """Columns that make a torque early, (J, K, 2): all the time alike, and by 1 s more in every s."""
    t = one.motion.t
    slope = np.gradient(low_pass(torque, min(BAND, 0.4 * one.rate), one.rate), axis=0).T * one.rate
    return one.smooth_columns(np.stack([slope, (t - 0.5 * (t[0] + t[-1])) * slope], axis=2))
