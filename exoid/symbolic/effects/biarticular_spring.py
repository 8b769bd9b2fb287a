"""A muscle, tendon or cable over both joints: k (θ1 + θ2) + c on hip and knee."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="biarticular_spring",
    title="Two-joint spring",
    family="spring",
    joints=("both",),
    torque={"hip": "k * (theta1 + theta2) + c", "knee": "k * (theta1 + theta2) + c"},
    coefficients={
        "k": Coefficient("N·m/rad", min=0.0, typical=5.0, explains="stiffness"),
        "c": Coefficient("N·m", typical=0.0, explains="pretension, torque where both angles are zero"),
    },
    explains="An elastic part spans two joints, so that bending one loads the other.",
    tells_apart="Hold one joint at several angles while the other moves, and the other way round.",
    reference=(
        "Silder, Whittington, Heiderscheit, Thelen, Identification of passive elastic joint moment-angle "
        "relationships in the lower extremity, Journal of Biomechanics 40(12), 2628-2635, 2007"
    ),
)
