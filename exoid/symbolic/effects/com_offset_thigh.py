"""Centre of mass of the thigh off the line from hip to knee: m y g cos θ1 on the hip.

Derived from the leg whose thigh has its centre of mass `m_y / m_th` across the link. What the offset adds
to the inertia is part of Φ1 and Φ4 already, so one number is left: the first moment.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from exoid.symbolic.effect import Coefficient, Effect


def derive(mechanism: Any, symbols: Mapping[str, Any]) -> Any:
    """Return the leg with the thigh's centre of mass across the link."""
    return mechanism.with_link("thigh", across=symbols["m_y"] / mechanism.link("thigh").mass)


EFFECT = Effect(
    id="com_offset_thigh",
    title="Thigh mass off axis",
    explains="The thigh is heavier in front or behind (a motor, a box), so it does not hang straight.",
    derive=derive,
    joints=("both",),
    machines="leg",
    coefficients={
        "m_y": Coefficient("kg·m", min=-5.0, max=5.0, typical=0.3, explains="mass times distance, forward positive")
    },
    family="gravity",
    tells_apart="Slow swings of the hip far to both sides: the torque at rest follows cos θ1, not sin θ1.",
    reference=(
        "Gautier, Khalil, Direct calculation of minimum set of inertial parameters of serial robots, "
        "IEEE Transactions on Robotics and Automation 6(3), 368-373, 1990"
    ),
)
