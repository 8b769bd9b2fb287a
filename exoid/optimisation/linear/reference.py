"""The same problem solved by IPOPT through CasADi: an independent second opinion on the optimum.

IPOPT sees the residual and the branch-free Huber loss c(2|r| - c) in parameters scaled column by column; it
does not see our QR. The loss is continuously differentiable with a piecewise constant Hessian, which CasADi
derives, so IPOPT's Newton steps end in a handful of iterations without slack variables.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import numpy as np

from exoid.ground.plain import AsJson
from exoid.optimisation.linear.loss import huber
from exoid.optimisation.linear.problem import LinearData
from exoid.symbolic.motion import Float

SILENT_IPOPT: Any = {
    "ipopt.print_level": 0,
    "ipopt.sb": "yes",
    "print_time": False,
    "ipopt.option_file_name": "",
}
"""IPOPT says nothing, and reads no `ipopt.opt` of the current folder, which could load a library or write files."""
OPTIONS: Any = {
    **SILENT_IPOPT,
    "ipopt.tol": 1e-11,
    "ipopt.acceptable_tol": 1e-11,
    "ipopt.max_iter": 200,
    "ipopt.nlp_scaling_method": "none",
}


@dataclass(frozen=True, eq=False)
class Reference(AsJson):
    """Result of IPOPT: parameters `x` (P,), their `loss` (recomputed by us), its word."""

    x: Float
    loss: float
    iterations: int
    seconds: float
    status: str
    gap: float | None = None


def solve_reference(data: LinearData, delta: Float) -> Reference:
    """Solve the Huber problem of `data` for thresholds `delta` (J,) with IPOPT from zero; infinite ones give SSE."""
    import casadi as ca

    began = time.perf_counter()
    scale = column_scale(data)
    x = ca.MX.sym("x", scale.size)
    problem: Any = {"x": x, "f": loss_expression(data, delta, x, scale)}
    solver = ca.nlpsol("reference", "ipopt", problem, OPTIONS)
    found = np.asarray(solver(x0=np.zeros(scale.size))["x"]).reshape(-1) * scale
    return ended_at(found, solver, huber(data.residual(found), delta), began)


def ended_at(x: Float, solver: Any, loss: float, began: float) -> Reference:
    """Result of `solver`, begun at the clock's `began` s: parameters `x` (P,) and their loss."""
    stats = solver.stats()
    return Reference(x, loss, int(stats["iter_count"]), time.perf_counter() - began, str(stats["return_status"]))


def column_scale(data: LinearData) -> Float:
    """Return the size (P,) of each parameter at which its column alone is as long as the torque."""
    length = np.linalg.norm(data.matrix, axis=0)
    return np.where(length > 0.0, np.linalg.norm(data.vector) / np.where(length > 0.0, length, 1.0), 1.0)


def loss_expression(data: LinearData, delta: Float, x: Any, scale: Float) -> Any:
    """Return the loss of parameters `x` (CasADi, in units of `scale`), divided by its value at zero.

    So IPOPT's absolute tolerances mean relative ones.
    """
    import casadi as ca

    limit = np.repeat(np.asarray(delta, dtype=float), data.tau.shape[1])
    residual = ca.DM(data.vector) - ca.sparsify(ca.DM(data.matrix * scale)) @ x
    size = huber(data.tau, delta) or 1.0
    if np.isinf(limit).all():
        return ca.sumsqr(residual) / size
    miss = ca.fabs(residual)
    inner = ca.fmin(miss, ca.DM(np.minimum(limit, 1e300)))
    return ca.dot(inner, 2 * miss - inner) / size
