"""An encoder reads too little, on machines that are not the leg: θ -> θ + offset everywhere inside the model.

Turning a link about its joint also takes its centre of mass off its axis, so the last link with its mass off axis gives
exactly the same equations, and so does a tilted frame for the first joint.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from exoid.symbolic.effect import Effect, Shape


def derive(mechanism: Any, symbols: Mapping[str, Any]) -> Any:
    """Return the machine whose joint stands at θ + offset."""
    offset = list(mechanism.joint_offset)
    offset[mechanism.own] += symbols["offset"]
    return replace(mechanism, joint_offset=tuple(offset))


EFFECT = Effect(
    id="encoder_offset",
    title="Encoder zero",
    explains="The zero of the encoder is off: the joint stands further or less far than the reading says.",
    derive=derive,
    machines="others",
    shape={"offset": Shape("rad", min=-0.8, max=0.8, points=9, typical=0.05, explains="true angle minus reading")},
    family="sensor",
    tells_apart="Move the joint to its mechanical stop and compare the reading with the drawing.",
    reference="Hollerbach, Khalil, Gautier, Model identification, Springer Handbook of Robotics, 2nd ed., 2016, ch. 6",
)
