"""Least squares of a dozen numbers none of which can be negative.

The active-set method of Lawson and Hanson (Solving Least Squares Problems, 1974, chapter 23) on the normal equations;
the last numbers are those of the columns themselves. Enough for shares of power; a certificate, whose columns are
nearly dependent, asks SciPy's `nnls`, which is the check on it in the tests: importing `scipy.optimize` takes 0.5 s of
processor, a twelfth of `discover` on a leg.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]
ROUNDING = 1e-12
"""Slope, relative to the sizes of column and side, up to which a number stays at zero."""


def non_negative(columns: Float, side: Float) -> tuple[Float, float]:
    """Return x (P,) ≥ 0 that minimises |columns x - side| for columns (N, P) and a side (N,), and that distance."""
    size = np.linalg.norm(columns, axis=0)
    columns = columns / np.where(size > 0.0, size, 1.0)
    gram, slope, free = columns.T @ columns + ROUNDING * np.eye(size.size), columns.T @ side, size > 0.0
    least = ROUNDING * float(np.linalg.norm(side))

    def fitted() -> Float:
        out = np.zeros(size.size)
        out[free] = np.linalg.solve(gram[free][:, free], slope[free])
        return out

    # Most that are positive without a bound are so with one: beginning with these saves most of the steps.
    x = fitted()
    while (x[free] <= 0.0).any():
        free &= x > 0.0
        x = fitted()
    for _ in range(3 * size.size):
        rise = np.where(free, 0.0, slope - gram @ x)
        if not (rise > least).any():
            break
        free[rise.argmax()] = True
        while ((wanted := fitted())[free] <= 0.0).any():
            # As far as the first number that would become negative, which then stays at zero.
            falling = free & (wanted <= 0.0)
            way = (x[falling] / np.maximum(x[falling] - wanted[falling], 1e-300)).min()
            x = x + way * (wanted - x)
            free &= x > ROUNDING * x.max(initial=0.0)
            x = np.where(free, x, 0.0)
        x = wanted
    x[free] = np.maximum(np.linalg.lstsq(columns[:, free], side, rcond=None)[0], 0.0)
    return x / np.where(size > 0.0, size, 1.0), float(np.linalg.norm(columns @ x - side))
