"""The wearer's relaxed leg, felt at the cuff: torque Jᵀ F with F = k p + d p' - f.

p is the position of the cuff on the shank, `reach` below the knee; k and d are stiffness and damping of the
wearer's limb there, and f = k p_0 the force that belongs to its position of rest p_0.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from exoid.symbolic.effect import Coefficient, Effect, Shape


def derive(mechanism: Any, symbols: Mapping[str, Any]) -> Any:
    """Return the joint torques (J,) that carry a spring and damper at the cuff."""
    from sympy import Matrix

    cuff = Matrix(mechanism.point(mechanism.own, symbols["reach"]))
    jacobian = cuff.jacobian(mechanism.angle)
    velocity = jacobian * Matrix(mechanism.velocity)
    force = symbols["k"] * cuff + symbols["d"] * velocity - Matrix([symbols["f_x"], symbols["f_z"]])
    return tuple(jacobian.T * force)


EFFECT = Effect(
    id="cuff_interaction",
    title="Spring and damper on the last link",
    explains="Something holds the last link back like a spring and a damper, as a relaxed leg in the cuff of a shank.",
    derive=derive,
    joints=("both",),
    machines="planar",
    coefficients={
        "k": Coefficient("N/m", min=0.0, typical=200.0, explains="stiffness of what holds it"),
        "d": Coefficient("N·s/m", min=0.0, typical=30.0, explains="damping of what holds it"),
        "f_x": Coefficient("N", typical=25.0, explains="k times the forward position of rest"),
        "f_z": Coefficient("N", typical=-115.0, explains="k times the upward position of rest"),
    },
    shape={"reach": Shape("m", min=0.10, max=0.45, points=5, typical=0.25, explains="distance from the joint")},
    family="contact",
    tells_apart="Repeat the motion with the cuff open, or nothing attached: what vanishes is not the machine's.",
    reference=(
        "Schiele, van der Helm, Kinematic design to improve ergonomics in human machine interaction, "
        "IEEE Transactions on Neural Systems and Rehabilitation Engineering 14(4), 456-469, 2006"
    ),
)
