"""A wearer who is not passive, and the ground under a foot: forces that sensors measure.

They drive the machine besides the motors: `M θ'' + ... = τ + Jᵀ F` (equation (4) of the paper). At the cuffs of a leg
they stand at right angles to the segments, positive to the front of a hanging leg.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symbolic.force import TORQUE, VERTICAL, WORLD, Force
from symbolic.model import Model
from symbolic.motion import Float


@dataclass(frozen=True)
class Wearer:
    """Cuff forces of `amplitude` N (thigh, shank) that come and go within about `period` s, at `reach` m."""

    amplitude: tuple[float, float] = (15.0, 10.0)
    period: float = 3.0
    reach: tuple[float, float] = (0.25, 0.25)

    def force(self, t: NDArray[np.floating[Any]], rng: np.random.Generator) -> Float:
        """Return forces (N, 2) in N at times `t`: three harmonics with random phases, never above the
        amplitude.
        """
        phase = rng.uniform(0.0, 2.0 * math.pi, (3, 2))
        rate = 2.0 * math.pi / self.period * np.array([0.37, 1.0, 1.83])
        waves = np.sin(np.asarray(t)[:, None, None] * rate[None, :, None] + phase)
        return np.asarray(np.array(self.amplitude) * waves.mean(axis=1))


CUFF = 0.25
"""m below its joint at which a cuff or a foot sits whose place no model says."""
FOOT = 0.43
"""The same of the foot, m below the last joint."""
GROUND = (8.0, 60.0)
"""N forwards and upwards at most in stance, STANCE of a stride of about STRIDE s."""
STANCE, STRIDE = 0.6, 1.2
PERSON = 3.0
"""N·m at most that a person applies about a joint."""


def pinned(model: Model) -> Model:
    """Return `model` with every force at a place and of a gain, which is what a machine has."""
    usual = {WORLD: FOOT, VERTICAL: FOOT}
    return model.with_forces(
        *(
            replace(force, at=usual.get(force.frame, CUFF) if force.at is None else force.at, gain=force.gain or 1.0)
            for force in model.forces
        )
    )


def pushes(model: Model, wearer: Wearer, t: Float, rng: np.random.Generator) -> Float:
    """Return the signals (N, C) of the forces of `model` at times `t`: the ground's under a walking foot, which no two
    strides repeat, and a person's at cuffs and about joints.
    """
    cuffs, out, used = wearer.force(t, rng), [], 0
    steps = stance(t, rng)
    for force in model.forces:
        if force.frame == WORLD:
            out += [GROUND[0] * np.sin(2.0 * np.pi * steps) * (steps > 0.0), GROUND[1] * np.sin(np.pi * steps) ** 2]
        elif force.frame == VERTICAL:
            out.append(GROUND[1] * np.sin(np.pi * steps) ** 2)
        else:
            size = PERSON / wearer.amplitude[used % 2] if force.frame == TORQUE else 1.0
            out.append(size * cuffs[:, used % 2] if used < 2 else size * wearer.force(t, rng)[:, used % 2])
            used += 1
    return np.column_stack(out)


def stance(t: Float, rng: np.random.Generator) -> Float:
    """Return how much of the stance has passed (N,), 0 in swing; every stride takes its own time."""
    length = float(t[-1] - t[0])
    strides = STRIDE * rng.uniform(0.85, 1.15, int(length / (0.8 * STRIDE)) + 2)
    ends = t[0] + np.cumsum(strides)
    index = np.searchsorted(ends, t)
    phase = 1.0 - (ends[index] - t) / strides[index]
    return np.where(phase < STANCE, phase / STANCE, 0.0)


def worn(model: Model, wearer: Wearer) -> Model:
    """Return the model of a leg with the cuffs of `wearer`, unless it has forces."""
    if model.forces:
        return model
    names = zip(("thigh cuff", "shank cuff"), model.joint_names, ("f1", "f2"), wearer.reach, strict=True)
    return model.with_forces(*(Force(name, link, (column,), at) for name, link, column, at in names))
