"""A leg that walks: strides of which no two are alike, and the ground that pushes its foot during most of each.

Hip and knee follow the angles of level walking; pace and size change slowly, and the force of the ground is another in
every stride, so that it is no function of the motion. Speeds are those of walking, whatever the limits of the model,
which are those of motions that are designed.

Source of the shape of angles and forces: Winter, Biomechanics and Motor Control of Human Movement, 2009, chapters 3
and 5 (rounded; three harmonics of the angles).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.errors import ExoidError
from exoid.symbolic.motion import Float, Motion

HIP = (27.0, 25.0, 18.0, 8.0, -3.0, -10.0, -5.0, 12.0, 25.0, 29.0)
KNEE = (-4.0, -17.0, -18.0, -11.0, -7.0, -14.0, -38.0, -61.0, -50.0, -18.0)
"""Degrees at every tenth of a stride, which begins where the heel touches the ground."""
HARMONICS = 3
BENT = 0.15
"""rad that the knee of a machine stays bent more than that of a person, and is never straight."""
PACE, SIZE = 0.07, 0.10
"""Shares by which pace and size of the strides differ, typically."""
RATES = (0.45, 0.9, 2.1)
"""rad/s, about, at which they change."""
RISE = 0.15
"""Part of stance in which the load comes, and goes."""
BRAKE = 0.16
"""Largest force forwards of that upwards: the heel brakes, the toes push."""
UNLIKE = np.array([0.12, 0.25, 0.3])
"""Shares by which strides differ: in load, in how much of it comes late, in braking and pushing."""
STRIDES = 1000
"""Strides until their forces come again."""


@dataclass(frozen=True)
class Walk:
    """Strides of about `stride` s, in whose part `stance` the foot, `foot` m below the knee, bears up to about `load` N
    of what a person and a machine weigh.
    """

    stride: float = 1.5
    load: float = 250.0
    stance: float = 0.6
    foot: float = 0.43

    def __post_init__(self) -> None:
        for entry in fields(self):
            if not (math.isfinite(value := getattr(self, entry.name)) and value > 0.0):
                raise ExoidError(f"a walk with {entry.name} = {value}", remedy="give numbers above zero")
        if not (0.5 <= self.stride <= 10.0 and self.stance < 0.95):
            what = f"strides of {self.stride:g} s with {self.stance:g} of stance"
            raise ExoidError(what, remedy="give 0.5 to 10 s, and a stance below 0.95")

    def drawn(self, rng: np.random.Generator) -> Gait:
        """Return one walk: its pace, its sizes and its forces drawn."""
        rates = np.array(RATES) * rng.uniform(0.85, 1.15, (2, len(RATES)))
        phases = rng.uniform(0.0, 2.0 * np.pi, (2, len(RATES)))
        return Gait(self, rates, phases, float(rng.uniform()), 1.0 + UNLIKE * rng.standard_normal((STRIDES, 3)))


@dataclass(frozen=True, eq=False)
class Gait:
    """A walk whose chances are drawn: `rates` (2, 3) rad/s and `phases` (2, 3) rad at which pace and size change, the
    stride it `begins` in, and how the forces of each stride differ, `unlike` (S, 3).
    """

    walk: Walk
    rates: Float
    phases: Float
    begins: float
    unlike: Float

    def at(self, t: NDArray[np.floating[Any]]) -> Motion:
        """Return angle, velocity and acceleration of hip and knee at times `t` (N,) in s."""
        time = np.asarray(t, dtype=float)
        stride, pace, hurry = self._strides(time)
        _, size, growth, bend = self._waves(1, SIZE, time)
        size = size + 1.0
        turns = 2.0 * np.pi * np.arange(1, HARMONICS + 1)
        wave = np.exp(1j * np.outer(stride, turns))
        q, dq, ddq = [], [], []
        for degrees, bent in ((HIP, 0.0), (KNEE, BENT)):
            parts = np.fft.rfft(np.deg2rad(degrees)) / len(degrees)
            middle, lines = parts[0].real - bent, 2.0 * parts[1 : HARMONICS + 1]
            shape, slope, curve = ((wave @ (lines * (1j * turns) ** k)).real for k in range(3))
            speed = slope * pace
            q.append(middle + size * shape)
            dq.append(growth * shape + size * speed)
            ddq.append(bend * shape + 2.0 * growth * speed + size * (curve * pace**2 + slope * hurry))
        return Motion(time, *(np.column_stack(rows) for rows in (q, dq, ddq)))

    def ground(self, t: Float) -> Float:
        """Return the force (N, 2) of the ground on the foot at times `t` (N,) s, forwards and upwards, N."""
        stride, *_ = self._strides(np.asarray(t, dtype=float))
        load, late, push = self.unlike[np.floor(stride).astype(int) % STRIDES].T
        part = (stride % 1.0) / self.walk.stance
        on = part < 1.0
        rise = np.clip(np.minimum(part, 1.0 - part) / RISE, 0.0, 1.0)
        borne = 0.5 * (1.0 - np.cos(np.pi * rise)) * on
        humps = 1.0 - 0.15 * np.cos(4.0 * np.pi * part) - 0.2 * (late - 1.0) * np.cos(2.0 * np.pi * part)
        upwards = self.walk.load / 1.15 * load * borne * humps
        forwards = -BRAKE * self.walk.load * push * borne * np.sin(2.0 * np.pi * part)
        return np.column_stack([forwards, np.maximum(upwards, 0.0)])

    def _strides(self, t: Float) -> tuple[Float, Float, Float]:
        """Return the strides (N,) that have passed, how many there are in a second, and how fast that changes."""
        passed, value, slope, _ = self._waves(0, PACE, t)
        return self.begins + (t + passed) / self.walk.stride, (1.0 + value) / self.walk.stride, slope / self.walk.stride

    def _waves(self, which: int, share: float, t: Float) -> tuple[Float, ...]:
        """Return the integral of slow waves, typically `share` high, the waves, and their two derivatives (N,)."""
        rate, high = self.rates[which], share * math.sqrt(2.0 / len(RATES))
        turned = np.exp(1j * (np.outer(t, rate) + self.phases[which]))
        return tuple((turned @ (-1j * high * (1j * rate) ** k)).real for k in (-1, 0, 1, 2))
