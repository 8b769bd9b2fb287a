"""Extra friction at creeping speed, gone once the joint moves: c sgn(θ') exp(-(θ'/v_s)²)."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect, Shape

EFFECT = Effect(
    id="stribeck",
    title="Stribeck friction",
    family="friction",
    torque="c * sgn(dtheta) * exp(-(dtheta / v_s)**2)",
    coefficients={"c": Coefficient("N·m", min=0.0, typical=5.0, explains="extra friction at creeping speed")},
    shape={
        "v_s": Shape(
            "rad/s",
            min=0.01,
            max=0.4,
            spacing="log",
            points=9,
            typical=0.1,
            explains="speed at which most of it is gone",
        )
    },
    explains="The joint sticks when it starts or reverses, and runs freely once it moves.",
    tells_apart=(
        "Slow motion through zero speed, many times, with and without load; fast motion as well where it fades late."
    ),
    reference=(
        "Armstrong-Hélouvry, Dupont, Canudas de Wit, A survey of models, analysis tools and compensation "
        "methods for the control of machines with friction, Automatica 30(7), 1083-1138, 1994"
    ),
)
