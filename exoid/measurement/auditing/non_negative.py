"""Non-negative least squares of a dozen numbers: smaller than what SciPy's takes to be imported."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exoid.symbolic.motion import Float

ROUNDING = 1e-10
"""Relative slope, and square of a column, up to which a number stays at zero."""


def non_negative(gram: Float, slope: Float, either: int = 0) -> Float:
    """Return x (P,) ≥ 0 that minimises x·gram·x - 2 x·slope (Lawson, Hanson: Solving least squares problems, 1974).

    The first `either` of them may be negative as well.
    """
    size = np.sqrt(np.maximum(np.diagonal(gram), 1e-300))
    gram, slope = gram / np.outer(size, size), slope / size
    if either:  # they are what the others leave to them
        beside = gram[:either, either:]
        solved = np.linalg.lstsq(gram[:either, :either], np.column_stack([beside, slope[:either]]), rcond=1e-12)[0]
        by_others, alone = solved[:, :-1], solved[:, -1]
        left = gram[either:, either:] - beside.T @ by_others
        own = np.diagonal(left) > ROUNDING  # what the first numbers contain already stays at zero
        rest = np.zeros(own.size)
        rest[own] = non_negative(left[np.ix_(own, own)], (slope[either:] - beside.T @ alone)[own])
        return np.asarray(np.concatenate([alone - by_others @ rest, rest]) / size)

    def least_squares(free: NDArray[np.bool_]) -> Float:
        out = np.zeros(slope.size)
        out[free] = np.linalg.lstsq(gram[np.ix_(free, free)], slope[free], rcond=1e-12)[0]
        return out

    # Most that are positive without a bound are so with one: beginning with these takes half as long as with none.
    x, free = np.zeros(slope.size), np.ones(slope.size, dtype=bool)
    while free.any() and not ((x := least_squares(free)) > 0.0)[free].all():
        free &= x > 0.0
    x = np.where(free, x, 0.0)
    least = ROUNDING * float(np.abs(slope).max(initial=0.0))
    for _ in range(3 * slope.size):
        rise = np.where(free, -np.inf, slope - gram @ x)
        best = int(np.argmax(rise))
        if rise[best] <= least:
            break
        free[best] = True
        while free.any():
            wanted = least_squares(free)
            below = free & (wanted <= 0.0)
            if not below.any():
                x = wanted
                break
            # As far as the first number that would become negative, which then stays at zero.
            way = float(np.min(x[below] / np.maximum(x[below] - wanted[below], 1e-300)))
            x = np.maximum(x + way * (wanted - x), 0.0)
            free &= x > 1e-14 * float(x.max(initial=0.0))
            x = np.where(free, x, 0.0)
    return np.asarray(x / size)
