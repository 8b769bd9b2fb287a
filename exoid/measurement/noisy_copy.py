"""Is one recording another one, resampled, with noise added? Judged by whose the difference between the two is.

Two recordings of the same motion differ by the noise of both: half of the difference is in each, so where one is larger
by chance the other is not, and of the fast part of either only what the machine itself does comes again. In a copy the
whole difference was added to one of them: the other one's fast part, its noise included, stands in it at full size. So
the fast part of one is regressed on that of the other; in motion made again the slope falls short of one by half of the
difference's power, in a copy by nothing. And a copy has no tracking of its own: the difference is as small in the
slow part, where the motion is, as white noise of its size.
"""

from __future__ import annotations

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.ground.ties import index_of_greatest
from exoid.measurement.signals.butterworth import band_pass_filter, both_ways, low_pass_filter
from exoid.symbolic.motion import Float

BAND = (0.08, 0.25)
"""Part of the spectrum in which noise prevails, as shares of the slower sampling rate."""
BLOCK = 16
"""Samples that are weighed alike, so that the jolt of a reversal does not speak for all."""
EDGE = 4 * BLOCK
"""Samples at either end that are left out: there a filter answers to the end, not to the noise."""
LEAST, STRETCH, STRETCHES = 384, 1024, 3
"""Samples that are compared at least, and in how many stretches of which length the place is looked for."""
FAINT: Threshold = 0.35
"""likeness of fast parts from which it is asked: chance in 1024 samples reaches 0.24"""
SURE: Threshold = 20.0
"""twice the log-likelihood ratio of copy against motion made again: one in thousands is refused"""
OWN: Threshold = -9.0
"""the same of one channel alone, below which it has noise of its own: motion made again"""
WHOLE: Threshold = 0.15
"""by which the slope may fall short beyond its error: resampling blurs a copy"""
TRACKING: Threshold = 4.0
"""times the slow part that white noise has: a real machine never moves twice alike"""


def noisy_copy(t: Float, values: Float, copy_t: Float, copy: Float, offset: float) -> slice | None:
    """Return the samples of `copy` (M, C) at the times `copy_t` in which all channels are `values` (N, C) at the times
    `t`, with noise added, where `offset` makes the ones the others; None where they are not.
    """
    inside = np.flatnonzero((copy_t + offset >= t[0]) & (copy_t + offset <= t[-1]))
    if inside.size < LEAST:
        return None
    rows = slice(int(inside[0]), int(inside[-1]) + 1)
    slower = min(1.0, _rate(t) / _rate(copy_t))
    original = np.column_stack([np.interp(copy_t[rows] + offset, t, column) for column in values.T])
    told = [_evidence(x, y, slower) for x, y in zip(original.T, copy[rows].T, strict=True)]
    sure = sum(told) > SURE and min(told) > OWN
    return rows if sure else None


def _rate(t: Float) -> float:
    return 1.0 / float(np.median(np.diff(t)))


def offset_of(t: Float, values: Float, copy_t: Float, copy: Float) -> float | None:
    """Return the time to be added to `copy_t` for the fast parts to be most alike; None where they are not alike."""
    slow, quick = sorted((_rate(t), _rate(copy_t)))
    grids = [np.arange(x[0], x[-1], 1.0 / quick) for x in (t, copy_t)]
    if min(map(len, grids)) < LEAST:
        return None
    even = [
        np.column_stack([np.interp(grid, x, column) for column in table.T])
        for grid, x, table in zip(grids, (t, copy_t), (values, copy), strict=True)
    ]
    fast = [_levelled(_fast(table, slow / quick)) for table in even]
    swapped = len(fast[0]) < len(fast[1])
    short, long = fast if swapped else fast[::-1]
    size = min(STRETCH, len(short))
    for start in np.unique(np.linspace(0, len(short) - size, STRETCHES).astype(int)):
        for channel in reversed(range(short.shape[1])):  # torques first: their noise is larger
            found = _shift(short[start : start + size, channel], long[:, channel])
            if found is not None:
                samples = (found - start) * (-1 if swapped else 1)
                return float(grids[0][0] - grids[1][0] + samples / quick)
    return None


def _shift(part: Float, whole: Float) -> float | None:
    """Return the index in `whole` (N,), between samples, at which the stretch `part` (S,) is most alike; None where it
    is not.
    """
    length = 1 << (whole.size + part.size - 1).bit_length()
    product = np.fft.irfft(np.fft.rfft(whole, length) * np.conj(np.fft.rfft(part, length)), length)
    product = product[: whole.size - part.size + 1]
    power = np.concatenate([[0.0], np.cumsum(whole**2)])
    energy = (power[part.size :] - power[: -part.size]) * float(part @ part)
    like = np.abs(product) / np.sqrt(np.maximum(energy, max(1e-12 * float(energy.max()), 1e-300)))
    best = index_of_greatest(like, 1.0)
    if like[best] < FAINT:
        return None
    if not 0 < best < like.size - 1:
        return float(best)
    below, here, above = np.abs(product[best - 1 : best + 2])
    bend = below - 2.0 * here + above
    return float(best + (0.5 * (below - above) / bend if bend < 0.0 else 0.0))


def _fast(values: Float, slower: float) -> Float:
    band = 2.0 * np.array(BAND) * slower
    return both_ways(band_pass_filter(2, *map(float, band)), values - values.mean(axis=0), 0)


def _levelled(fast: Float) -> Float:
    """Return fast parts (N, C) of equal power everywhere: jolts come again with every period, noise only in a copy."""
    window = np.ones(BLOCK) / BLOCK
    power = np.column_stack([np.convolve(column, window, mode="same") for column in (fast**2).T])
    return np.asarray(fast / np.sqrt(np.maximum(power, 1e-300)))


def _evidence(original: Float, copy: Float, slower: float) -> float:
    """Return twice the log-likelihood ratio of one channel (N,): positive where `copy` is `original` and noise,
    negative where each has noise of its own, minus infinity where it cannot be a copy.
    """
    if not np.ptp(original) > 0.0 or not np.ptp(copy) > 0.0:
        return 0.0
    # The second: what the place is off by, less than a sample; the third: what interpolation blurs.
    speed = np.gradient(original)
    moving = np.column_stack([original - original.mean(), speed, np.gradient(speed), np.ones(original.size)])
    moving /= np.maximum(np.abs(moving).max(axis=0), 1e-300)
    x, y = moving @ np.linalg.lstsq(moving, copy, rcond=None)[0], copy
    apart = y - x
    size = float(np.abs(y).max())
    if float(np.abs(apart).max()) < 1e-9 * size:
        return 0.0
    fast_x, fast_y, fast_apart = _fast(np.column_stack([x, y, apart]), slower)[EDGE:-EDGE].T
    slow = both_ways(low_pass_filter(2, 2.0 * BAND[0] * slower), apart, 0)[EDGE:-EDGE]
    white = float(np.mean(_powers(fast_apart))) * BAND[0] / (BAND[1] - BAND[0])
    if float(np.mean(slow**2)) > TRACKING * white:
        return -np.inf
    weight = 1.0 / np.maximum(_powers(fast_x) + _powers(fast_y), 1e-300)
    power, product, noise = (
        float(np.sum(weight * _means(a * b)))
        for a, b in ((fast_x, fast_x), (fast_x, fast_y), (fast_apart, fast_apart))
    )
    if power <= 0.0:
        return 0.0
    short, expected = 1.0 - product / power, 0.5 * noise / power
    independent = 2.0 * (BAND[1] - BAND[0]) * slower * fast_x.size
    variance = max(2.0 * expected / independent, 1e-300)
    if short > WHOLE + 2.0 * np.sqrt(variance):
        return -np.inf
    return float(expected * (expected - 2.0 * short) / variance)


def _means(signal: Float) -> Float:
    """Return the mean of each BLOCK of a signal (N,)."""
    count = signal.size // BLOCK
    return np.asarray(signal[: count * BLOCK].reshape(count, BLOCK).mean(axis=1))


def _powers(signal: Float) -> Float:
    return _means(signal**2)
