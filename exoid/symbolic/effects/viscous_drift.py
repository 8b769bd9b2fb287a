"""Viscous friction that fades while the joint warms up: c exp(-t/T) θ'."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect, Shape

EFFECT = Effect(
    id="viscous_drift",
    title="Viscous drift",
    family="drift",
    torque="c * exp(-t / T) * dtheta",
    coefficients={"c": Coefficient("N·m·s/rad", typical=3.0, explains="extra viscosity when cold; negative: it grows")},
    shape={
        "T": Shape("s", min=2.0, max=120.0, spacing="log", points=5, typical=30.0, explains="time to lose 63 % of it")
    },
    explains="Cold grease is thick, and the extra resistance at speed fades while it warms up.",
    tells_apart="Repeat the same motion, slow and fast, from cold until nothing changes any more.",
    reference=(
        "Bittencourt, Axelsson, Modeling and experiment design for identification of wear in a robot "
        "joint under load and temperature uncertainties, IEEE/ASME Transactions on Mechatronics 19(5), "
        "2014"
    ),
)
