"""Time stamps that cannot be as they stand: repeated, out of order, restarted, or counted in another unit.

Nothing here invents a rate: stamps that are usable are used as they were logged (on the real rig, pretending
a uniform rate cost 0.095 -> 0.133 N·m).
"""

from __future__ import annotations

from bisect import bisect_left
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exoid.ground.thresholds import Threshold
from exoid.symbolic.motion import Float

ROUGH: Threshold = 0.05
"""digits of a clock, in steps between rows, below which they are fine: jitter is more"""
ONE_DIGIT: Threshold = 1.05
"""digits over which rounding moves a stamp: samples were lost, or the clock is uneven"""
COARSE: Threshold = 0.01
"""s between ticks that many rows share, spaced as if it was even: delays are named"""
Index = NDArray[np.int64]
Mask = NDArray[np.bool_]


@dataclass(frozen=True, eq=False)
class Order:
    """The order of rows: `order` (N,) is a permutation, `bad` (N,) marks rows whose stamp cannot be used."""

    order: Index
    bad: Mask
    kind: str
    """ "kept", "reversed", "sorted", "masked", "ticks" (several rows per stamp), "restart" or "constant"."""


def put_in_order(t: Float, usable: Mask) -> Order:
    """Return the order that puts rows with stamps `t` (N,) into strictly increasing time; `usable` (N,) are finite."""
    count = t.shape[0]
    order: Index = np.arange(count)
    kept = order[usable]
    bad = ~usable
    step = np.diff(t[kept])
    if step.size == 0 or np.all(step > 0):
        return Order(order, bad, "kept")
    if np.all(step == 0):
        return Order(order, bad, "constant")
    kind = "kept"
    if np.mean(step < 0) > 0.9:
        kind, order = "reversed", order[::-1].copy()
        kept, bad = order[usable[order]], bad[order]
        step = np.diff(t[kept])
        if np.all(step > 0):
            return Order(order, bad, kind)
    if np.all(step >= 0) and np.mean(step == 0) > 0.2:
        return Order(order, bad, "ticks")
    if kind == "kept" and usable.all():
        by_time = np.argsort(t, kind="stable")
        spread = np.diff(t[by_time])
        if np.abs(by_time - order).max() <= 20 and spread.min() > 0.3 * np.median(spread):
            return Order(by_time, bad, "sorted")
    chain = np.zeros(kept.size, dtype=bool)
    chain[longest_increasing(t[kept])] = True
    lost = int(kept.size - chain.sum())
    backward = -step[step < 0]
    if lost > max(20, 0.02 * count) and backward.size and backward.max() > 20 * np.median(np.abs(step)):
        return Order(order, bad, "restart")
    bad = bad.copy()
    bad[np.flatnonzero(usable[order])[~chain]] = True
    return Order(order, bad, "masked")


def longest_increasing(values: Float) -> Index:
    """Return the indices of a longest strictly increasing subsequence: the fewest rows have to be given
    up."""
    tails: list[float] = []
    holders: list[int] = []
    before = np.full(values.shape[0], -1, dtype=np.int64)
    for i, value in enumerate(values.tolist()):
        place = bisect_left(tails, value)
        if place == len(tails):
            tails.append(value)
            holders.append(i)
        else:
            tails[place], holders[place] = value, i
        before[i] = holders[place - 1] if place else -1
    chain = []
    at = holders[-1] if holders else -1
    while at >= 0:
        chain.append(at)
        at = int(before[at])
    return np.array(chain[::-1], dtype=np.int64)


def spread_ticks(t: Float) -> Float:
    """Return stamps (N,) in which rows that share one tick are spaced evenly up to the next tick."""
    first = np.flatnonzero(np.r_[True, np.diff(t) > 0])
    ends = np.r_[first, t.shape[0]]
    last = t[-1] + float(np.median(np.diff(t[first])))
    return np.interp(np.arange(t.shape[0]), ends, np.r_[t[first], last])


def even_behind(t: Float) -> Float | None:
    """Return evenly spaced stamps (N,) of which those of `t` are what a clock of too few digits shows; None where they
    vary by more than these digits, or by next to nothing.
    """
    steps = np.diff(t)
    moving = steps[steps > 0.0]
    if t.size < 10 or not moving.size:
        return None
    digit = float(moving.min())
    usual = float(t[-1] - t[0]) / (t.size - 1)
    whole = moving / digit
    if digit < ROUGH * usual or np.abs(whole - np.round(whole)).max() > 0.02 or np.ptp(steps) < 0.5 * digit:
        return None
    rows = np.arange(t.size)
    slope, first = np.polyfit(rows, t, 1)
    even = first + slope * rows
    return even if np.ptp(t - even) < ONE_DIGIT * digit else None


def fill_stamps(t: Float, bad: Mask) -> Float:
    """Return `t` (N,) with placeholders for `bad` stamps, on the line between their neighbours."""
    if not bad.any():
        return t
    place = np.arange(t.shape[0])
    good = place[~bad]
    out = np.interp(place, good, t[good])
    pace = float(np.median(np.diff(t[good])) / max(1.0, float(np.median(np.diff(good)))))
    head, tail = good[0], good[-1]
    out[:head] = t[head] - pace * (head - place[:head])
    out[tail + 1 :] = t[tail] + pace * (place[tail + 1 :] - tail)
    return out


def clock_unit(t: Float, q: Float) -> tuple[str, float]:
    """Return ("ms", 1e-3) or the like when stamps (N,) can only be a clock in that unit, ("s", 1) when they
    are seconds.

    Returns ("index", 1) for a plain count 0, 1, 2, ... which may be milliseconds or row numbers. A leg
    sampled less than twice a second would move wildly between rows; when the angles `q` (N, J) are smooth
    instead, the clock is not in s.
    """
    step = float(np.median(np.diff(t)))
    if 20_000.0 < t[0] < 80_000.0 and t[-1] - t[0] < 1.0:
        return "days", 86400.0  # as a spreadsheet counts them since 1900; under a second in s is no recording
    if step < 0.5:
        return "s", 1.0
    reach = np.ptp(q, axis=0)
    smooth = np.median(np.abs(np.diff(q, axis=0)), axis=0) < 0.05 * reach
    if not smooth.any():
        return "s", 1.0
    if np.all(np.diff(t) == 1.0):
        return "index", 1.0
    for unit, scale, most in (("ms", 1e-3, 200.0), ("µs", 1e-6, 2e5), ("ns", 1e-9, 2e8)):
        if step < most:
            return unit, scale
    return "s", 1.0


def epoch_unit(t: Float) -> tuple[str, float] | None:
    """Return ("ms", 1e-3) or the like where stamps (N,) count from 1970 and this century in that unit, else None."""
    finite = t[np.isfinite(t)]
    if finite.size < 2:
        return None
    with np.errstate(over="ignore", invalid="ignore"):  # stamps that are no times at all are refused further on
        middle, step = float(np.median(finite)), float(np.median(np.abs(np.diff(finite))))
    for unit, scale in (("s", 1.0), ("ms", 1e-3), ("µs", 1e-6), ("ns", 1e-9)):
        if 9.4e8 < middle * scale < 4.2e9 and 1e-5 < step * scale < 0.5:
            return unit, scale
    return None
