"""Samples of one clock at the instants of another."""

from __future__ import annotations

import numpy as np

from exoid.symbolic.motion import Float

WIDEST_STEP = 2.5
"""In median steps: a hole of the source wider than this is a hole of the result."""
FASTER = 1.5
"""Rate of the source over that of the target from which samples are averaged, so that nothing is folded down."""


def onto(instants: Float, t: Float, values: Float) -> Float:
    """Return `values` (N,) logged at `t` (N,) at other `instants` (M,), NaN where there is none.

    Between two samples on a straight line; where the source is much faster, the mean over one step of the target.
    Stamps and values that are not finite, and stamps that do not run forwards, are passed over.
    """
    good = np.isfinite(t) & np.isfinite(values)
    good[good] &= np.r_[True, np.diff(np.maximum.accumulate(t[good])) > 0]
    t, values = t[good], values[good]
    out = np.full(instants.shape[0], np.nan)
    if t.size < 2 or instants.size < 2:
        return out
    step, pace = float(np.median(np.diff(t))), float(np.median(np.diff(instants)))
    inside = (instants >= t[0]) & (instants <= t[-1])
    right = np.clip(np.searchsorted(t, instants[inside]), 1, t.size - 1)
    near = (t[right] - t[right - 1] <= WIDEST_STEP * step) | np.isin(instants[inside], t)
    at = instants[inside]
    if pace > FASTER * step:
        total = np.r_[0.0, np.cumsum(0.5 * (values[1:] + values[:-1]) * np.diff(t))]
        low, high = np.maximum(at - 0.5 * pace, t[0]), np.minimum(at + 0.5 * pace, t[-1])
        width = np.maximum(high - low, 1e-12)
        found = (_area(high, t, values, total) - _area(low, t, values, total)) / width
    else:
        found = np.interp(at, t, values)
    out[inside] = np.where(near, found, np.nan)
    return out


def _area(at: Float, t: Float, values: Float, total: Float) -> Float:
    """Return the integral from t[0] to `at` of the line through the samples."""
    left = np.clip(np.searchsorted(t, at, side="right") - 1, 0, t.size - 2)
    along = at - t[left]
    slope = (values[left + 1] - values[left]) / (t[left + 1] - t[left])
    return np.asarray(total[left] + along * (values[left] + 0.5 * slope * along))
