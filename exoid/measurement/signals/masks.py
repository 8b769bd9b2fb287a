"""Samples that do not count: runs of them, wider runs, straight lines across."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exoid.symbolic.motion import Float

Mask = NDArray[np.bool_]


def widen(mask: Mask, samples: int) -> Mask:
    """Return `mask` (N,) grown by `samples` on either side."""
    if samples <= 0 or not mask.any():
        return mask
    kernel = np.ones(2 * samples + 1)
    return np.convolve(mask.astype(float), kernel, mode="same")[: mask.size] > 0.5


def straight(x: Float, hidden: Mask) -> Float:
    """Return `x` (N,) with straight lines across the samples `hidden` (N,)."""
    if not hidden.any() or hidden.all():
        return x
    at = np.arange(x.size)
    out = x.copy()
    out[hidden] = np.interp(at[hidden], at[~hidden], x[~hidden])
    return out


def straight_columns(x: Float, hidden: Mask) -> Float:
    """Return `x` (N, J) with straight lines across the samples `hidden` (N, J), column by column."""
    return np.column_stack([straight(column, bad) for column, bad in zip(x.T, hidden.T, strict=True)])
