"""A spring across the joint with its rest angle: k θ + c."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="joint_spring",
    title="Joint spring",
    family="spring",
    torque="k * theta + c",
    coefficients={
        "k": Coefficient("N·m/rad", min=0.0, typical=5.0, explains="stiffness"),
        "c": Coefficient("N·m", typical=0.0, explains="torque at angle zero: minus stiffness times rest angle"),
    },
    explains="Something elastic pulls the joint back towards a rest angle: a spring, a cable, a sleeve.",
    tells_apart=(
        "Hold still at many angles over the full range; at the first joint turn the whole device, so that "
        "gravity changes and the spring does not."
    ),
    reference=("Yoon, Mansour, The passive elastic moment at the hip, Journal of Biomechanics 15(12), 905-910, 1982"),
)
