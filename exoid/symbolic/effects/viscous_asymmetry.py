"""Viscous friction that differs between the two directions: c |θ'|."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="viscous_asymmetry",
    title="Asymmetric viscosity",
    family="friction",
    torque="c * abs(dtheta)",
    coefficients={
        "c": Coefficient("N·m·s/rad", typical=2.0, explains="half the difference between forward and backward")
    },
    explains="Moving one way costs more torque per speed than moving the other way.",
    tells_apart=(
        "The same constant speeds in both directions; the difference must grow with speed (else it is a torque offset)."
    ),
    reference="Armstrong-Hélouvry, Control of Machines with Friction, Kluwer, 1991",
)
