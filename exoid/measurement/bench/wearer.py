"""A wearer who is not passive, and the ground under a foot: forces that act on the bench, measured or not.

They drive the machine besides the motors: `M θ'' + ... = τ + Jᵀ F` (equation (4) of the paper). At the cuffs of a leg
they stand at right angles to the segments, positive to the front of a hanging leg.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.errors import ExoidError
from exoid.ground.suggest import did_you_mean
from exoid.measurement.bench.walk import Gait
from exoid.symbolic.force import FIXED, LINK, NORMAL, TORQUE, VERTICAL, WORLD, Force
from exoid.symbolic.mechanics.pushed import placed_joints, pushed_torques
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion


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
"""The same of the foot of a leg that does not walk, m below the last joint."""
GROUND = (8.0, 60.0)
"""N forwards and upwards at most in stance, STANCE of a stride of about STRIDE s, where no leg walks."""
STANCE, STRIDE = 0.6, 1.2
PERSON = 3.0
"""N·m at most that a person applies about a joint."""


SENSED: Mapping[str, tuple[str, ...]] = MappingProxyType(
    {"cuffs": (NORMAL, TORQUE), "plate": (WORLD, VERTICAL), "switch": (), "wrench": (LINK, FIXED)}
)
"""What a recording can have of what acts, and the frames of the forces that it then has; a foot switch has none."""
TOUCH = 5.0
"""N of load at which a foot switch closes."""


def sensed(names: Sequence[str]) -> tuple[str, ...]:
    """Return `names` of SENSED; ExoidError for another."""
    for name in names:
        if name not in SENSED:
            remedy = did_you_mean(name, SENSED) or f"use {', '.join(SENSED)}, or none of them"
            raise ExoidError(f"the bench has no sensor called {name!r}", remedy=remedy)
    return tuple(names)


def pushed_leg(model: Model, wearer: Wearer | None, gait: Gait | None) -> Model:
    """Return `model` with every force that acts at a place and of a gain, which is what a machine has: its own, and
    those of a `wearer` at the cuffs and of the ground under a walking foot where it has none of the kind.
    """
    forces = list(model.forces)
    kinds = {force.frame for force in forces}
    if wearer is not None and not forces:
        names = zip(("thigh cuff", "shank cuff"), model.joint_names, ("f1", "f2"), wearer.reach, strict=True)
        forces = [Force(name, link, (column,), at) for name, link, column, at in names]
    if gait is not None and kinds.isdisjoint((WORLD, VERTICAL)):
        forces.append(Force("ground", model.joint_names[-1], ("grf_x", "grf_z")))
    foot = FOOT if gait is None else gait.walk.foot
    usual = {WORLD: foot, VERTICAL: foot}
    return model.with_forces(
        *(
            replace(force, at=at, gain=force.gain or 1.0)
            for force in forces
            for at in (usual.get(force.frame, CUFF) if force.at is None and not force.in_space else force.at,)
        )
    )


def recorded(model: Model, measured: Sequence[str] | None) -> tuple[bool, ...]:
    """Return of each channel (C,) of a pushed leg whether its recordings have it; all where `measured` is None."""
    frames = [frame for name in SENSED if measured is None or name in measured for frame in SENSED[name]]
    return tuple(force.frame in frames for force in model.forces for _ in force.columns)


def pushes(model: Model, wearer: Wearer | None, gait: Gait | None, t: Float, rng: np.random.Generator) -> Float:
    """Return the signals (N, C) of the forces of `model` at times `t`: the ground's under a walking foot, which no two
    strides repeat, and a person's at cuffs and about joints.
    """
    person = Wearer() if wearer is None else wearer
    cuffs, out, used = person.force(t, rng), [], 0
    under = _standing(t, rng) if gait is None else gait.ground(t)
    for force in model.forces:
        if force.frame == WORLD:
            out += [*under.T]
        elif force.frame == VERTICAL:
            out.append(under[:, 1])
        elif force.in_space:
            for k in range(len(force.columns)):
                out.append(_scaled(person.force(t, rng)[:, k % 2], k >= 3, person, k % 2))
        else:
            own = cuffs if used < 2 else person.force(t, rng)
            out.append(_scaled(own[:, used % 2], force.frame == TORQUE, person, used % 2))
            used += 1
    return np.column_stack(out)


def _scaled(force: Float, turns: bool, person: Wearer, cuff: int) -> Float:
    """Return the push of a person at a `cuff` (N,), as a torque where the joint `turns`."""
    return force * (PERSON / person.amplitude[cuff]) if turns else force


def borne(model: Model, motion: Motion, signals: Float) -> Float:
    """Return the torques (N, J) that bear the load of the ground along a `motion`, given the `signals` (N, C) of a
    pushed leg: who walks braces the leg before the heel strikes, and it is not knocked out of its way.
    """
    out, used = np.zeros(motion.q.shape), 0
    for force in model.forces:
        count = len(force.columns)
        if force.frame in (WORLD, VERTICAL):
            told = signals[:, used : used + count]
            at = force.at if isinstance(force.at, float) else 0.0
            out += pushed_torques(placed_joints(model), motion.q, force, at, told)
        used += count
    return out


def switch(model: Model, signals: Float) -> Float:
    """Signal of a foot switch (N,) from the `signals` (N, C) of a pushed leg: 1 while the ground carries more than
    TOUCH N; ExoidError where no ground acts.
    """
    frames = [force.frame for force in model.forces for _ in force.columns]
    upwards = [k for k, frame in enumerate(frames) if frame in (WORLD, VERTICAL)]
    if not upwards:
        raise ExoidError("a foot switch, and no ground under the foot", where=model.name, remedy="let the leg walk")
    return np.where(signals[:, upwards[-1]] > TOUCH, 1.0, 0.0)


def _standing(t: Float, rng: np.random.Generator) -> Float:
    """Return the force (N, 2) of the ground on the foot of a leg that does not walk, forwards and upwards; every stride
    takes its own time.
    """
    length = float(t[-1] - t[0])
    strides = STRIDE * rng.uniform(0.85, 1.15, int(length / (0.8 * STRIDE)) + 2)
    ends = t[0] + np.cumsum(strides)
    index = np.searchsorted(ends, t)
    phase = 1.0 - (ends[index] - t) / strides[index]
    passed = np.where(phase < STANCE, phase / STANCE, 0.0)
    forwards = GROUND[0] * np.sin(2.0 * np.pi * passed) * (passed > 0.0)
    return np.column_stack([forwards, GROUND[1] * np.sin(np.pi * passed) ** 2])
