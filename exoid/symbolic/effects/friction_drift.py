"""Coulomb friction that fades while the joint warms up: c exp(-t/T) sgn(θ')."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect, Shape

EFFECT = Effect(
    id="friction_drift",
    title="Friction drift",
    family="drift",
    torque="c * exp(-t / T) * sgn(dtheta)",
    coefficients={"c": Coefficient("N·m", typical=5.0, explains="extra friction when cold; negative: it grows")},
    shape={
        "T": Shape("s", min=2.0, max=120.0, spacing="log", points=5, typical=30.0, explains="time to lose 63 % of it")
    },
    explains="A cold joint rubs more, and the extra friction fades while it warms up.",
    tells_apart="Repeat the same motion from cold until nothing changes any more.",
    reference=(
        "Simoni, Beschi, Legnani, Visioli, Friction modeling with temperature effects for industrial "
        "robot manipulators, IROS, 2015"
    ),
)
