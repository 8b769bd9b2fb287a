"""Centre of mass of a link off the line from its joint to the next, on machines that are not the leg.

Derived from the machine whose link has its centre of mass `m_y / m` across its axis. What the offset adds to the
inertia is part of the base parameters already, so one number is left: the first moment.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from exoid.symbolic.effect import Coefficient, Effect


def derive(mechanism: Any, symbols: Mapping[str, Any]) -> Any:
    """Return the machine with the link's centre of mass across it."""
    link = mechanism.links[mechanism.own]
    return mechanism.with_link(link.name, across=symbols["m_y"] / link.mass)


EFFECT = Effect(
    id="com_offset",
    title="Mass off axis",
    explains="The link is heavier in front or behind (a motor, a box), so it does not hang straight.",
    derive=derive,
    machines="planar others",
    coefficients={
        "m_y": Coefficient("kg·m", min=-5.0, max=5.0, typical=0.2, explains="mass times distance, forward positive")
    },
    family="gravity",
    tells_apart="Slow swings far to both sides: the torque at rest follows the cosine of the angle too.",
    reference=(
        "Gautier, Khalil, Direct calculation of minimum set of inertial parameters of serial robots, "
        "IEEE Transactions on Robotics and Automation 6(3), 368-373, 1990"
    ),
)
