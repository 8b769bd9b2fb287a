"""The same design by IPOPT through CasADi, from several starts: a second opinion that follows gradients.

The extreme eigenvalues have kinks, so IPOPT minimises a smooth proxy with the power mean of all eigenvalues (tr
G^p)^(1/p) (tr G^-p)^(1/p), p = 4, then 16, then 64, each from the last result; the limits are linear in the
coefficients. The value reported is the true criterion of the motion found, stretched to its limits. The problem is not
convex, so the result is *best known*, never the optimum.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from exoid.optimisation.excitation.criteria import Aim
from exoid.optimisation.excitation.space import MotionSpace
from exoid.optimisation.linear.reference import SILENT_IPOPT
from exoid.symbolic.codegen.information import Information
from exoid.symbolic.codegen.information_code import products
from exoid.symbolic.motion import Float

GRID = 200
"""Samples per period that IPOPT sums over: with the mean sign of each cell cond(Ȳ) is within 0.2 % of a fine grid."""
SQUARINGS = (2, 4, 6)
"""The powers p = 4, 16, 64 as repeated squarings."""
SHRINK = 0.98
"""Starts are drawn in from the limits by this much, where an interior-point method begins."""
OPTIONS: Any = {
    **SILENT_IPOPT,
    "show_eval_warnings": False,
    "ipopt.max_iter": 150,
    "ipopt.tol": 1e-6,
    "ipopt.acceptable_tol": 1e-4,
    "ipopt.mu_init": 1e-3,
    "ipopt.jac_d_constant": "yes",
}


@dataclass(frozen=True, eq=False)
class MotionReference:
    """Ends of IPOPT from each start: swings (I, J, 2K), offsets (I, J), iterations and its last word (I,)."""

    swings: Float
    offsets: Float
    iterations: tuple[int, ...]
    statuses: tuple[str, ...]


def solve_motions(info: Information, space: MotionSpace, aim: Aim, criterion: str, starts: Float) -> MotionReference:
    """Minimise `criterion` from every one of the `starts` (I, n: points of `space`) and return where each ended."""
    swings, offsets = space.split(starts)
    factor = info.sums(swings, offsets, rescale=False).factor
    width = space.basis.shape[2]
    stages = [_solver(info, space, aim, criterion, s) for s in (SQUARINGS if criterion != "d_optimal" else (0,))]
    found, words, counts = [], [], []
    for y, scale in zip(starts, factor, strict=True):
        x = y.copy()
        x[: len(scale) * width] *= SHRINK * np.repeat(scale, width)
        count, status = 0, ""
        for solve, low, high in stages:
            result = solve(x0=x, lbg=low, ubg=high, p=_scales(info, space, x), lbx=-10.0, ubx=10.0)
            x = np.asarray(result["x"]).ravel()
            stats = solve.stats()
            count, status = count + int(stats["iter_count"]), str(stats["return_status"])
        found.append(x)
        counts.append(count)
        words.append(status)
    swing, offset = space.split(np.array(found))
    return MotionReference(swing, offset, tuple(counts), tuple(words))


def _scales(info: Information, space: MotionSpace, x: Float) -> Float:
    """Return the extreme eigenvalues at a start, by which the power means are scaled against overflow."""
    swing, offset = space.split(x[None])
    values = np.linalg.eigvalsh(info.sums(swing, offset, rescale=False).gram[0].sum(axis=0))
    return np.array([values[-1], max(values[0], 1e-12 * values[-1])])


def _solver(
    info: Information, space: MotionSpace, aim: Aim, criterion: str, squarings: int
) -> tuple[Any, Float, Float]:
    """Return IPOPT's solver of one stage, and the bounds of its constraints."""
    import casadi as ca

    x, scales = ca.MX.sym("x", space.size), ca.MX.sym("scales", 2)
    signals = _signals(ca, space, x)
    gram = _gram(ca, info, space.period, signals)
    size = len(info.names)
    if criterion == "condition":
        total = sum(gram[1:], gram[0])
        inverse = ca.solve(total, ca.DM.eye(size))
        goal = _power_mean(ca, total / scales[0], squarings) + _power_mean(ca, inverse * scales[1], squarings)
    else:
        weight = aim.noise.weight * aim.duration
        unit = ca.DM(np.where(aim.size > 0.0, aim.size, 1.0))
        weighed = [entry * float(w) for entry, w in zip(gram, weight, strict=True)]
        known = sum(weighed[1:], weighed[0]) * (unit @ unit.T)
        if criterion == "d_optimal":
            goal = -ca.log(ca.det(known))
        else:
            sized = np.flatnonzero(aim.size > 0.0).tolist()
            variances = ca.diag(ca.solve(known, ca.DM.eye(size)))[sized]
            most = ca.mmax(variances)
            goal = ca.log(most) + ca.log(ca.sum1((variances / most) ** (2**squarings))) / 2**squarings
    limits = np.repeat(space.limits, GRID, axis=0).reshape(-1, GRID, 4)
    lows = [np.concatenate([limit[:, 0], -limit[:, 2], -limit[:, 3]]) for limit in limits]
    highs = [np.concatenate([item[:, 1], item[:, 2], item[:, 3]]) for item in limits]
    constraints = ca.vertcat(*(signals[kind][joint] for joint in range(len(space.limits)) for kind in range(3)))
    problem = {"x": x, "f": goal, "g": constraints, "p": scales}
    return ca.nlpsol("design", "ipopt", problem, OPTIONS), np.concatenate(lows), np.concatenate(highs)


def _signals(ca: Any, space: MotionSpace, x: Any) -> list[list[Any]]:
    """Return angle, velocity and acceleration (each per joint, (GRID,)) as expressions of the search's numbers."""
    t = np.arange(GRID) * (space.period / GRID)
    w = np.arange(1, space.harmonics + 1) * (2.0 * np.pi / space.period)
    sine, cosine = np.sin(np.outer(t, w)), np.cos(np.outer(t, w))
    tables = (
        np.hstack([sine, cosine]),
        np.hstack([cosine * w, -sine * w]),
        np.hstack([-sine * w**2, -cosine * w**2]),
    )
    joints, width = len(space.limits), space.basis.shape[2]
    if space.centre is not None:
        offsets = [ca.MX(float(value)) for value in space.centre]
    else:
        zero = np.zeros((1, space.size))
        low = space.split(zero)[1][0]
        unit = zero.copy()
        unit[0, joints * width :] = 1.0
        slope = space.split(unit)[1][0] - low
        offsets = [float(low[j]) + float(slope[j]) * x[joints * width + j] for j in range(joints)]
    out = []
    for kind, table in enumerate(tables):
        swings = [ca.DM(table @ space.basis[j]) @ x[j * width : (j + 1) * width] for j in range(joints)]
        out.append([swing + offsets[j] if kind == 0 else swing for j, swing in enumerate(swings)])
    return out


def _gram(ca: Any, info: Information, period: float, signals: list[list[Any]]) -> list[Any]:
    """Return G_j (M, M) per joint as expressions."""
    entries, terms = products(info.model)
    joints = len(signals[0])
    state = ca.SX.sym("state", 1 + 3 * joints)
    half = 0.5 * period / GRID

    def mean_sign(speed: Any, pull: Any) -> Any:
        # As symbolic.gram.mean_sign, without its corners.
        return speed / ca.sqrt(speed**2 + (0.6 * half * pull) ** 2 + 1e-8)

    speeds, pulls = state[1 + joints : 1 + 2 * joints], state[1 + 2 * joints :]
    signs = ca.vertcat(*(mean_sign(speeds[j], pulls[j]) for j in range(joints)))
    numbers = ca.DM(np.concatenate([info.linear, info.shape]))
    sample = ca.Function("sample", [state], [terms(ca.vertcat(state, signs), numbers)], {"cse": True})
    t = ca.DM(np.arange(GRID) * (period / GRID))
    states = ca.horzcat(t, *(signals[kind][joint] for kind in range(3) for joint in range(joints))).T
    sums = ca.sum2(sample.map(GRID)(states)) / GRID
    size = len(info.names)
    out = [ca.MX.zeros(size, size) for _ in range(joints)]
    for k, (joint, p, r) in enumerate(entries):
        out[joint][p, r] = out[joint][r, p] = sums[k]
    return out


def _power_mean(ca: Any, matrix: Any, squarings: int) -> Any:
    """Return log (tr A^p)^(1/p) with p = 2^squarings."""
    for _ in range(squarings):
        matrix = matrix @ matrix
    return ca.log(ca.trace(matrix)) / 2**squarings
