"""A cable loop that couples both joints: k (θ1 - θ2) on the hip, the opposite on the knee."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="cable_coupling",
    title="Cable coupling",
    family="spring",
    joints=("both",),
    torque={"hip": "k * (theta1 - theta2)", "knee": "-k * (theta1 - theta2)"},
    coefficients={"k": Coefficient("N·m/rad", min=0.0, typical=5.0, explains="stiffness of the coupling")},
    explains="A cable or belt that runs over both joints is stretched when their angles differ.",
    tells_apart=(
        "Hold one joint at several angles while the other moves: the torque must depend on the "
        "difference of the angles."
    ),
    reference=(
        "Tsai, Robot Analysis: The Mechanics of Serial and Parallel Manipulators, Wiley, 1999 "
        "(tendon-driven manipulators)"
    ),
)
