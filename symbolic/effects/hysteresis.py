"""Friction that builds up over a small angle after each reversal instead of at once: c (z - sgn θ')."""

from __future__ import annotations

from symbolic.effect import Coefficient, Effect, Shape

EFFECT = Effect(
    id="hysteresis",
    title="Presliding hysteresis",
    family="friction",
    torque="c * (dahl(theta, sigma) - sgn(dtheta))",
    coefficients={"c": Coefficient("N·m", min=0.0, typical=10.0, explains="Coulomb friction that builds up gradually")},
    shape={
        "sigma": Shape(
            "1/rad",
            min=10.0,
            max=500.0,
            spacing="log",
            points=7,
            typical=100.0,
            explains="inverse of the angle over which it builds up",
        )
    },
    explains=(
        "After a reversal the joint first gives way like a spring, and friction takes a small angle to "
        "reach its full size."
    ),
    tells_apart=("Many small reversals of different size, at speeds so low that viscous friction does not matter."),
    reference="Dahl, A solid friction model, Aerospace Corporation, report TOR-0158(3107-18)-1, 1968",
)
