"""A machine out of a robot file: planar where its joints move in one plane, spatial otherwise.

A spatial machine is the file's own tree: frames, axes, zeros and signs of its joints are those of the URDF, and nothing
of it has to be edited.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Generic, TypeVar

import numpy as np

from exoid.symbolic.joints import Joint, Origin, Vector
from exoid.symbolic.mechanics.spatial import rotation
from exoid.symbolic.model_structure import STANDARD_GRAVITY, ModelStructure
from exoid.symbolic.motion import Float
from exoid.symbolic.planar_machine import (
    NotPlanarError,
    carrier_name,
    chosen_joints,
    held_still,
    limits_in,
    moving_with,
    plain_name,
    planar_machine,
)
from exoid.symbolic.robot_file import RobotFile, RobotJoint, inertia_of, numbers_of

ROUNDED = 2e-5
"""rad within which an angle is a right one that was written with few digits: 1.5708, 3.1416. What a machine shows of
its links' numbers depends on whether axes are exactly parallel."""
DIGITS = 12
"""Of m and rad that are kept of what several joints of the file make together."""


Machine = TypeVar("Machine", bound=ModelStructure)


@dataclass(frozen=True, eq=False)
class RobotMachine(Generic[Machine]):
    """The `model` of a machine in a robot file, the names its joints have there, and what is worth saying about it."""

    model: Machine
    names: tuple[str, ...]
    notes: tuple[str, ...]


def robot_structure(
    robot: RobotFile, names: Sequence[str] = (), gravity: float | None = None, where: str = "URDF"
) -> RobotMachine[ModelStructure]:
    """Return the machine that the joints called `names` (default: all that move) make; others stand still at zero.

    `gravity` in m/s² is that within the plane of a planar machine, or downwards. RobotFileError says what is wrong with
    the file or its joints.
    """
    try:
        planar = planar_machine(robot, names, gravity, where)
    except NotPlanarError as error:
        return _spatial(robot, names, STANDARD_GRAVITY if gravity is None else gravity, where, error.what)
    return RobotMachine(planar.model, planar.names, planar.notes)


def spatial_machine(
    robot: RobotFile, names: Sequence[str] = (), gravity: float = STANDARD_GRAVITY, where: str = "URDF"
) -> RobotMachine[ModelStructure]:
    """Return the spatial machine of the joints called `names`, whether or not they move in a plane; arguments as of
    `robot_structure`.
    """
    return _spatial(robot, names, gravity, where, "")


def _spatial(
    robot: RobotFile, names: Sequence[str], gravity: float, where: str, why: str
) -> RobotMachine[ModelStructure]:
    joints, carriers = chosen_joints(robot, names, where)
    chosen = [item.name for item in joints]
    made, notes = [], [f"a spatial machine: {why}"] if why else []
    rounded = False
    groups = moving_with(robot, joints)
    for k, (element, carrier) in enumerate(zip(joints, carriers, strict=True)):
        origin, moved = _origin(robot, element, None if carrier is None else joints[carrier], where)
        axis, turned = _axis(element, where)
        rounded = rounded or moved or turned
        kind = "prismatic" if element.kind == "prismatic" else "revolute"
        above = carrier_name(k, carrier, chosen)
        body = _body(robot, element, groups[k], where)
        made.append(Joint(plain_name(element.name), kind, None, above, axis=axis, origin=origin, body=body))
        if made[-1].name != element.name:
            notes.append(f"joint {element.name!r} is called {made[-1].name} in the model")
    if rounded:
        notes.append(f"angles of the file that are within {ROUNDED:g} rad of right ones are taken as those")
    notes += held_still(robot, joints)
    limits = {joint.name: limit for joint, item in zip(made, joints, strict=True) if (limit := limits_in(item, where))}
    model = ModelStructure(robot.name or "robot", gravity=gravity, limits=limits, joints=tuple(made))
    return RobotMachine(model, tuple(chosen), tuple(notes))


def _body(robot: RobotFile, joint: RobotJoint, group: Sequence[str], where: str) -> tuple[float, ...]:
    """The body that the file's links make which move with a joint, as `Joint.body`; () where they have no mass."""
    mass, first, about = 0.0, np.zeros(3), np.zeros((3, 3))
    for link in group:
        if link in robot.masses:
            own, place = robot.masses[link]
            step = joint.frame.T @ (place - joint.place)
            mass, first = mass + own, first + own * step
            about += joint.frame.T @ inertia_of(robot, link, where) @ joint.frame + own * _steiner(step)
    if not mass > 0.0:
        return ()
    centre = first / mass
    tensor = about - mass * _steiner(centre)
    return tuple(round(float(x), DIGITS) + 0.0 for x in (mass, *centre, *tensor[np.triu_indices(3)]))


def _steiner(step: Float) -> Float:
    """Return the inertia (3, 3) of 1 kg at `step` (3,) m."""
    return np.asarray(step @ step * np.eye(3) - np.outer(step, step))


def _origin(robot: RobotFile, one: RobotJoint, carrier: RobotJoint | None, where: str) -> tuple[Origin, bool]:
    """Return the origin of a joint's frame in that of the chosen joint that carries it, with joints between at zero,
    and True if an angle was taken as a right one.
    """
    by_child = {joint.child: joint for joint in robot.joints.values()}
    way = [one]
    while (above := by_child.get(way[-1].parent)) is not None and above is not carrier:
        way.append(above)
    place, turned, rounded = np.zeros(3), np.eye(3), False
    for joint in reversed(way):
        element = joint.element.find("origin")
        if element is None:
            continue
        xyz, rpy = (numbers_of(element, key, (0.0, 0.0, 0.0), where) for key in ("xyz", "rpy"))
        angles, changed = _right(rpy)
        own = Origin((float(xyz[0]), float(xyz[1]), float(xyz[2])), angles)
        if len(way) == 1:
            return own, changed
        rounded = rounded or changed
        place, turned = place + turned @ np.array(own.xyz), turned @ np.array(rotation(own))
    made, changed = _placed(place, turned)
    return made, rounded or changed


def origin_at(place: Float) -> Origin:
    """Return the origin of a frame at `place` (4, 4) in that of its carrier."""
    return _placed(place[:3, 3], place[:3, :3])[0]


def _placed(place: Float, turned: Float) -> tuple[Origin, bool]:
    """Return a place (3,) and orientation (3, 3), and whether an angle was taken as a right one."""
    x, y, z = (round(float(value), DIGITS) + 0.0 for value in place)
    angles, changed = _right(np.array(_rpy(turned)))
    return Origin((x, y, z), angles), changed


def _axis(one: RobotJoint, where: str) -> tuple[Vector, bool]:
    """Return the axis of a joint in its own frame, and whether it was taken as one of the frame's."""
    element = one.element.find("axis")
    given = np.array([1.0, 0.0, 0.0]) if element is None else numbers_of(element, "xyz", (1.0, 0.0, 0.0), where)
    unit = given / np.linalg.norm(given)
    small = (np.abs(unit) < ROUNDED) & (unit != 0.0)
    near = np.where(small, 0.0, unit)
    near = near / np.linalg.norm(near)
    return (float(near[0]), float(near[1]), float(near[2])), bool(small.any())


def _right(angles: Float) -> tuple[Vector, bool]:
    """Return angles with those near a multiple of a right one put there, and whether one was moved by more than
    rounding.
    """
    whole = np.round(angles / (0.5 * math.pi)) * 0.5 * math.pi
    near = np.abs(angles - whole) < ROUNDED
    moved = bool(np.any(near & (np.abs(angles - whole) > 1e-9)))
    x, y, z = (float(value) + 0.0 for value in np.where(near, whole, angles))
    return (x, y, z), moved


def _rpy(turned: Float) -> Vector:
    """Return the angles about the fixed axes x, y, z (in this order) of a rotation (3, 3)."""
    level = math.hypot(turned[0, 0], turned[1, 0])
    pitch = math.atan2(-turned[2, 0], level)
    if level < 1e-9:  # roll and yaw turn about one axis: all of it is told as roll
        return math.atan2(-turned[1, 2], turned[1, 1]), pitch, 0.0
    return math.atan2(turned[2, 1], turned[2, 2]), pitch, math.atan2(turned[1, 0], turned[0, 0])
