"""What a force at a point of the machine asks of its drives: -Jᵀ F, by virtual work.

The point is where the mechanism says it is, so that whatever changes the mechanism (an encoder's zero, a base that is
measured) moves it too; `newton_euler.push_torques` confirms it.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from exoid.symbolic.force import NORMAL, TORQUE, VERTICAL, Force

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
