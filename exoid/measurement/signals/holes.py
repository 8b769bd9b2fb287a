"""Samples that are missing: where they are, and the cubic across them."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exoid.symbolic.motion import Float

MISSING_STEPS, HOLE_STEPS, BRIEF_HOLE = 1.9, 2.5, 0.02
"""Median steps between samples from which one is missing; from which angles are, unless it is as brief as so many s:
the cubic across it is then as good as measured."""
BESIDE = 0.05
"""Seconds on either side of a hole from which its ends are taken."""


def interpolated(grid: Float, t: Float, x: Float, step: float, wide: float) -> tuple[Float, NDArray[np.bool_]]:
    """Return the signal logged as `x` (M,) at times `t`, usually `step` s apart, on the `grid` (N,), and a mask of
    holes of more than `wide` s. Across missing samples goes the cubic that continues level and slope on either side.
    """
    if t.size < 2:
        return np.zeros(grid.size), np.ones(grid.size, dtype=bool)
    after = np.clip(np.searchsorted(t, grid, side="right"), 1, t.size - 1)
    apart, off = t[after] - t[after - 1], np.minimum(np.abs(grid - t[after - 1]), np.abs(t[after] - grid)) > 1e-3 * step
    outside = (grid > t[-1] + 0.5 * step) | (grid < t[0] - 0.5 * step)
    hole = outside | (off & (apart > wide))
    out = np.interp(grid, t, x)
    inside = off & ~outside & (apart > MISSING_STEPS * step) & (grid > t[0]) & (grid < t[-1])
    if inside.any():
        ends, which = np.unique(after[inside], return_inverse=True)
        width = t[ends] - t[ends - 1]
        at = (grid[inside] - t[ends - 1][which]) / width[which]
        before, behind = (_end(t, x, step, last, side) for last, side in ((ends - 1, -1), (ends, 1)))
        (level, rise), (goal, fall) = ((each[0][which], each[1][which] * width[which]) for each in (before, behind))
        out[inside] = (
            level * (2 * at**3 - 3 * at**2 + 1) + rise * (at**3 - 2 * at**2 + at)
            + goal * (3 * at**2 - 2 * at**3) + fall * (at**3 - at**2)
        )  # fmt: skip
    return out, hole


def _end(t: Float, x: Float, step: float, last: NDArray[np.int_], side: int) -> tuple[Float, Float]:
    """Return level and slope (H,) of `x` (M,) at its samples `last`, by parabolas through those on their `side`."""
    count = max(5, round(BESIDE / step))
    rows = np.clip(last[:, None] + side * np.arange(count), 0, t.size - 1)
    ago = (t[rows] - t[last][:, None]) / (count * step)
    near = (np.abs(ago) <= 1.5).astype(float)  # what lies beyond another hole has no part
    powers = ago[:, :, None] ** np.arange(3) * near[:, :, None]
    gram = np.swapaxes(powers, 1, 2) @ powers + 1e-9 * np.eye(3)
    found = np.linalg.solve(gram, np.swapaxes(powers, 1, 2) @ (x[rows] * near)[:, :, None])[:, :, 0]
    return found[:, 0], found[:, 1] / (count * step)
