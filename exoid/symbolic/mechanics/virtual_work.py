"""Torques that a force at a point of the machine asks of its drives: -Jᵀ F, by virtual work.

The point is where the mechanism says it is, so that whatever changes the mechanism (an encoder's zero, a base that is
measured) moves it too; `newton_euler.push_torques` confirms it, and in space `spatial.wrench_torques`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from exoid.symbolic.force import LINK, NORMAL, TORQUE, VERTICAL, Force
from exoid.symbolic.joints import Joint
from exoid.symbolic.mechanics.spatial import joint_frames, rotation

if TYPE_CHECKING:
    from sympy import Expr

    from exoid.symbolic.mechanics.mechanism import Mechanism


def force_torques(
    mechanism: Mechanism, force: Force, index: int, signals: Sequence[Expr]
) -> tuple[list[Expr], list[Expr]]:
    """Return the torques (J,) that a force of gain 1 with these `signals` asks of the drives at the upper joint of link
    `index`, and how much more it does per metre along that link.
    """
    from sympy import Integer, Matrix, cos, sin

    joints = mechanism.joints
    zero = [Integer(0)] * len(joints)
    if force.frame == TORQUE:
        return [-signals[0] if k == index else Integer(0) for k in range(len(joints))], zero
    if force.frame == NORMAL:
        phi = mechanism.absolute_angle(index)
        pushed = Matrix([signals[0] * cos(phi), signals[0] * sin(phi)])
    else:
        pushed = Matrix([Integer(0), signals[0]] if force.frame == VERTICAL else list(signals))
    origin, unit = (Matrix(mechanism.point(index, Integer(reach))) for reach in (0, 1))
    parts = (-(point.jacobian(mechanism.angle).T * pushed) for point in (origin, unit - origin))
    first, more = ([entry.expand() for entry in part] for part in parts)
    return first, more


def space_force_torques(joints: Sequence[Joint], q: Sequence[Any], force: Force, signals: Sequence[Any]) -> list[Any]:
    """Return the torques (J,) that a force in space, or a force and a moment, of gain 1 with these `signals` asks of
    the drives at angles `q` (J,); CasADi expressions.

    A moment M works at M · δφ where a frame R turns by δR = [δφ]× R, which is ½ tr([M]×ᵀ δR Rᵀ).
    """
    import casadi as ca

    angles, wrench = ca.SX.sym("q", len(joints)), ca.SX.sym("w", len(signals))
    turned, origin = joint_frames(joints, ca.vertsplit(angles), ca)[force.index(joints)]
    frame = ca.blockcat([[*row] for row in turned])
    place = ca.vertcat(*origin) + frame @ ca.DM(force.placed.xyz)
    axes = frame @ ca.DM(rotation(force.placed)) if force.frame == LINK else ca.DM.eye(3)
    work = ca.jacobian(place, angles).T @ (axes @ wrench[:3])
    if len(signals) == 6:
        moment = ca.skew(axes @ wrench[3:])
        work += 0.5 * ca.jacobian(ca.vec(frame), angles).T @ ca.vec(moment @ frame)
    asked = ca.Function("asked", [angles, wrench], [-work])(ca.vertcat(*q), ca.vertcat(*signals))
    return list(ca.vertsplit(asked))
