"""A flexible transmission, to first order: c τ_model''."""

from __future__ import annotations

from symbolic.effect import Effect, Shape

EFFECT = Effect(
    id="joint_elasticity",
    title="Joint elasticity",
    family="drive",
    torque="c * ddt(ddt(tau_model))",
    shape={
        "c": Shape(
            "s²",
            min=1e-05,
            max=0.003,
            spacing="log",
            points=8,
            typical=0.0005,
            explains="rotor inertia over stiffness of the transmission",
        )
    },
    explains="Gear or belt give way under load, so that the motor moves before the joint does.",
    tells_apart=(
        "Fast small oscillations at several frequencies up to the resonance, and with the output clamped."
    ),
    reference=(
        "Spong, Modeling and control of elastic joint robots, ASME Journal of Dynamic Systems, "
        "Measurement, and Control 109(4), 310-319, 1987"
    ),
)
