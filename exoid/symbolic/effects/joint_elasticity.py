"""A flexible transmission, to first order: c τ_model''.

Encoder behind the transmission, at the joint: the rotor also follows the twist τ/K, so c = J_rotor/K > 0.
Encoder before it, at the motor: the leg lags by the twist, and c = -J_leg/K < 0. Hence both signs.
"""

from __future__ import annotations

from exoid.symbolic.effect import Effect, Shape

EFFECT = Effect(
    id="joint_elasticity",
    title="Joint elasticity",
    family="drive",
    drive=True,
    torque="c * ddt(ddt(tau_model))",
    shape={
        "c": Shape(
            "s²",
            min=-0.01,
            max=0.01,
            points=10,
            typical=0.002,
            explains="inertia over stiffness; positive: encoder at the joint, negative: at the motor",
        )
    },
    explains="Gear or belt deform under load, so that the motor moves before the joint does.",
    tells_apart=("Fast small oscillations at several frequencies up to the resonance, and with the output clamped."),
    reference=(
        "Spong, Modeling and control of elastic joint robots, ASME Journal of Dynamic Systems, "
        "Measurement, and Control 109(4), 310-319, 1987"
    ),
)
