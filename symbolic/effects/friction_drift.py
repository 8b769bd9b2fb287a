"""Coulomb friction that fades while the joint warms up: c exp(-t/T) sgn(θ')."""

from __future__ import annotations

from symbolic.effect import Coefficient, Effect, Shape

EFFECT = Effect(
    id="friction_drift",
    title="Friction drift",
    family="drift",
    torque="c * exp(-t / T) * sgn(dtheta)",
    coefficients={"c": Coefficient("N·m", min=0.0, typical=5.0, explains="extra friction when cold")},
    shape={
        "T": Shape(
            "s", min=5.0, max=600.0, spacing="log", points=8, typical=60.0, explains="time to lose 63 % of it"
        )
    },
    explains="A cold joint rubs more, and the extra friction fades while it warms up.",
    tells_apart="Repeat the same motion from cold until nothing changes any more.",
    reference=(
        "Simoni, Beschi, Legnani, Visioli, Friction modeling with temperature effects for industrial "
        "robot manipulators, IROS, 2015"
    ),
)
