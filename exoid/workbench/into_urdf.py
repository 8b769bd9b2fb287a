"""Identified numbers back into the user's own URDF: masses, centres of mass, inertias and friction of the joints
identified, and not a byte of anything else.

The links that move with a joint are one body to the identification. Its numbers go into the joint's child link; what is
fixed to that link loses its own inertial. Of the many bodies with the identified parameters those nearest to what the
file said are taken (`exoid/optimisation/linear/links.py`).
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from xml.parsers import expat

from exoid.optimisation.linear.links import LinkInertia, tree_of
from exoid.symbolic.joints import HERE, Joint, parents
from exoid.symbolic.mechanics.spatial import rotation
from exoid.symbolic.planar_machine import PlanarMachine, moving_with, plain_name, planar_machine
from exoid.symbolic.robot_file import RobotFile, RobotJoint, inertia_of, parse_robot, read_bytes
from exoid.symbolic.spatial_machine import spatial_machine
from exoid.workbench.bodies import bodies_of, friction_of, left_out, links_of, terms_of
from exoid.workbench.export.urdf import inertial_of
from exoid.workbench.identified import ExportError, Ready

START_TAG = re.compile(rb"<[^\s/>]+(?:\s+[^\s=>]+\s*=\s*(?:\"[^\"]*\"|'[^']*'))*\s*(/?)>")
SAME_LENGTH = 1e-6
"""m within which lengths of model and file are the same."""


@dataclass(frozen=True)
class _Span:
    """An element in the bytes of the file: [start, end), its start tag up to `inside`, closed there if `empty`."""

    start: int
    inside: int
    end: int
    empty: bool


def into_urdf(ready: Ready, path: str | Path) -> tuple[bytes, tuple[str, ...]]:
    """Return the URDF at `path` with the numbers of `ready` in it, and what is worth saying about that.

    RobotFileError where the file makes no planar machine of the model's joints, ExportError where it is another one or
    no links of positive mass have the numbers.
    """
    where, data = str(path), read_bytes(path)
    robot = parse_robot(data, where)
    joints = _named(ready, robot, where)
    groups = moving_with(robot, joints)
    texts = (
        _in_space(ready, robot, joints, where) if ready.model.spatial
        else _in_a_plane(ready, robot, joints, groups, where)
    )  # fmt: skip
    spans = _spans(data, where)
    edits: list[tuple[int, int, bytes]] = []
    notes: list[str] = []
    for k, (joint, group) in enumerate(zip(joints, groups, strict=True)):
        edits.append(_placed(spans, data, ("link", joint.child), "inertial", texts[k]))
        emptied = [link for link in group if link != joint.child and ("inertial", link) in spans]
        for link in emptied:
            span = spans["inertial", link]
            edits.append((span.start, span.end, b"<!-- its inertia is in link " + _comment(joint.child) + b" -->"))
        if emptied:
            notes.append(f"{', '.join(emptied)} moves with {joint.child}, whose inertial now holds both")
        viscous, coulomb = friction_of(ready, ready.model.joint_names[k])
        text = f'<dynamics damping="{viscous!r}" friction="{coulomb!r}"/>'
        edits.append(_placed(spans, data, ("joint", joint.name), "dynamics", text))
    missing = left_out(ready)
    if missing != "nothing":
        rotors = {joint: ready.linear[f"{term.name}.c"] for joint, term in terms_of(ready, "rotor_inertia").items()}
        sizes = ", ".join(f"{joint} {size:.4g}" for joint, size in rotors.items())
        notes.append(f"URDF cannot carry {missing}" + (f"; armature in a simulator: {sizes} kg·m²" if sizes else ""))
    for start, end, new in sorted(edits, reverse=True):
        data = data[:start] + new + data[end:]
    parse_robot(data, where)  # what is written can be read
    return data, tuple(notes)


def _in_a_plane(
    ready: Ready, robot: RobotFile, joints: Sequence[RobotJoint], groups: Sequence[Sequence[str]], where: str
) -> list[str]:
    """Return the <inertial> of every joint's child link (J,)."""
    machine = _matched(ready, robot, joints, where)
    known = [
        _known(robot, machine, k, joint, group, where)
        for k, (joint, group) in enumerate(zip(joints, groups, strict=True))
    ]
    near = [item for item in known if item is not None]
    links = links_of(ready, near if len(near) == len(known) else None)
    return [
        _inertial(robot, machine, k, joint, entry, where)
        for k, (joint, entry) in enumerate(zip(joints, links, strict=True))
    ]


def _in_space(ready: Ready, robot: RobotFile, joints: Sequence[RobotJoint], where: str) -> list[str]:
    """Return the same for a spatial machine."""
    found = spatial_machine(robot, [joint.name for joint in joints], where=where).model
    for mine, other in zip(ready.model.joints, found.joints, strict=True):
        if not _same_place(mine, other):
            raise ExportError(
                f"{mine.name} has another kind, axis or origin in the model than in the file",
                where=where,
                remedy="make the model from this file (exoid model --from-urdf) and identify it",
            )
    if parents(ready.model.joints) != parents(found.joints):
        raise ExportError("its joints hang from each other otherwise than in the model", where=where,
                          remedy="make the model from this file (exoid model --from-urdf) and identify it")  # fmt: skip
    return [inertial_of(entry) for entry in bodies_of(ready, found.joints)]


def _same_place(mine: Joint, other: Joint) -> bool:
    """True if two joints move alike, in the same place."""
    import numpy as np

    places = [joint.origin or HERE for joint in (mine, other)]
    first, second = (
        np.vstack([joint.axis or np.zeros(3), place.xyz, rotation(place)])
        for joint, place in zip((mine, other), places, strict=True)
    )
    return mine.kind == other.kind and bool(np.abs(first - second).max() <= SAME_LENGTH)


def _named(ready: Ready, robot: RobotFile, where: str) -> list[RobotJoint]:
    """Return the model's joints in the file, in the model's order."""
    names, found = {plain_name(name): name for name in robot.joints}, []
    for joint in ready.model.joint_names:
        if joint not in names:
            raise ExportError(
                f"the URDF has no joint {joint!r}", where=where,
                remedy=f"its joints are {', '.join(robot.joints)}; exoid model --from-urdf makes a model of them",
            )  # fmt: skip
        found.append(robot.joints[names[joint]])
    return found


def _matched(ready: Ready, robot: RobotFile, joints: Sequence[RobotJoint], where: str) -> PlanarMachine:
    """Return the planar machine of the file that is the model's."""
    machine = planar_machine(robot, [joint.name for joint in joints], ready.model.gravity, where)
    for mine, other in zip(tree_of(ready.model), machine.model.chain, strict=True):
        lengths = [0.0 if item.length is None else item.length for item in (mine, other)]
        if mine.kind != other.kind or (other.length is not None and abs(lengths[0] - lengths[1]) > SAME_LENGTH):
            raise ExportError(
                f"{mine.name} is {mine.kind}, {lengths[0]:g} m long in the model, "
                f"{other.kind}, {lengths[1]:g} m in the file",
                where=where,
                remedy="make the model from this file (exoid model --from-urdf) and identify it",
            )
    if parents(tree_of(ready.model)) != parents(machine.model.chain):
        raise ExportError("its joints hang from each other otherwise than in the model", where=where,
                          remedy="make the model from this file (exoid model --from-urdf) and identify it")  # fmt: skip
    return machine


def _known(
    robot: RobotFile, machine: PlanarMachine, k: int, joint: RobotJoint, group: Sequence[str], where: str
) -> LinkInertia | None:
    """Return the inertia in the file of the body that moves with a joint; None where it is no body."""
    import numpy as np

    along, side = machine.along[k], np.cross(machine.normal, machine.along[k])
    inertia = first = across = mass = 0.0
    for link in group:
        if link not in robot.masses:
            continue
        own, place = robot.masses[link]
        step = place - joint.place
        x, y = float(step @ along), float(step @ side)
        turned = inertia_of(robot, link, where)
        inertia += float(machine.normal @ turned @ machine.normal) + own * (x**2 + y**2)
        first, across, mass = first + own * x, across + own * y, mass + own
    body = LinkInertia(inertia, first, across, mass)
    return body if mass > 0.0 and body.about_centre > 0.0 else None


def _inertial(robot: RobotFile, machine: PlanarMachine, k: int, joint: RobotJoint, one: LinkInertia, where: str) -> str:
    """Return the <inertial> of a joint's child link: the file's own tensor, scaled, where it has one."""
    import numpy as np

    along, normal = machine.along[k], machine.normal
    out = float((robot.masses[joint.child][1] - joint.place) @ normal) if joint.child in robot.masses else 0.0
    centre = one.centre[0] * along + one.centre[1] * np.cross(normal, along) + out * normal
    tensor = inertia_of(robot, joint.child, where)
    before = float(normal @ tensor @ normal)
    proper = before > 0.0 and np.linalg.eigvalsh(tensor).min() > 0.0
    scaled = tensor * (one.about_centre / before) if proper else one.about_centre * np.eye(3)
    own = joint.frame.T @ scaled @ joint.frame
    xyz = " ".join(repr(float(value)) for value in joint.frame.T @ centre)
    places = (("ixx", 0, 0), ("ixy", 0, 1), ("ixz", 0, 2), ("iyy", 1, 1), ("iyz", 1, 2), ("izz", 2, 2))
    entries = " ".join(f'{name}="{float(own[i, j])!r}"' for name, i, j in places)
    return f'<inertial><origin xyz="{xyz}" rpy="0 0 0"/><mass value="{one.mass!r}"/><inertia {entries}/></inertial>'


def _placed(
    spans: dict[tuple[str, str], _Span], data: bytes, owner: tuple[str, str], tag: str, text: str
) -> tuple[int, int, bytes]:
    """Return the edit (start, end, new bytes) that gives an element of the file a child `tag` with this text."""
    inside, new = spans.get((tag, owner[1])), text.encode("ascii")
    if inside is not None:
        return inside.start, inside.end, new
    outer = spans[owner]
    if not outer.empty:
        return outer.inside, outer.inside, new
    opened = data[outer.start : outer.end].rstrip(b">").rstrip().rstrip(b"/").rstrip()
    return outer.start, outer.end, opened + b">" + new + b"</" + owner[0].encode("ascii") + b">"


def _spans(data: bytes, where: str) -> dict[tuple[str, str], _Span]:
    """Return the places in the file of links, joints, and their <inertial> and <dynamics> (by the same name)."""
    found: dict[tuple[str, str], _Span] = {}
    open_: list[tuple[str, str, int, int, bool]] = []

    def start(tag: str, attributes: dict[str, str]) -> None:
        at = parser.CurrentByteIndex
        match = START_TAG.match(data, at)
        if match is None:
            raise ExportError("is not plain UTF-8 XML", where=where, remedy="save the URDF as UTF-8")
        open_.append((tag, attributes.get("name", ""), at, match.end(), bool(match[1])))

    def end(tag: str) -> None:
        _, name, at, inside, empty = open_.pop()
        stop = inside if empty else data.index(b">", parser.CurrentByteIndex) + 1
        span = _Span(at, inside, stop, empty)
        if len(open_) == 1 and tag in ("link", "joint"):
            found[tag, name] = span
        elif len(open_) == 2 and (open_[1][0], tag) in (("link", "inertial"), ("joint", "dynamics")):
            found[tag, open_[1][1]] = span

    parser = expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.Parse(data, True)
    return found


def _comment(name: str) -> bytes:
    return re.sub(r"[^A-Za-z0-9_.]", "_", name).encode("ascii")
