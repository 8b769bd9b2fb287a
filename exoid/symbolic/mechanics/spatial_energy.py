"""Lagrange for a tree of links in space, from energies alone: what confirms the recursion of `spatial.py`.

A link's energies are linear in its pseudo-inertia P (4, 4), whose entries are its ten parameters, and need nothing but
where its frame A (4, 4) is: no rates of turning, no accelerations, no forces.

    T = ½ tr(Ȧ P Ȧᵀ)      V = -(g, 0)ᵀ A P (0, 0, 0, 1)

Source: Uicker, Dynamic force analysis of spatial linkages, ASME Journal of Applied Mechanics 34(2), 1967.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from exoid.symbolic.joints import Joint, Vector
from exoid.symbolic.mechanics.spatial import AT, MOMENTS, joint_frames, turned_by


def lagrange_torques(
    joints: Sequence[Joint], pull: Vector, q: Any, dq: Any, ddq: Any, inertial: Sequence[Mapping[str, Any]],
    base: Any = None,
) -> Any:  # fmt: skip
    """Return the torque (J,) of links with `inertial` parameters as a CasADi expression of the symbols `q`, `dq`, `ddq`
    (J,), and of `base` (12,) where that moves; other arguments as of `spatial.joint_torques`.

    A base that turns makes the energies depend on time; one that is accelerated is one in another gravity.
    """
    import casadi

    kinetic, potential = casadi.SX(0), casadi.SX(0)
    below, weight = casadi.DM([0.0, 0.0, 0.0, 1.0]), casadi.DM(pull)
    all_q, all_dq, all_ddq = q, dq, ddq
    if base is not None:
        all_q, all_dq, all_ddq = (
            casadi.vertcat(own, base[3 * k : 3 * k + 3]) for k, own in enumerate((q, dq, ddq))
        )
        weight = weight - base[9:12]
        turning = turned_by(base[0], base[1], base[2], casadi)
    for (turned, place), own in zip(joint_frames(joints, casadi.vertsplit(q), casadi), inertial, strict=True):
        at = casadi.blockcat([[*row, step] for row, step in zip(turned, place, strict=True)])
        if base is not None:
            at = casadi.blockcat([[*row] for row in turning]) @ at
        moved = casadi.reshape(casadi.jtimes(casadi.vec(at), all_q, all_dq), 3, 4)
        inertia = casadi.SX(pseudo_inertia(own))
        kinetic += 0.5 * casadi.trace(moved @ inertia @ moved.T)
        potential -= casadi.dot(weight, at @ inertia @ below)
    momentum = casadi.gradient(kinetic, dq)
    rate = casadi.jtimes(momentum, all_q, all_dq) + casadi.jtimes(momentum, all_dq, all_ddq)
    return rate - casadi.gradient(kinetic, q) + casadi.gradient(potential, q)


def pseudo_inertia(own: Mapping[str, Any]) -> list[list[Any]]:
    """Return the pseudo-inertia (4, 4) of a link about its joint: positive definite where there can be such a link
    (Wensing, Kim, Slotine, IEEE Robotics and Automation Letters 3(1), 2018).
    """
    half = 0.5 * sum(own.get(kind, 0.0) for kind in ("XX", "YY", "ZZ"))
    rows: list[list[Any]] = [[0.0] * 4 for _ in range(4)]
    for kind, (i, j) in AT.items():
        rows[i][j] = rows[j][i] = half - own.get(kind, 0.0) if i == j else -own.get(kind, 0.0)
    for k, kind in enumerate(MOMENTS):
        rows[k][3] = rows[3][k] = own.get(kind, 0.0)
    rows[3][3] = own.get("M", 0.0)
    return rows
