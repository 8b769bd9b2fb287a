"""Friction that varies over the turn: (c1 sin θ + c2 cos θ) sgn(θ')."""

from __future__ import annotations

from exoid.symbolic.effect import Coefficient, Effect

EFFECT = Effect(
    id="position_friction",
    title="Position-dependent friction",
    family="friction",
    torque="(c1 * sin(theta) + c2 * cos(theta)) * sgn(dtheta)",
    coefficients={
        "c1": Coefficient("N·m", typical=3.0, explains="sine part"),
        "c2": Coefficient("N·m", typical=3.0, explains="cosine part"),
    },
    explains=(
        "The joint runs harder at some angles than at others, in both directions: an eccentric or worn transmission."
    ),
    tells_apart=("Slow motion at constant speed over the full range in both directions, without changing the load."),
    reference="Armstrong, Friction: experimental determination, modeling and compensation, ICRA, 1988",
)
