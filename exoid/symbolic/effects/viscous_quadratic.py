"""Resistance that grows with the square of the speed: c θ'|θ'|."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="viscous_quadratic",
    title="Quadratic viscosity",
    family="friction",
    torque="c * dtheta * abs(dtheta)",
    coefficients={
        "c": Coefficient("N·m·s²/rad²", min=0.0, typical=3.0, explains="resistance of oil or air that is displaced")
    },
    explains=("Moving twice as fast takes four times the extra torque, as when oil or air is displaced."),
    tells_apart=(
        "Constant speeds over the whole range, up to the highest allowed; at least five levels in both directions."
    ),
    reference=(
        "Olsson, Åström, Canudas de Wit, Gäfvert, Lischinsky, Friction models and friction compensation, "
        "European Journal of Control 4(3), 176-195, 1998"
    ),
)
