"""Resistance that grows less than the speed: c sgn(θ') |θ'|^p with p below one."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect, Shape

EFFECT = Effect(
    id="viscous_power",
    title="Viscosity that grows less than speed",
    family="friction",
    torque="c * sgn(dtheta) * exp(p * log(abs(dtheta) / 1 + 1e-06))",
    coefficients={
        "c": Coefficient("N·m", min=0.0, typical=3.0, explains="resistance at 1 rad/s, beside the viscous part")
    },
    shape={
        "p": Shape(
            "1", min=0.1, max=0.9, spacing="linear", points=9, typical=0.5, explains="exponent of the speed, below one"
        )
    },
    bends_friction=True,
    explains="Resistance rises fast at low speed and flattens out, as in harmonic drives and greased gears.",
    tells_apart=(
        "Constant speeds over the whole range, several of them slow, in both directions: dry and viscous friction "
        "make a straight line of torque against speed, this one a curve that flattens out."
    ),
    reference=(
        "Taghirad, Bélanger, Modeling and parameter identification of harmonic drive systems, Journal of Dynamic "
        "Systems, Measurement, and Control 120(4), 439-444, 1998"
    ),
)
