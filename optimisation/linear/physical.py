"""The best fit that some leg could have: positive masses and inertias, friction that brakes, effects of their sign.

Least squares may answer with a leg that cannot exist: a negative viscosity, inertias no positive mass has. Here the
same loss is minimised over the parameters that can. That set is convex, so the answer has a proof again:

    bounds    low ≤ Φ_p ≤ high for every parameter that has them
    masses    [[Φ2, Φ3], [Φ3, Φ1 - Φ2]] ⪰ m 1  and  [[Φ2, Φ3], [Φ3, Φ1 - Φ2 + Φ4]] ⪰ m 1

The two matrix inequalities say Φ3²/Φ2 ≤ Φ1 - Φ2 + min(0, Φ4), which holds exactly for what positive m, l, I give (see
`plausibility`), and make M(θ) positive definite in every posture. The margin m keeps it from being nearly singular.

IPOPT solves it. The proof is ours. Every vector v makes vᵀF(Φ)v ≥ 0 a condition linear in Φ, as a bound is one; with
multipliers λ ≥ 0 of such conditions gₖ(Φ) ≥ 0 and any u with |u_i| ≤ 2δ_i and Ȳᵀu + Σ λₖ ∇gₖ = 0,

    Σ (u τ - u²/4) - Σ λₖ gₖ(0)

is a lower bound of the loss of every possible leg (Fenchel and Lagrange duality). The multipliers come from a
non-negative least-squares fit to the gradient at the claimed optimum, not from the solver.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from optimisation.fitting.assemble import FittableModel, is_paper_leg
from optimisation.linear.certificate import Certificate, fenchel, ratio
from optimisation.linear.loss import huber
from optimisation.linear.problem import LinearData
from optimisation.linear.reference import OPTIONS, Reference, column_scale, loss_expression
from optimisation.linear.solve import solve_huber, solve_sse
from symbolic.motion import Float

MARGIN = 1e-4
"""Least eigenvalue of the two mass matrices, kg·m²."""
ACTIVE = 1e-5
"""Relative distance to a condition up to which it may have a multiplier."""
PROVEN = 1e-7
"""Relative duality gap up to which it is proven: usually 1e-11; where masses all but vanish, IPOPT ends near 1e-8."""
ANGLES = 33
"""Vectors v tried around the one a matrix inequality is tightest for: they take up what rounding leaves."""


@dataclass(frozen=True, eq=False)
class Inequality:
    """A 2×2 matrix [[a, b], [b, c]] ⪰ MARGIN·1 with a, b, c linear in Φ; each is a row (P,)."""

    name: str
    a: Float
    b: Float
    c: Float

    def matrix(self, linear: Float) -> Float:
        """Return the matrix (2, 2) at `linear`, the margin taken off."""
        a, b, c = (float(row @ linear) for row in (self.a, self.b, self.c))
        return np.array([[a - MARGIN, b], [b, c - MARGIN]])

    def condition(self, v: Float) -> tuple[Float, float]:
        """Return the row (P,) and the constant of vᵀF(Φ)v ≥ 0, linear in Φ."""
        row = v[0] ** 2 * self.a + 2.0 * v[0] * v[1] * self.b + v[1] ** 2 * self.c
        return row, -MARGIN * float(v @ v)


@dataclass(frozen=True, eq=False)
class Physics:
    """What is possible for a model: `low`, `high` (P,), and matrix inequalities."""

    names: tuple[str, ...]
    low: Float
    high: Float
    inequalities: tuple[Inequality, ...]

    def conditions(self, linear: Float) -> list[tuple[str, Float, float]]:
        """Return (name, row, constant) of every linear condition row·Φ + constant ≥ 0 that is tight near `linear`."""
        out: list[tuple[str, Float, float]] = []
        size = np.maximum(np.abs(linear), 1e-3 * np.max(np.abs(linear), initial=1e-9))
        for p, name in enumerate(self.names):
            unit = np.zeros(linear.size)
            unit[p] = 1.0
            if linear[p] - self.low[p] <= ACTIVE * size[p]:
                out.append((name, unit, -float(self.low[p])))
            if self.high[p] - linear[p] <= ACTIVE * size[p]:
                out.append((name, -unit, float(self.high[p])))
        for one in self.inequalities:
            matrix = one.matrix(linear)
            value, vectors = np.linalg.eigh(matrix)
            tight = ACTIVE * max(abs(value[1]), MARGIN)
            turn = np.arctan2(vectors[1, 0], vectors[0, 0])
            steps = np.concatenate([[0.0], 10.0 ** np.linspace(-9.0, 0.0, ANGLES // 2)])
            # All round as well: a matrix that is all but zero is tight for every v.
            every = np.linspace(0.0, np.pi, ANGLES, endpoint=False)
            for angle in np.unique(np.concatenate([turn + steps, turn - steps, every])):
                v = np.array([np.cos(angle), np.sin(angle)])
                if v @ matrix @ v <= tight:
                    out.append((one.name, *one.condition(v)))
        return out

    def broken(self, linear: Float) -> tuple[str, ...]:
        """Return the names of what `linear` (P,) violates."""
        out = [n for n, x, a, b in zip(self.names, linear, self.low, self.high, strict=True) if not a <= x <= b]
        out += [i.name for i in self.inequalities if np.linalg.eigvalsh(i.matrix(linear))[0] < 0.0]
        return tuple(out)

    def inside(self, linear: Float) -> Float:
        """Return `linear` put back inside: bounds exactly, matrices by adding as little inertia as rounding needs."""
        out = np.clip(linear, self.low, self.high)
        at = {name: p for p, name in enumerate(self.names)}
        for _ in range(8):
            least = min((float(np.linalg.eigvalsh(i.matrix(out))[0]) for i in self.inequalities), default=0.0)
            if least >= 0.0:
                break
            push = 1.5 * abs(least) + 1e-16
            out[at["Phi2"]] += push
            out[at["Phi1"]] += 2.0 * push
        return out


def physics(model: FittableModel) -> Physics:
    """Return what is possible for `model`: the bounds of its parameters, and of its masses where it has Φ1 to Φ4."""
    names = tuple(p.name for p in model.parameters)
    low = np.array([-np.inf if p.min is None else p.min for p in model.parameters], dtype=float)
    high = np.array([np.inf if p.max is None else p.max for p in model.parameters], dtype=float)
    if any(f"Phi{k}" not in names for k in range(1, 5)) or not is_paper_leg(model):
        return Physics(names, low, high, ())
    one, two, three, four = (np.array([float(n == f"Phi{k}") for n in names]) for k in range(1, 5))
    low[names.index("Phi3")] = max(low[names.index("Phi3")], 0.0)
    return Physics(
        names,
        low,
        high,
        (
            Inequality("Phi1 to Phi3: no positive masses", two, three, one - two),
            Inequality("Phi1 to Phi4: no positive masses", two, three, one - two + four),
        ),
    )


@dataclass(frozen=True, eq=False)
class Held:
    """What asking for a possible leg changed: the parameters without it (P,), what they violated, and its price.

    `cost` is the relative rise of the loss; 0 where the free optimum was possible already.
    """

    free: Float
    broken: tuple[str, ...]
    cost: float

    def to_json(self, names: Sequence[str]) -> dict[str, Any]:
        """Return the fields in plain types."""
        free = dict(zip(names, map(float, self.free), strict=True))
        return {"violated": list(self.broken), "cost": self.cost, "parameters_without": free}


def solve_physical(data: LinearData, delta: Float, possible: Physics, start: Float | None = None) -> Float:
    """Return the possible parameters (P,) of least loss; those of the free optimum where it is possible."""
    free = solve_sse(data) if np.isinf(delta).all() else solve_huber(data, delta, start)
    return free if not possible.broken(free) else physical_reference(data, delta, possible, free).x


def physical_reference(data: LinearData, delta: Float, possible: Physics, start: Float) -> Reference:
    """Solve the problem with its conditions by IPOPT, from `start` (P,); infinite thresholds give SSE."""
    import casadi as ca

    began = time.perf_counter()
    scale = column_scale(data)
    x = ca.MX.sym("x", scale.size)
    conditions, lower = [], []
    for one in possible.inequalities:
        a, b, c = (ca.DM(row * scale).T @ x for row in (one.a, one.b, one.c))
        unit = max(abs(float(one.a @ start)), abs(float(one.c @ start)), 10.0 * MARGIN)
        conditions += [(a - MARGIN) / unit, (c - MARGIN) / unit, ((a - MARGIN) * (c - MARGIN) - b * b) / unit**2]
        lower += [0.0, 0.0, 0.0]
    problem: Any = {"x": x, "f": loss_expression(data, delta, x, scale), "g": ca.vertcat(*conditions)}
    options = {**OPTIONS, "ipopt.max_iter": 500, "ipopt.bound_relax_factor": 0.0, "ipopt.tol": 1e-13}
    solver = ca.nlpsol("physical", "ipopt", problem, options)
    first = possible.inside(np.asarray(start, dtype=float))
    answer = solver(
        x0=first / scale, lbx=possible.low / scale, ubx=possible.high / scale, lbg=lower, ubg=[np.inf] * len(lower)
    )
    stats = solver.stats()
    found = np.asarray(answer["x"]).reshape(-1) * scale
    for bound in (possible.low, possible.high):  # an interior point ends a hair inside
        found = np.where(np.abs(found - bound) <= 1e-10 * scale, bound, found)
    found = possible.inside(found)
    return Reference(
        x=found,
        loss=huber(data.residual(found), delta),
        iterations=int(stats["iter_count"]),
        seconds=time.perf_counter() - began,
        status=str(stats["return_status"]),
    )


def certify_physical(
    data: LinearData, linear: Float, delta: Float, possible: Physics, *, tolerance: float = PROVEN, scope: str = ""
) -> Certificate:
    """Return the Certificate of a claimed optimum `linear` (P,) among the possible ones; `delta` (J,), ∞ means SSE.

    A claim outside the possible set gets an infinite gap.
    """
    from scipy.optimize import nnls

    residual = data.residual(linear).reshape(-1)
    limit = np.repeat(np.asarray(delta, dtype=float), data.tau.shape[1])
    basis, backward = data.factor.basis, data.factor.backward
    score = np.clip(residual, -limit, limit)
    known = possible.conditions(linear)
    rows = np.array([row for _, row, _ in known]).reshape(len(known), linear.size)
    pull = rows @ backward  # the conditions' gradients in whitened coordinates
    size = np.linalg.norm(pull, axis=1)
    pull = pull / np.where(size > 0.0, size, 1.0)[:, None]
    wanted = -2.0 * (basis.T @ score)
    # Both enter the gap: what the multipliers leave of the gradient, times |z|, and what they put on slack conditions.
    slack = np.array([float(row @ linear) + constant for _, row, constant in known])
    waste = slack / np.where(size > 0.0, size, 1.0) / max(float(np.linalg.norm(data.factor.forward @ linear)), 1e-300)
    equations, right = np.vstack([pull.T, waste]), np.append(wanted, 0.0)
    weight: Float = np.asarray(nnls(equations, right)[0]) if known else np.zeros(0)
    part: float
    u, part = _feasible(basis, 2.0 * score, 2.0 * limit, -(pull.T @ weight) if known else np.zeros(data.factor.rank))
    weight = weight * part / np.where(size > 0.0, size, 1.0)
    left = basis.T @ u + (rows.T @ weight) @ backward
    primal = huber(data.residual(linear), delta)
    scale = max(primal, 1e-12 * huber(data.tau, delta), np.finfo(float).tiny)
    rounding = float(np.abs(left) @ np.abs(data.factor.forward @ linear))
    lack: float = fenchel(residual, u, limit) + float(weight @ np.maximum(slack, 0.0)) + rounding
    # A direction no data determine must not be pulled along: then nothing bounds the loss from below.
    loose = rows.T @ weight - data.factor.forward.T @ ((rows.T @ weight) @ backward)
    pulled = float(np.linalg.norm(rows.T @ weight))
    held = not weight.any() or float(np.linalg.norm(loose)) <= 1e-6 * pulled
    if possible.broken(linear) or not held:
        lack = np.inf
    return Certificate(
        primal=primal,
        dual=primal - lack,
        gap=lack / scale,
        kkt=ratio(np.linalg.norm(wanted - (pull.T @ (weight * size) if known else 0.0)), np.linalg.norm(2.0 * score)),
        infeasibility=ratio(np.linalg.norm(left), np.linalg.norm(u)),
        tolerance=tolerance,
        scope=scope or "all possible parameters",
    )


def _feasible(basis: Float, u: Float, bound: Float, target: Float) -> tuple[Float, float]:
    """Return u repaired so that Qᵀu = `target` to rounding and |u| ≤ `bound`, and the factor both were shrunk by."""
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
    over = np.abs(u) > bound
    shrink = float(np.min(bound[over] / np.abs(u[over]))) if over.any() else 1.0
    return u * shrink, shrink
