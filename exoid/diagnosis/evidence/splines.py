"""Cubic and other B-splines as columns: a smooth curve without physics is a sum of them.

(SciPy's are the check on them in the tests; importing them takes 0.3 s, and `discover` 1.4 s on the demo's recordings.)
"""

from __future__ import annotations

import numpy as np

from exoid.symbolic.motion import Float


def spline_columns(x: Float, knots: Float, order: int = 3) -> Float:
    """Return the B-splines (N, M) of degree `order` over `knots` (M + order + 1,) at `x` (N,), which lies within the
    inner ones (de Boor 1972).
    """
    count = len(knots) - order - 1
    last = np.clip(np.searchsorted(knots, x, side="right") - 1, order, count - 1)
    # Only order + 1 of them are not zero at a place; each degree follows from the one below.
    parts = [np.ones(len(x))]
    for degree in range(1, order + 1):
        right = [knots[last + 1 + k] - x for k in range(degree)]
        left = [x - knots[last - k] for k in range(degree)]
        shares = [part / (right[k] + left[degree - 1 - k]) for k, part in enumerate(parts)]
        rising = [left[degree - 1 - k] * share for k, share in enumerate(shares)]
        falling = [right[k] * share for k, share in enumerate(shares)]
        parts = [a + b for a, b in zip([*falling, np.zeros(len(x))], [np.zeros(len(x)), *rising], strict=True)]
    out = np.zeros((len(x), count))
    out[np.arange(len(x))[:, None], last[:, None] - order + np.arange(order + 1)] = np.stack(parts, axis=1)
    return out
