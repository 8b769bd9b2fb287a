"""Proof that a fit is the optimum, by our own arithmetic and not by a solver's status word.

For any u with Ȳᵀu = 0 and |u_i| ≤ 2δ_i, the number Σ (u τ - u²/4) is a lower bound of the Huber loss of
*every* parameter vector (Fenchel duality; δ = ∞: of the SSE). At the optimum u = 2 clip(r, δ) reaches the
loss itself. So the bound is built from the residual of the claimed optimum, repaired until it is feasible,
and compared:

    gap = Σ [h(r_i) - u_i r_i + u_i²/4] + |Ȳᵀu|·|Φ|      every term ≥ 0, so nothing cancels

A small relative gap certifies; a wrong optimum cannot get one. Where the parameters are held to conditions linear in
them, gₖ(Φ) ≥ 0, multipliers λ ≥ 0 join in (Fenchel and Lagrange duality): with Ȳᵀu + Σ λₖ ∇gₖ = 0

    Σ (u τ - u²/4) - Σ λₖ gₖ(0)

bounds the loss of all that fulfil them. The multipliers come from a non-negative least-squares fit to the gradient.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from exoid.ground.plain import AsJson
from exoid.optimisation.linear.loss import huber
from exoid.optimisation.linear.problem import LinearData
from exoid.symbolic.motion import Float

Condition = tuple[Float, float]
"""A row (P,) and a constant: row · Φ + constant ≥ 0."""
TOLERANCE = 1e-9
"""Relative duality gap up to which an optimum is called certified."""


@dataclass(frozen=True)
class Certificate(AsJson):
    """`primal` loss, lower bound `dual`, relative `gap`, relative `kkt` residual, `infeasibility` of the
    bound.

    `kkt` is |Qᵀ clip(r, δ)| / |clip(r, δ)|: the cosine between the clipped residual and what the model could
    still explain. `holds` says whether the gap is at most `tolerance`. `scope` says for what it holds.
    """

    primal: float
    dual: float
    gap: float
    kkt: float
    infeasibility: float
    tolerance: float
    scope: str = "all parameters"

    @property
    def holds(self) -> bool:
        """True if the claimed optimum is proven."""
        return bool(self.gap <= self.tolerance)

    def __str__(self) -> str:
        word = "certified optimum" if self.holds else "NOT the optimum"
        return f"{word} ({self.scope}): relative gap {self.gap:.1e}, KKT residual {self.kkt:.1e}"

    def _json(self) -> dict[str, Any]:
        return {**super()._json(), "holds": self.holds}


def certify(
    data: LinearData,
    linear: Float,
    delta: Float,
    conditions: Sequence[Condition] = (),
    *,
    tolerance: float = TOLERANCE,
    scope: str = "all parameters",
    possible: bool = True,
) -> Certificate:
    """Return the Certificate of a claimed optimum `linear` (P,); `delta` (J,) in N·m, ∞ means SSE.

    The optimum is that among parameters which fulfil `conditions`, of which those count that are tight at `linear`;
    where it is not `possible` itself the gap is infinite.
    """
    residual = data.residual(linear).reshape(-1)
    limit = np.repeat(np.asarray(delta, dtype=float), data.tau.shape[1])
    basis, forward, backward = data.factor.basis, data.factor.forward, data.factor.backward
    score = np.clip(residual, -limit, limit)
    rows = np.array([row for row, _ in conditions]).reshape(len(conditions), linear.size)
    pull = rows @ backward  # the conditions' gradients in whitened coordinates
    size = np.linalg.norm(pull, axis=1)
    unit = np.where(size > 0.0, size, 1.0)
    pull = pull / unit[:, None]
    wanted = -2.0 * (basis.T @ score)
    # Both enter the gap: what the multipliers leave of the gradient, times |z|, and what they put on slack conditions.
    slack = np.array([float(row @ linear) + constant for row, constant in conditions])
    waste = slack / unit / max(float(np.linalg.norm(forward @ linear)), 1e-300)
    # What pulls along a direction that no data determine must vanish altogether.
    blind = (rows - (rows @ backward) @ forward) / unit[:, None]
    if data.factor.rank == linear.size:
        blind = blind[:, :0]
    equations, right = np.vstack([pull.T, waste, blind.T]), np.concatenate([wanted, np.zeros(1 + blind.shape[1])])
    weight = _multipliers(equations, right) if conditions else np.zeros(0)
    u, part = _feasible(basis, 2.0 * score, 2.0 * limit, -(pull.T @ weight))
    weight = weight * part
    kkt = ratio(np.linalg.norm(wanted - pull.T @ weight), np.linalg.norm(2.0 * score))
    weight = weight / unit
    pulled = rows.T @ weight
    left = basis.T @ u + pulled @ backward
    primal = huber(data.residual(linear), delta)
    rounding = float(np.abs(left) @ np.abs(forward @ linear))
    lack: float = fenchel(residual, u, limit) + float(weight @ np.maximum(slack, 0.0)) + rounding
    # A direction no data determine must not be pulled along: then nothing bounds the loss from below.
    loose = pulled - forward.T @ (pulled @ backward)
    if not possible or float(np.linalg.norm(loose)) > 1e-6 * float(np.linalg.norm(pulled)):
        lack = np.inf
    # The scale keeps a perfect fit (loss at rounding level) from being measured by the digits of its rounding.
    scale = max(primal, 1e-12 * huber(data.tau, delta), np.finfo(float).tiny)
    return Certificate(
        primal=primal,
        dual=primal - lack,
        gap=lack / scale,
        kkt=kkt,
        infeasibility=ratio(np.linalg.norm(left), np.linalg.norm(u)),
        tolerance=tolerance,
        scope=scope,
    )


def _multipliers(equations: Float, right: Float) -> Float:
    """Return the multipliers, none below zero, that come nearest to the equations."""
    from scipy.optimize import nnls

    return np.asarray(nnls(equations, right)[0])


def ratio(part: Any, whole: Any) -> float:
    """Return part/whole, 0 where there is nothing to be a part of."""
    return float(part / whole) if whole > 0.0 else 0.0


def _feasible(basis: Float, u: Float, bound: Float, target: Float) -> tuple[Float, float]:
    """Return the dual point repaired so that Qᵀu = `target` to rounding and |u| ≤ `bound`, and by what it was shrunk.

    First only the samples inside their bound move, since those on it belong there at an optimum. What then
    still violates is repaired by alternating projection, and last by shrinking, the target with it: a multiple of a
    feasible u is feasible.
    """
    free = np.abs(u) < bound
    inner = basis[free]
    curvature = inner.T @ inner
    for _ in range(3):
        u = u.copy()
        u[free] -= inner @ np.linalg.lstsq(curvature, basis.T @ u - target, rcond=1e-13)[0]
    for _ in range(20):
        if np.all(np.abs(u) <= bound):
            break
        u = np.clip(u, -bound, bound)
        u = u - basis @ (basis.T @ u - target)
    u = u - basis @ (basis.T @ u - target)
    size = np.abs(u)
    over = size > bound
    # Divided only where the bound is passed; zero rows (masked samples) and infinite bounds never are.
    shrink = float(np.min(bound[over] / size[over])) if over.any() else 1.0
    return u * shrink, shrink


def fenchel(residual: Float, u: Float, limit: Float) -> float:
    """Return Σ [h(r) - u r + u²/4], written so that each term is a sum of non-negative parts."""
    size = np.abs(residual)
    inside = size <= limit
    total = float(np.sum((residual[inside] - 0.5 * u[inside]) ** 2))
    outside = ~inside
    if outside.any():
        edge, beyond = limit[outside], size[outside] - limit[outside]
        short = 2.0 * edge - u[outside] * np.sign(residual[outside])
        total += float(np.sum(short * beyond + 0.25 * short**2))
    return total
