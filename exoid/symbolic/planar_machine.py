"""A planar machine out of a robot file: which joints make a chain or a tree in one plane, and how long its links are.

exoid's angles are zero where a machine hangs straight down, so the file's zero pose has to be that; a plane that lies
flat has no down, and any direction will do.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exoid.ground.suggest import nearest
from exoid.symbolic.joints import JOINT_NAME, MOST, TAKEN, Joint
from exoid.symbolic.model_structure import STANDARD_GRAVITY, Limits, ModelStructure
from exoid.symbolic.motion import Float
from exoid.symbolic.robot_file import MOVING, RobotFile, RobotFileError, RobotJoint, numbers_of

PARALLEL = 1e-3
"""rad within which directions count as the same."""
NEAREST = 1e-4
"""m between two joints below which they are at one place."""
OFF_AXIS = 0.02
"""rad by which a centre of mass may lie beside its link's axis before it becomes an effect of the model."""
GRAVITY = STANDARD_GRAVITY
SPATIAL = "exoid model --from-urdf makes a spatial machine of them"
MEASURED = 'Where it moves, measure that and write [base] motion = "measured" into the model file'


class NotPlanarError(RobotFileError):
    """Joints that move, but not as the links of one plane that hang straight down at zero."""


@dataclass(frozen=True, eq=False)
class PlanarMachine:
    """The `model` of a planar machine, the names its joints have in the file, and what is worth saying about it.

    `normal` (3,) is that of the plane, `along` (3,) each the direction of every link's axis at the file's zero.
    """

    model: ModelStructure
    names: tuple[str, ...]
    notes: tuple[str, ...]
    normal: Float
    along: tuple[Float, ...]


def planar_machine(
    robot: RobotFile, names: Sequence[str] = (), gravity: float | None = None, where: str = "URDF"
) -> PlanarMachine:
    """Return the planar machine that the joints called `names` (default: all that move) make.

    `gravity` in m/s² is that within the plane, for one that is neither upright nor flat. RobotFileError says what is
    wrong with the joints, NotPlanarError why they make no planar machine.
    """
    joints, parents = chosen_joints(robot, names, where)
    chosen = [joint.name for joint in joints]
    normal = _normal(joints, where)
    upright = abs(float(normal[2])) < PARALLEL
    if gravity is None:
        if not upright and abs(float(normal[2])) < 1.0 - PARALLEL:
            lean = math.degrees(math.asin(min(1.0, abs(float(normal[2])))))
            raise NotPlanarError(
                f"the plane of these joints leans by {lean:.1f}°: it is neither upright nor flat",
                where=where,
                remedy=SPATIAL,
            )
        level = all(element.kind == "prismatic" and abs(float(element.axis[2])) < PARALLEL for element in joints)
        gravity = GRAVITY if upright and not level else 0.0
    directions = _directions(joints, parents, normal, gravity, where)
    made, notes = [], []
    for k, item in enumerate(joints):
        below = [joints[j].place - item.place for j, parent in enumerate(parents) if parent == k]
        lengths = [float(np.linalg.norm(step - step @ normal * normal)) for step in below]
        made.append(
            Joint(
                plain_name(item.name),
                "prismatic" if item.kind == "prismatic" else "revolute",
                lengths[0] if lengths else None,
                carrier_name(k, parents[k], chosen),
            )
        )
        if made[-1].name != item.name:
            notes.append(f"joint {item.name!r} is called {made[-1].name} in the model")
    limits = {joint.name: limit for joint, item in zip(made, joints, strict=True) if (limit := limits_in(item, where))}
    model = ModelStructure(robot.name or "robot", gravity=gravity, limits=limits, joints=tuple(made))
    for k, name in enumerate(_off_axis(robot, joints, directions, normal)):
        if name and (gravity > 0.0 or parents[k] is not None):
            model = model.with_effect(f"com_offset:{made[k].name}")
            term = model.terms[-1].name
            notes.append(f"the mass of link {made[k].name} lies beside its axis: {term} is in the model")
    notes += [f"{entry} {MEASURED}" for entry in held_still(robot, joints)]
    return PlanarMachine(model, tuple(chosen), tuple(notes), normal, tuple(directions))


def chosen_joints(
    robot: RobotFile, names: Sequence[str], where: str
) -> tuple[list[RobotJoint], list[int | None]]:
    """Return the joints called `names` (default: all that move, carriers before what they carry), and which of them
    carries each (J,); RobotFileError says what is wrong with them.
    """
    chosen = list(names) or [name for name, joint in robot.joints.items() if joint.kind in MOVING]
    _check_names(robot, chosen, where)
    joints = [robot.joints[name] for name in chosen]
    if len(joints) > MOST:
        what = f"{len(joints)} joints move, and a machine has at most {MOST}"
        raise RobotFileError(what, where=where, remedy="choose those of one machine with --joints")
    if not names:
        joints = _carriers_first(robot, joints)
    return joints, _parents(robot, joints, where)


def _carriers_first(robot: RobotFile, joints: Sequence[RobotJoint]) -> list[RobotJoint]:
    """Return joints in the order of the file, but each behind those that carry it."""
    by_child, found = {element.child: element for element in robot.joints.values()}, dict[str, RobotJoint]()
    wanted = {item.name for item in joints}
    for joint in joints:
        way: list[RobotJoint] = []
        above: RobotJoint | None = joint
        while above is not None and above.name not in found:
            way.append(above)
            above = by_child.get(above.parent)
        found |= {each.name: each for each in reversed(way)}
    return [entry for entry in found.values() if entry.name in wanted]


def held_still(robot: RobotFile, joints: Sequence[RobotJoint]) -> list[str]:
    """Return sentences about joints that carry the machine and are not in it: it hangs from a base that stands still.
    """
    by_child, chosen = {entry.child: entry for entry in robot.joints.values()}, {element.name for element in joints}
    above: dict[str, RobotJoint] = {}
    for joint in joints:
        carrier = by_child.get(joint.parent)
        while carrier is not None and carrier.name not in above:
            if carrier.kind != "fixed" and carrier.name not in chosen:
                above[carrier.name] = carrier
            carrier = by_child.get(carrier.parent)
    return [
        f"joint {item.name!r} ({item.kind or 'of no type'}) carries the machine and is not in it: it is taken to stand "
        "still at zero."
        for item in above.values()
    ]


def carrier_name(index: int, parent: int | None, names: Sequence[str]) -> str | None:
    """Return the `parent` of a joint in a model file; None where that is the joint before, or the first's base."""
    if parent is None:
        return "base" if index else None
    return None if parent == index - 1 else plain_name(names[parent])


def plain_name(name: str) -> str:
    """Return a joint's name as a model can have it."""
    text = re.sub(r"[^A-Za-z0-9_]", "_", name)[:40]
    return text if JOINT_NAME.fullmatch(text) and text not in TAKEN else f"joint_{text}"[:40]


def _check_names(robot: RobotFile, chosen: Sequence[str], where: str) -> None:
    movable = [name for name, joint in robot.joints.items() if joint.kind in MOVING]
    for k, name in enumerate(chosen):
        if name not in robot.joints:
            near = nearest(name, robot.joints, 1)
            raise RobotFileError(
                f"has no joint {name[:60]!r}",
                where=where,
                remedy=f"did you mean {near[0]}?" if near else f"its joints are {', '.join(movable)}",
            )
        if robot.joints[name].kind not in MOVING:
            raise RobotFileError(
                f"joint {name!r} is {robot.joints[name].kind or 'of no type'}",
                where=where,
                remedy=f"choose among {', '.join(movable) or 'nothing: no joint moves'}",
            )
        follows = robot.joints[name].element.find("mimic")
        if follows is not None:
            raise RobotFileError(
                f"joint {name!r} does not move by itself: it mimics {follows.get('joint', '')[:60]!r}",
                where=where,
                remedy="leave it out with --joints: it then stands still at zero",
            )
        if name in chosen[:k]:
            raise RobotFileError(f"joint {name!r} is named twice", where=where, remedy="name each once")
    if not chosen:
        macros = any("xacro" in str(item.tag) for item in robot.root.iter())
        expand = "expand it first: xacro robot.xacro > robot.urdf"
        remedy = expand if macros else "give the URDF of a machine with joints"
        raise RobotFileError("has no joint that moves", where=where, remedy=remedy)


def _parents(robot: RobotFile, joints: Sequence[RobotJoint], where: str) -> list[int | None]:
    """Return the index of the joint that carries each; RobotFileError where one comes before its carrier."""
    by_child = {joint.child: joint for joint in robot.joints.values()}
    index = {entry.name: k for k, entry in enumerate(joints)}
    found: list[int | None] = []
    for k, item in enumerate(joints):
        above: RobotJoint | None = by_child.get(item.parent)
        while above is not None and above.name not in index:
            above = by_child.get(above.parent)
        if above is not None and index[above.name] > k:
            raise RobotFileError(
                f"{item.name} hangs from {above.name}, which is named after it", where=where, remedy="name it first"
            )
        found.append(None if above is None else index[above.name])
    return found


def _normal(joints: Sequence[RobotJoint], where: str) -> Float:
    """Return the unit normal (3,) of the plane in which all joints move; positive angles turn forwards about it."""
    turning = [entry for entry in joints if entry.kind != "prismatic"]
    if turning:
        normal = turning[0].axis
    else:
        first = joints[0].axis
        side = np.cross(first, [0.0, 0.0, 1.0])
        normal = side if np.linalg.norm(side) > PARALLEL else np.array([0.0, -1.0, 0.0])
        normal = normal / np.linalg.norm(normal)
    for item in turning:
        if np.linalg.norm(np.cross(item.axis, normal)) > PARALLEL:
            raise NotPlanarError(
                f"the axes of {turning[0].name} and {item.name} are not parallel: they do not move in one plane",
                where=where,
                remedy=SPATIAL,
            )
        if item.axis @ normal < 0.0:
            raise NotPlanarError(
                f"the axis of {item.name} points against that of {turning[0].name}: their angles have opposite signs",
                where=where,
                remedy=SPATIAL,
            )
    for joint in joints:
        if joint.kind == "prismatic" and abs(float(joint.axis @ normal)) > PARALLEL:
            raise NotPlanarError(
                f"{joint.name} slides out of the plane of the others", where=where, remedy=SPATIAL
            )
    return np.asarray(normal, dtype=float)


def _directions(
    joints: Sequence[RobotJoint], parents: Sequence[int | None], normal: Float, gravity: float, where: str
) -> list[Float]:
    """Return the direction (3,) of every link's axis; NotPlanarError where the zero pose is not the straight one."""
    fall = np.array([0.0, 0.0, -1.0])
    fall = fall - fall @ normal * normal
    down = fall / np.linalg.norm(fall) if np.linalg.norm(fall) > PARALLEL else None
    found: list[Float] = []
    for k, joint in enumerate(joints):
        steps = [joints[j].place - joint.place for j, parent in enumerate(parents) if parent == k]
        steps = [step - step @ normal * normal for step in steps]
        if any(np.linalg.norm(step) < NEAREST for step in steps):
            what = f"what hangs from {joint.name} sits on its own axis"
            raise NotPlanarError(what, where=where, remedy=SPATIAL)
        if any(np.linalg.norm(step - steps[0]) > NEAREST for step in steps[1:]):
            raise NotPlanarError(
                f"the joints that hang from {joint.name} sit at different places", where=where, remedy=SPATIAL
            )
        above = down if gravity > 0.0 else None
        if parents[k] is not None:
            above = found[int(parents[k] or 0)]
        own = steps[0] / np.linalg.norm(steps[0]) if steps else None
        if joint.kind == "prismatic":
            own = joint.axis if own is None else own
            if np.linalg.norm(joint.axis - own) > PARALLEL:
                raise NotPlanarError(
                    f"{joint.name} does not slide along its own link", where=where, remedy=SPATIAL
                )
        if own is None:
            own = above if above is not None else np.array([1.0, 0.0, 0.0])
        if above is not None and np.linalg.norm(own - above) > PARALLEL:
            angle = math.atan2(float(normal @ np.cross(above, own)), float(above @ own))
            straight = "down" if parents[k] is None else f"on from {joints[int(parents[k] or 0)].name}"
            what = f"at the file's zero, {joint.name} points {abs(angle):.4g} rad away from straight {straight}"
            if joint.kind == "prismatic":
                raise NotPlanarError(what, where=where, remedy=SPATIAL)
            raise NotPlanarError(
                what,
                where=where,
                remedy=SPATIAL,
            )
        found.append(own)
    return found


def limits_in(one: RobotJoint, where: str) -> Limits | None:
    """Return the limits of a joint, infinite where the file has none; None where it has no limit at all."""
    element = one.element.find("limit")
    if element is None:
        return None
    low, high = (float(numbers_of(element, key, (0.0,), where)[0]) for key in ("lower", "upper"))
    if one.kind == "continuous" or not low < high:
        low, high = -math.inf, math.inf
    velocity = float(numbers_of(element, "velocity", (0.0,), where)[0])
    if not velocity > 0.0 and math.isinf(low):
        return None
    return Limits((low, high), velocity if velocity > 0.0 else math.inf, math.inf)


def _off_axis(robot: RobotFile, joints: Sequence[RobotJoint], directions: Sequence[Float], normal: Float) -> list[bool]:
    """Flags of joints: the mass that moves with each joint alone lies beside its link's axis."""
    found = []
    for joint, along, links in zip(joints, directions, moving_with(robot, joints), strict=True):
        known = [robot.masses[link] for link in links if link in robot.masses]
        whole = sum(mass for mass, _ in known)
        if joint.kind == "prismatic" or not whole > 0.0:
            found.append(False)
            continue
        centre = sum((mass * (place - joint.place) for mass, place in known), start=np.zeros(3)) / whole
        beside = float(centre @ np.cross(normal, along))
        found.append(abs(beside) > OFF_AXIS * float(np.linalg.norm(centre)) and abs(beside) > NEAREST)
    return found


def moving_with(robot: RobotFile, joints: Sequence[RobotJoint]) -> list[list[str]]:
    """Return the links that move with each of the joints and with no later one."""
    names = {item.name: k for k, item in enumerate(joints)}
    by_child = {joint.child: joint for joint in robot.joints.values()}
    found: list[list[str]] = [[] for _ in joints]
    owners: dict[str, int | None] = {}
    for link in by_child:
        way = [link]  # every link is asked once: a cable of thousands of links hangs from the last joint
        while way[-1] not in owners and way[-1] in by_child and by_child[way[-1]].name not in names:
            way.append(by_child[way[-1]].parent)
        top = way[-1]
        own = names.get(by_child[top].name) if top in by_child else None
        owner = owners.get(top, own)
        owners.update(dict.fromkeys(way, owner))
        if owner is not None:
            found[owner].append(link)
    return found
