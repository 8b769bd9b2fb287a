"""Resistance that bends with the third power of the speed: c θ'³."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="viscous_cubic",
    title="Cubic viscosity",
    family="friction",
    torque="c * dtheta**3",
    coefficients={"c": Coefficient("N·m·s³/rad³", min=0.0, typical=4.0, explains="steepening of the resistance")},
    explains="The faster it moves, the more steeply the resistance rises, the same in both directions.",
    tells_apart=(
        "Constant speeds up to the highest allowed; only a wide range of speeds distinguishes the cube from the square."
    ),
    reference=(
        "Waiboer, Aarts, Jonker, Velocity dependence of joint friction in robotic manipulators with gear "
        "transmissions, ECCOMAS Multibody Dynamics, 2005"
    ),
)
