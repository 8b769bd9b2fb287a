"""The exact optimum for parameters the torque is linear in: SSE by QR, Huber by a semismooth Newton method.

Huber's loss is piecewise quadratic, so Newton steps on the samples inside δ end *exactly* once the set of
samples inside no longer changes. Everything happens in the whitened coordinates of `factor.py`, where the
problem is as well conditioned as it can be. Where columns depend on each other the smallest (scaled)
solution is returned and `data.factor.undetermined` names the parameters.
"""

from __future__ import annotations

import numpy as np

from exoid.optimisation.linear.loss import Bool, delta_rule, huber
from exoid.optimisation.linear.problem import LinearData
from exoid.symbolic.motion import Float

__all__ = ["delta_rule", "solve_huber", "solve_sse"]

MAX_STEPS = 200


def solve_sse(data: LinearData) -> Float:
    """Return the parameters (P,) with the smallest sum of squared residuals."""
    factor = data.factor
    linear = factor.backward @ (factor.basis.T @ data.vector)
    # One step of refinement: what the first solution lost to rounding is in its residual.
    missed = data.vector - data.matrix @ linear
    return linear + factor.backward @ (factor.basis.T @ missed)


def solve_huber(data: LinearData, delta: Float, start: Float | None = None) -> Float:
    """Return the parameters (P,) with the smallest Huber loss for thresholds `delta` (J,) in N·m.

    `start` (P,) is a first guess; default the SSE solution. Thresholds may be infinite (that joint is then
    SSE).
    """
    factor = data.factor
    if factor.rank == 0:
        return np.zeros(data.matrix.shape[1])
    first = solve_sse(data) if start is None else np.asarray(start, dtype=float)
    limit = np.repeat(np.asarray(delta, dtype=float), data.tau.shape[1])
    centre = factor.forward @ first
    residual = data.vector - factor.basis @ centre
    step_total, residual = _newton(factor.basis, residual, limit)
    linear = factor.backward @ (centre + step_total)
    return _polish(data, linear, delta, limit)


def _newton(basis: Float, residual: Float, limit: Float) -> tuple[Float, Float]:
    """Return the sum of steps in z from the point with `residual`, and the residual at the optimum."""
    total = np.zeros(basis.shape[1])
    inside = np.abs(residual) <= limit
    scale = float(np.linalg.norm(np.minimum(np.abs(residual), limit))) or 1.0
    for _ in range(MAX_STEPS):
        slope = basis.T @ np.clip(residual, -limit, limit)
        if np.linalg.norm(slope) <= 1e-15 * scale:
            break
        step = _direction(basis, inside, slope)
        along = basis @ step
        length = _line_search(residual, along, limit)
        total += length * step
        residual = residual - length * along
        now = np.abs(residual) <= limit
        if length == 1.0 and np.array_equal(now, inside):
            break
        inside = now
    return total, residual


def _direction(basis: Float, inside: Bool, slope: Float) -> Float:
    """Return the Newton step; damped where too few samples are inside to determine every direction."""
    # QᵀQ = 1, so the part of the samples outside is cheaper to subtract: there are few of them.
    outer = basis[~inside]
    curvature = np.eye(basis.shape[1]) - outer.T @ outer
    size, axes = np.linalg.eigh(curvature)
    return np.asarray(axes @ ((axes.T @ slope) / np.maximum(size, 1e-6)))


def _line_search(residual: Float, along: Float, limit: Float) -> float:
    """Return t > 0 that minimises the loss of residual - t·along; exactly 1.0 where that is good enough."""

    def slope(t: float) -> float:
        return float(along @ np.clip(residual - t * along, -limit, limit))

    start, full = slope(0.0), slope(1.0)
    if abs(full) <= 0.3 * abs(start):
        return 1.0
    low, high = (1.0, 2.0) if full > 0.0 else (0.0, 1.0)
    while slope(high) > 0.0 and high < 1e9:
        low, high = high, 2.0 * high
    for _ in range(30):
        middle = 0.5 * (low + high)
        here = slope(middle)
        if abs(here) <= 1e-3 * abs(start):
            return middle
        low, high = (middle, high) if here > 0.0 else (low, middle)
    return 0.5 * (low + high)


def _polish(data: LinearData, linear: Float, delta: Float, limit: Float) -> Float:
    """Remove what summing steps lost to rounding: one Newton step from the true residual, if it helps."""
    factor = data.factor
    residual = data.vector - data.matrix @ linear
    slope = factor.basis.T @ np.clip(residual, -limit, limit)
    better = linear + factor.backward @ _direction(factor.basis, np.abs(residual) <= limit, slope)
    improved = huber(data.residual(better), delta) <= huber(data.residual(linear), delta)
    return better if improved else linear
