"""Inertia of motor and gear, felt through the gear ratio squared: c θ''."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="rotor_inertia",
    title="Rotor inertia",
    family="inertia",
    joints=("knee",),
    torque="c * ddtheta",
    coefficients={
        "c": Coefficient("kg·m²", min=0.0, typical=0.5, explains="rotor inertia times the gear ratio squared")
    },
    absorbed_on={"hip": "the base model contains it already, as a change of Φ1 and Φ4 that no motion can show"},
    explains="The motor's own rotor has to be accelerated too, and through the gear it feels heavy.",
    tells_apart=(
        "Fast small oscillations of the joint with those before it still, and a recording with a known mass added."
    ),
    reference=(
        "Siciliano, Sciavicco, Villani, Oriolo, Robotics: Modelling, Planning and Control, Springer, 2009, section 7.1"
    ),
)
