"""Encoder angles that cannot be as they stand: jumps of a whole turn, single-sample spikes, holes."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exoid.symbolic.motion import Float

Mask = NDArray[np.bool_]
TURN = 2 * np.pi
LONG = 1_000_000
"""Samples from which on a running median is left to SciPy, whose import takes as long as the median of as many."""
MANY = 400_000
"""Samples of which quantiles are taken, at most."""


def fill(values: Float, valid: Mask) -> Float:
    """Return `values` (N,) with placeholders interpolated where `valid` (N,) is False."""
    if valid.all() or not valid.any():
        return values
    place = np.arange(values.shape[0])
    return np.interp(place, place[valid], values[valid])


def unwrapped(q: Float, valid: Mask) -> tuple[Float, Mask]:
    """Return the angle (N,) in rad without jumps of a whole turn, and where (N,) they were.

    Only a jump within half a radian of a whole turn counts, and only where the leg cannot have turned so far
    by itself.
    """
    at = np.flatnonzero(valid)
    jump = np.diff(q[at])
    wraps = np.zeros(q.shape[0], dtype=bool)
    if not jump.size or (jump.max() < 0.5 * TURN and jump.min() > -0.5 * TURN):
        return q, wraps
    turns = np.round(jump / TURN)
    usual = np.percentile(sampled(np.abs(jump)), 90)
    hit = (turns != 0) & (np.abs(jump - turns * TURN) < 0.5) & (usual < 1.0)
    # A turn gained and lost again at once is a spike, not a wrap.
    turns = np.where(hit, turns, 0.0)
    if not hit.any():
        return q, wraps
    wraps[at[1:][hit]] = True
    out = q.copy()
    out[at] -= TURN * np.r_[0.0, np.cumsum(turns)]
    return fill(out, valid), wraps


def angle_spikes(q: Float, valid: Mask) -> Mask:
    """Return a mask (N,) of one or two samples that stand far off the angle (N,) before and after them.

    Far is 12 robust deviations from the running median of five, 8 usual steps, and 0.5 % of the range of
    motion. A single sample needs only one and a half usual steps when its neighbours lie on one smooth curve
    without it.
    """
    out = np.zeros(q.shape[0], dtype=bool)
    at = np.flatnonzero(valid)
    if at.size < 20:
        return out
    values = q[at]
    off = np.abs(values - running_median(values, 5))
    spread = 1.4826 * float(np.median(sampled(off)))
    usual = float(np.percentile(sampled(np.abs(np.diff(values))), 90))
    reach = float(np.ptp(np.percentile(sampled(values), [1, 99])))
    far = off > max(12 * spread, 8 * usual, 0.005 * reach)
    far |= _needles(values, max(1.5 * usual, 0.005 * reach))
    # The edges have no two sides to compare with; and what happens more than once in twenty rows is no spike.
    far[:2] = far[-2:] = False
    if 0 < far.mean() < 0.05:
        out[at[far]] = True
    return out


def _needles(values: Float, least: float) -> Mask:
    """Return a mask (N,) of single samples that stand by more than `least` off the cubic through the two before and two
    after.

    Such a sample shows in the same way at its neighbours, two thirds as large and with the other sign; a step or a
    kink of the true motion does not.
    """
    out = np.zeros(values.shape[0], dtype=bool)
    off = values[2:-2] - (4.0 * (values[1:-3] + values[3:-1]) - values[:-4] - values[4:]) / 6.0
    size = np.abs(off)
    limit = max(least, 12 * 1.4826 * float(np.median(sampled(size))))
    before, at, after = off[:-2], off[1:-1], off[2:]
    sides = np.stack([before, after]) * -np.sign(at)
    out[3:-3] = (np.abs(at) > limit) & (sides.min(axis=0) > 0.4 * np.abs(at)) & (sides.max(axis=0) < 0.9 * np.abs(at))
    return out


def running_median(values: Float, width: int) -> Float:
    """Return the median over `width` (odd) samples around each of `values` (N,), edges held."""
    if values.size > LONG and np.isfinite(values).all():
        from scipy.ndimage import median_filter

        return np.asarray(median_filter(values, width, mode="nearest"), dtype=float)
    half = width // 2
    padded = np.pad(values, half, mode="edge")
    out = np.empty_like(values, dtype=float)
    # In blocks: a window view copied whole would take `width` times the memory of a long recording.
    for start in range(0, values.shape[0], 100_000):
        stop = min(start + 100_000, values.shape[0])
        window = np.lib.stride_tricks.sliding_window_view(padded[start : stop + 2 * half], width)
        out[start:stop] = np.partition(window, half, axis=1)[:, half]
    return out


def sampled(values: Float) -> Float:
    """Return some of `values` (N,), evenly spread and enough for a quantile."""
    return values[:: max(1, -(-values.size // MANY))]
