"""Torques that measured forces ask of the drives, in numbers, by Newton and Euler: what the generated code is confirmed
by, and what pushes the machines of the bench.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from exoid.symbolic.force import LINK, NORMAL, TORQUE, VERTICAL, WORLD, Force
from exoid.symbolic.joints import LEG, Joint
from exoid.symbolic.mechanics.newton_euler import STILL, BaseMotion, push_torques
from exoid.symbolic.mechanics.spatial import wrench_torques
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    from exoid.symbolic.model_structure import ModelStructure


def pushed_torques(
    joints: tuple[Joint, ...], q: Float, force: Force, at: float, signals: Float, base: BaseMotion = STILL
) -> Float:
    """Return the torques (N, J) that a measured force, `signals` (N, C) `at` m along its link, asks of the drives at
    `q` (N, J), by Newton and Euler. One in space is where it says itself.
    """
    index, out = force.index(joints), np.zeros(q.shape)
    if force.frame == TORQUE:
        out[:, index] = -signals[:, 0]
        return out
    zero = np.zeros(len(q))
    if force.in_space:
        turned = force.placed if force.frame == LINK else None
        asked = wrench_torques(joints, [*q.T], index, force.placed.xyz, turned, [*signals.T], np)
        return np.asarray(np.column_stack([row + zero for row in asked]))
    parts = {NORMAL: (zero, signals[:, 0]), VERTICAL: (zero, signals[:, 0]), WORLD: (signals[:, 0], signals[:, -1])}
    normal = force.frame == NORMAL
    asked = push_torques(joints, [*q.T], index, at, parts[force.frame], np, base, normal)
    return np.asarray(np.column_stack([row + zero for row in asked]))


def placed_joints(model: ModelStructure) -> tuple[Joint, ...]:
    """Return the joints of a model with the lengths of their links, those of the leg too."""
    if model.chain:
        return model.chain
    return (replace(LEG[0], length=model.thigh_length), *LEG[1:])
