"""The lag between two clocks, judged by physics: what one file logged must follow from the motion in the other.

Torques, and angles that both files have, are regressed on functions of the motion (accelerations, weight, friction and
their products, of either sign, so that no convention needs to be known) at every lag; the lag that leaves least is the
answer, its interval comes from leaving out one eighth of the time after the other (delete-a-group jackknife).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exoid.ground.ties import index_of_least, order_of
from exoid.measurement.signals.butterworth import both_ways, low_pass_filter
from exoid.symbolic.motion import Float

STEP, CUTOFF = 0.05, 5.0
"""s and Hz: 20 Hz carry what a 5 Hz low-pass leaves."""
MOST_SECONDS, WIDEST, LEAST_SECONDS = 300.0, 60.0, 5.0
GROUPS = 8
QUANTILE = 2.365
"""Of Student's t with seven degrees of freedom, 97.5 %."""
FITS, SHARP = 0.5, 0.2
"""Share of the power that may be left, and width of the interval in s, for the lag to count as determined."""
FLOOR = 1e-3
"""s; half the width of an interval is never said to be less."""


@dataclass(frozen=True)
class Lag:
    """The other clock reads `value` s more at the same instant, 95 % [`low`, `high`]; `left` is the share of the other
    file's power that the motion does not explain. `why` says why it is not determined ("" where it is)."""

    value: float
    low: float
    high: float
    left: float
    why: str = ""


def lag_between(t: Float, q: Float, other_t: Float, other: Float, most: float = WIDEST) -> Lag:
    """Return the lead of the clock `other_t` (M,) of signals `other` (M, K) over `t` (N,) of angles `q` (N, J).

    Times in s, strictly increasing; at most `most` s to either side are tried.
    """
    nothing = Lag(0.0, -np.inf, np.inf, 1.0, "the recordings are too short")
    a, b = _even(t, q), _even(other_t, other)
    if a is None or b is None:
        return nothing
    (ta, motion), (tb, signals) = a, b
    signals = signals[:, signals.std(axis=0) > 1e-9]
    columns = _columns(motion)
    if not signals.shape[1] or motion.std(axis=0).max() < 0.01:
        return Lag(0.0, -np.inf, np.inf, 1.0, "there is no motion or no torque to go by")
    signals = (signals - signals.mean(axis=0)) / signals.std(axis=0)
    shortest = max(LEAST_SECONDS, 0.5 * min(ta[-1] - ta[0], tb[-1] - tb[0]))
    tried = np.arange(-most, most + STEP, STEP)
    left = np.array([_left(_sums(ta, columns, tb, signals, lag, shortest)) for lag in tried])
    if not np.isfinite(left).any():
        return nothing
    best = index_of_least(left, 1.0)
    around = tried[best] + np.arange(-0.06, 0.0601, 0.004)
    sums = [_sums(ta, columns, tb, signals, lag, shortest) for lag in around]
    value = _lowest(around, np.array([_left(entry) for entry in sums]))
    parts = []
    for out in range(GROUPS):
        kept = [None if item is None else _without(item, out) for item in sums]
        parts.append(_lowest(around, np.array([_left(element) for element in kept])))
    spread = np.sqrt((GROUPS - 1) / GROUPS * np.sum((np.array(parts) - np.mean(parts)) ** 2))
    half = max(FLOOR, QUANTILE * float(spread))
    least = float(left[best])
    near = np.abs(tried - tried[best]) < 0.3
    rivals = np.flatnonzero(~near & (left < 1.3 * least + 0.02) & _valleys(left))
    why = ""
    if least > FITS:
        why = f"the motion explains only {1 - least:.0%} of what the other file holds"
    elif rivals.size:
        shown = ", ".join(f"{tried[k]:.2f} s" for k in rivals[order_of(left[rivals], 1.0)][:3])
        why = f"the motion repeats itself: lags of {value:.2f} s and of {shown} fit alike"
    elif 2 * half > SHARP:
        why = f"the lag is known only to {half:.2f} s"
    elif best in (0, tried.size - 1):
        why = f"the lag is {most:g} s or more"
    return Lag(value, value - half, value + half, least, why)


def _even(t: Float, values: Float) -> tuple[Float, Float] | None:
    """Return (clock, values) smoothed on a uniform clock, at most the first five minutes; None where too short."""
    good = np.isfinite(t) & np.isfinite(values).all(axis=1)
    t, values = t[good], values[good]
    if t.size < 50 or t[-1] - t[0] < LEAST_SECONDS:
        return None
    fine = np.arange(t[0], min(t[-1], t[0] + MOST_SECONDS), 0.01)
    rows = np.column_stack([np.interp(fine, t, column) for column in values.T])
    smooth = both_ways(low_pass_filter(2, CUTOFF / 50.0), rows, 9)
    return fine[::5], smooth[::5]


def _columns(q: Float) -> Float:
    """Return functions (N, P) of the motion of which torques, and angles, are made up."""
    dq = np.gradient(q, STEP, axis=0)
    ddq = np.gradient(dq, STEP, axis=0)
    total, apart = q.sum(axis=1), q[:, 0] - q[:, -1]
    c, s = np.cos(q[:, -1:]), np.sin(q[:, -1:])
    weight = [f(x) for x in (*q.T, total, apart) for f in (np.sin, np.cos)]
    parts = [ddq, dq, np.tanh(dq / 0.05), q, c * ddq, s * dq**2, s * dq[:, :1] * dq[:, -1:], np.column_stack(weight)]
    out = np.column_stack([*parts, np.ones(len(q))])
    size = np.abs(out).max(axis=0)
    return np.asarray(out / np.where(size > 0, size, 1.0))


Sums = tuple[Float, Float, Float]


def _sums(t: Float, columns: Float, other_t: Float, other: Float, lag: float, shortest: float) -> Sums | None:
    """Return the sums of squares and products of each group of rows at one lag; None where too little overlaps."""
    at = t + lag
    inside = (at >= other_t[0]) & (at <= other_t[-1])
    if inside.sum() * STEP < shortest:
        return None
    rows = columns[inside]
    wanted = np.column_stack([np.interp(at[inside], other_t, column) for column in other.T])
    cuts = np.linspace(0, len(rows), GROUPS + 1).astype(int)[1:-1]
    pieces = list(zip(np.split(rows, cuts), np.split(wanted, cuts), strict=True))
    return (
        np.array([a.T @ a for a, _ in pieces]),
        np.array([a.T @ b for a, b in pieces]),
        np.array(
            [np.column_stack([(b**2).sum(axis=0), b.sum(axis=0), np.full(b.shape[1], len(b))]) for _, b in pieces]
        ),
    )


def _without(sums: Sums, group: int) -> Sums:
    gram, product, plain = (np.delete(part, group, axis=0) for part in sums)
    return gram, product, plain


def _left(sums: Sums | None) -> float:
    """Return the mean share of the variance that the best combination of the columns leaves, NaN for None."""
    if sums is None:
        return float("nan")
    gram, product, plain = (part.sum(axis=0) for part in sums)
    weights = np.linalg.solve(gram + 1e-8 * np.trace(gram) / len(gram) * np.eye(len(gram)), product)
    power, total, count = plain.T
    variance = np.maximum(power - total**2 / count, 1e-12)
    left = power - 2 * np.sum(weights * product, axis=0) + np.sum(weights * (gram @ weights), axis=0)
    return float(np.mean(np.maximum(left, 0.0) / variance))


def _lowest(lags: Float, left: Float) -> float:
    """Return the lag at which the parabola through the least of `left` and its neighbours is lowest."""
    k = index_of_least(left, 1.0)
    if not 0 < k < lags.size - 1 or not np.isfinite(left[k - 1 : k + 2]).all():
        return float(lags[k])
    below, here, above = left[k - 1 : k + 2]
    bend = below - 2 * here + above
    return float(lags[k] + (0.5 * (below - above) / bend if bend > 0 else 0.0) * (lags[1] - lags[0]))


def _valleys(left: Float) -> np.ndarray:
    """Return a mask (N,) of the places at which the curve is lower than on both sides."""
    inner = np.where(np.isfinite(left), left, np.inf)
    out = np.zeros(left.size, dtype=bool)
    out[1:-1] = (inner[1:-1] <= inner[:-2]) & (inner[1:-1] <= inner[2:])
    return out
