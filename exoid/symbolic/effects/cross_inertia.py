"""Inertia of a motor that turns with two joints at once: c (θ1'' + θ2'') on both.

Wrists of industrial arms are driven through each other: the motor of the last joint turns as the one before it moves.
In a plane that rotor is part of the second link's own inertia, and no number of its own.
"""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="cross_inertia",
    title="Inertia across both joints",
    family="inertia",
    joints=("both",),
    machines="spatial",
    torque={"hip": "c * (ddtheta1 + ddtheta2)", "knee": "c * (ddtheta1 + ddtheta2)"},
    coefficients={
        "c": Coefficient("kg·m²", min=0.0, typical=0.3, explains="rotor inertia times the gear ratio squared")
    },
    explains=(
        "A motor turns as either of two joints moves, as in wrists that are driven through each other, and has to be "
        "accelerated by both."
    ),
    tells_apart="Move the second joint fast with the first held: the first then feels its acceleration.",
    reference=(
        "Janot, Vandanjon, Gautier, A Generic Instrumental Variable Approach for Industrial Robot Identification, IEEE "
        "Transactions on Control Systems Technology 22(1), 132-145, 2014"
    ),
)
