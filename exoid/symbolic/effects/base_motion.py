"""The base oscillates: the hip is accelerated harmonically, forwards and upwards.

Derived from the leg on a base with acceleration a(t) = a_s sin(2π f t + phi) + a_c cos(2π f t + phi) in each direction.
It acts on the masses as gravity does, so its amplitudes are known in m/s² once the inertial parameters are. Frequency
and amplitudes belong to what the leg hangs from; whoever starts a recorder does not ask it for its phase.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from exoid.symbolic.effect import Coefficient, Effect, Shape


def derive(mechanism: Any, symbols: Mapping[str, Any]) -> Any:
    """Return the leg on a swaying base."""
    from sympy import cos, pi, sin

    phase = 2 * pi * symbols["f"] * mechanism.time + symbols["phi"]
    forward, upward = mechanism.base_acceleration
    return replace(
        mechanism,
        base_acceleration=(
            forward + symbols["x_s"] * sin(phase) + symbols["x_c"] * cos(phase),
            upward + symbols["z_s"] * sin(phase) + symbols["z_c"] * cos(phase),
        ),
    )


EFFECT = Effect(
    id="base_motion",
    title="Swaying base",
    explains="The base oscillates (a soft stand, a walking wearer) and shakes the machine.",
    derive=derive,
    joints=("both",),
    machines="planar",
    coefficients={
        "x_s": Coefficient("m/s²", min=-20.0, max=20.0, typical=0.5, explains="forward, sine part"),
        "x_c": Coefficient("m/s²", min=-20.0, max=20.0, typical=0.0, explains="forward, cosine part"),
        "z_s": Coefficient("m/s²", min=-20.0, max=20.0, typical=0.5, explains="upward, sine part"),
        "z_c": Coefficient("m/s²", min=-20.0, max=20.0, typical=0.0, explains="upward, cosine part"),
    },
    shape={
        "f": Shape("Hz", min=0.2, max=5.0, points=200, typical=1.0, explains="frequency of the oscillation"),
        "phi": Shape(
            "rad",
            min=-4.0,
            max=4.0,
            typical=0.0,
            explains="phase at the clock's zero",
            per_recording=True,
            turns=True,
        ),
    },
    family="base",
    tells_apart="An accelerometer on the base; or the same motion with the base clamped.",
    reference="Winter, Biomechanics and Motor Control of Human Movement, 4th ed., Wiley, 2009, chapter 5",
)
