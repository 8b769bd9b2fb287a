"""The motion of the virtual bench's base where a model has a measured one: a backpack that tilts and is carried along.

Angle and acceleration are sums of a few sines, slow beside the joints, and independent of each other, so that a
recording shows what each of them does.
"""

from __future__ import annotations

import numpy as np

from exoid.symbolic.motion import Float

TILT, CARRIED = 0.12, 0.8
"""rad and m/s²: typical amplitude of the base's angle and of its acceleration."""
BAND = (0.15, 1.2)
"""Hz within which the base moves."""
SINES = 4
ACCELERATION_NOISE = 0.02
"""m/s² of the accelerometer on the base (standard deviation)."""


def base_motion(t: Float, rng: np.random.Generator, spatial: bool = False) -> Float:
    """Return the motion of the base at times `t` (N,) s: angle rad, rad/s, rad/s², acceleration forwards and upwards
    m/s², (N, 5); of a `spatial` machine three of each, (N, 12).
    """
    turns, all_of = (3, 12) if spatial else (1, 5)
    out = np.zeros((len(t), all_of))
    sizes = {**dict.fromkeys(range(turns), TILT), **dict.fromkeys(range(3 * turns, all_of), CARRIED)}
    for column, size in sizes.items():
        rate, phase = 2.0 * np.pi * rng.uniform(*BAND, SINES), rng.uniform(0.0, 2.0 * np.pi, SINES)
        amplitude = size * rng.uniform(0.5, 1.0, SINES) / np.sqrt(SINES)
        angle = np.outer(t, rate) + phase
        out[:, column] = np.sin(angle) @ amplitude
        if column < turns:
            out[:, column + turns] = np.cos(angle) @ (rate * amplitude)
            out[:, column + 2 * turns] = -np.sin(angle) @ (rate**2 * amplitude)
    return out
