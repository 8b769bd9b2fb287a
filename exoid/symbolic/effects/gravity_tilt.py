"""Gravity turned by a small angle: the frame of the exoskeleton does not stand upright.

Derived from the leg with every gravity angle increased by `tilt`. The hip encoder reading too little by the
same angle gives exactly the same equations, since nothing but gravity knows where down is.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from exoid.symbolic.effect import Effect, Shape


def derive(mechanism: Any, symbols: Mapping[str, Any]) -> Any:
    """Return the leg under tilted gravity."""
    return replace(mechanism, tilt=mechanism.tilt + symbols["tilt"])


EFFECT = Effect(
    id="gravity_tilt",
    title="Tilted frame",
    explains="The frame leans, or the zero of the first encoder is off, so nothing hangs where the model expects.",
    derive=derive,
    joints=("both",),
    machines="planar",
    shape={
        "tilt": Shape(
            "rad",
            min=-0.8,
            max=0.8,
            points=9,
            typical=0.05,
            explains="forward lean; equally, the error of the first encoder",
        )
    },
    family="gravity",
    tells_apart="Put a spirit level on the frame, or read the first encoder while everything hangs still.",
    reference="Hollerbach, Khalil, Gautier, Model identification, Springer Handbook of Robotics, 2nd ed., 2016, ch. 6",
)
