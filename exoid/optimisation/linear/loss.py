"""Loss of a model against the measurement, as one number.

    SSE    Σ r²                       r = τ - YΦ, summed over samples and joints
    Huber  Σ r²            |r| ≤ δ    like SSE for small misses,
           Σ 2δ(|r| - δ/2) |r| > δ    linear for large ones, so that a knock does not bend the whole fit

Huber is written without branches: with c = min(|r|, δ) each term is c(2|r| - c); δ = ∞ gives SSE. Source: the
paper's equations (14) to (16); all four cases of (16) are the sum of the two joints' terms.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from exoid.symbolic.motion import Float

Bool = NDArray[np.bool_]

MOST_WEIGHT = 100.0
"""Weight of a joint, of the least of the others, at most: one that fits perfectly must not be all that counts."""
OUTLIER_SHARE = 0.14
"""The paper's rule: δ leaves this share of the samples of each joint outside."""


def huber(residual: Float, delta: Float) -> float:
    """Return the Huber loss of `residual` (J, N) in N·m with thresholds `delta` (J,); (N·m)²."""
    return float(np.sum(huber_terms(np.abs(residual), np.asarray(delta, dtype=float)[:, None])))


def huber_terms(size: Float, delta: Float | float) -> Float:
    """Return the term of each residual of these sizes; `delta` has a shape that goes with theirs."""
    inner = np.minimum(size, delta)
    return np.asarray(inner * (2.0 * size - inner))


def delta_rule(residual: Float, share: float = OUTLIER_SHARE, use: Bool | None = None) -> Float:
    """Return per joint the threshold (J,) that the share `share` of its residuals (J, N) exceeds.

    Only samples marked in `use` (J, N) count. A joint that fits perfectly (or has no sample) would get δ =
    0 and a loss that no longer sees it, so δ has a floor far below anything measurable.
    """
    size = np.abs(residual)
    usable = np.ones(size.shape, dtype=bool) if use is None else use
    delta = np.array([np.quantile(s[u], 1.0 - share) if u.any() else 0.0 for s, u in zip(size, usable, strict=True)])
    floor = 1e-9 * max(1.0, float(size.max(initial=0.0)))
    return np.asarray(np.maximum(delta, floor))


def joint_weights(delta: Float) -> Float:
    """Return the weight (J,) of each joint's misses, the inverse of its threshold `delta` (J,) in parts of their
    geometric mean: what is left of a joint that is modelled badly then does not bend the others.

    Weighted least squares by the deviation of each joint is usual for arms (Gautier, Poignet, Extended Kalman filtering
    and weighted least squares dynamic identification of robot, 2001).
    """
    held = np.maximum(delta, np.max(delta) / MOST_WEIGHT)
    return np.asarray(np.exp(np.mean(np.log(held))) / held)
