"""Dry friction between shank and pelvis: c sgn(θ1' + θ2') on both joints.

A drive that sits on the base and pulls the shank by a belt turns with the shank's absolute angle, and so does its
friction. The sign is smoothed over 0.03 rad/s, below which the sum of two measured velocities does not tell it.
"""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

SIGN = "tanh((dtheta1 + dtheta2) / 0.03)"

EFFECT = Effect(
    id="cross_coulomb",
    title="Dry friction across both joints",
    family="friction",
    joints=("both",),
    torque={"hip": f"c * {SIGN}", "knee": f"c * {SIGN}"},
    coefficients={
        "c": Coefficient("N·m", min=0.0, typical=2.0, explains="friction of the second link's absolute rotation")
    },
    explains=(
        "Something rubs as the second link turns against the base, such as a drive there that moves it by a belt."
    ),
    tells_apart="Move the second joint with the first held: the first then feels a friction that turns with it.",
    reference="Armstrong-Hélouvry, Dupont, Canudas de Wit, Automatica 30(7), 1083-1138, 1994",
)
