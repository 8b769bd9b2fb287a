"""A robot described by a URDF: its joints placed in the world at the file's zero pose, and the masses of its links.

Joints that are not selected stand still at zero. The file is read without entities, and neither fetched from nor
followed.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree.ElementTree import Element, TreeBuilder
from xml.parsers import expat

import numpy as np

from exoid.ground.errors import ExoidError, refused
from exoid.ground.inputs import open_input
from exoid.symbolic.motion import Float

LARGEST = 20_000_000
"""Bytes of a URDF; meshes are in files of their own."""
DEEPEST = 64
"""Elements inside each other; URDF has six."""
FARTHEST = 1e30
"""Of any number of a machine: beyond, products of places would overflow. Limits of 1e16 and the like mean none."""
MOVING = ("revolute", "continuous", "prismatic")
ENCODINGS = (LookupError, ValueError, TypeError)
"""What looking up an encoding raises; UnicodeError is a ValueError."""


class RobotFileError(ExoidError):
    """A URDF that cannot be read, or whose joints make no planar machine."""


@dataclass(frozen=True, eq=False)
class RobotJoint:
    """A joint of the file at its zero pose: its `place` (3,) m and `frame` (3, 3) in the world, and its `axis` (3,)."""

    name: str
    kind: str
    parent: str
    child: str
    place: Float
    frame: Float
    axis: Float
    element: Any


@dataclass(frozen=True, eq=False)
class RobotFile:
    """A robot's `joints` by name, in the order of the file, and the centre of mass (m) and mass (kg) of its links."""

    name: str
    joints: Mapping[str, RobotJoint]
    masses: Mapping[str, tuple[float, Float]]
    root: Any


def read_robot(path: str | Path) -> RobotFile:
    """Read a URDF; RobotFileError says what is wrong with it."""
    return parse_robot(read_bytes(path), str(path))


def read_bytes(path: str | Path) -> bytes:
    """Return the bytes of a URDF; RobotFileError where it cannot be read or is too large."""
    with refused(RobotFileError, "cannot be read: {}", path, "check the path"), open_input(path) as stream:
        data = stream.read(LARGEST + 1)
    if len(data) > LARGEST:
        raise RobotFileError("is too large for a URDF", where=str(path), remedy="give the URDF, not a mesh")
    return data


def parse_robot(data: bytes, where: str = "URDF") -> RobotFile:
    """Return the robot in the bytes of a URDF; RobotFileError says what is wrong with it."""
    root = _parsed(data, where)
    if root.tag != "robot":
        raise RobotFileError(f"is a <{root.tag[:40]}>, not a <robot>", where=where, remedy="give a URDF file")
    return _placed(root, where)


def _parsed(data: bytes, where: str) -> Element:
    """Return the root of the XML; a document type, and with it every entity, is refused before it can expand."""
    builder, depth = TreeBuilder(), 0

    def start(tag: str, attributes: dict[str, str]) -> None:
        nonlocal depth
        depth += 1
        if depth > DEEPEST:
            raise RobotFileError(f"has elements {depth} deep", where=where, remedy="give a URDF file")
        builder.start(tag, attributes)

    def end(tag: str) -> None:
        nonlocal depth
        depth -= 1
        builder.end(tag)

    def refuse(*_: Any) -> None:
        raise RobotFileError(
            "has a document type, whose entities are not expanded", where=where, remedy="delete the <!DOCTYPE ...> part"
        )

    parser = expat.ParserCreate()
    parser.StartElementHandler, parser.EndElementHandler = start, end
    parser.StartDoctypeDeclHandler = parser.EntityDeclHandler = refuse
    remedy = "expand it first: xacro robot.xacro > robot.urdf" if b"xacro" in data else "mend that line"
    # Python looks up encodings that expat does not know: not all are there, of single bytes, or of text.
    unknown = refused(RobotFileError, "has an encoding that is not read: {}", where, "save it as UTF-8", ENCODINGS)
    with unknown, refused(RobotFileError, "is not valid XML: {}", where, remedy, (expat.ExpatError,)):
        parser.Parse(data, True)
    return builder.close()


def _placed(root: Element, where: str) -> RobotFile:
    """Return the robot with all its joints at their places in the world, every joint at zero."""
    name, children = root.get("name", "robot"), {link.get("name", ""): link for link in root.iter("link")}
    elements = list(root.findall("joint"))
    for kind, found in (("joint", elements), ("link", root.findall("link"))):
        twice = [called for called, count in Counter(element.get("name", "") for element in found).items() if count > 1]
        if twice:
            raise RobotFileError(f"two {kind}s are called {twice[0][:60]!r}", where=where, remedy="rename one of them")
    of_child: dict[str, Any] = {}
    for item in elements:
        child = _link(item, "child", where)
        if child in of_child:
            raise RobotFileError(f"two joints carry link {child[:60]!r}", where=where, remedy="a URDF is a tree")
        of_child[child] = item
    frames: dict[str, tuple[Float, Float]] = {}

    def frame(link: str) -> tuple[Float, Float]:
        """Return place and orientation of a link in the world, from the root down."""
        way = []
        while link not in frames and link in of_child:
            way.append(link)
            link = _link(of_child[link], "parent", where)
            if len(way) > len(elements):
                raise RobotFileError("its joints go round in a circle", where=where, remedy="a URDF is a tree")
        if link not in frames:
            frames[link] = np.zeros(3), np.eye(3)
        for link_below in reversed(way):
            place, turned = frames[_link(of_child[link_below], "parent", where)]
            xyz, own = origin_of(of_child[link_below], where)
            frames[link_below] = place + turned @ xyz, turned @ own
        return frames[way[0] if way else link]

    joints = {}
    for entry in elements:
        child = _link(entry, "child", where)
        place, turned = frame(child)
        axis = entry.find("axis")
        direction = numbers_of(axis, "xyz", (1.0, 0.0, 0.0), where) if axis is not None else np.array([1.0, 0.0, 0.0])
        size = float(np.linalg.norm(direction))
        kind = entry.get("type", "")
        if kind in MOVING and not size > 0.0:
            at = f"{where}: joint {entry.get('name')}"
            raise RobotFileError("has an axis of length zero", where=at, remedy="mend it")
        parent = _link(entry, "parent", where)
        joints[entry.get("name", "")] = RobotJoint(
            entry.get("name", ""), kind, parent, child, place, turned, turned @ direction / (size or 1.0), entry
        )
    masses = {}
    for link, element in children.items():
        inertial = element.find("inertial")
        mass = None if inertial is None else inertial.find("mass")
        if inertial is not None and mass is not None:
            place, turned = frame(link)
            weight = float(numbers_of(mass, "value", (0.0,), where)[0])
            if weight < 0.0:
                what = f"link {link[:60]!r} has a negative mass, {weight:g} kg"
                raise RobotFileError(what, where=where, remedy="mend it")
            masses[link] = weight, place + turned @ origin_of(inertial, where)[0]
    return RobotFile(name, joints, masses, root)


def _link(joint: Element, which: str, where: str) -> str:
    found = joint.find(which)
    if found is None or not found.get("link"):
        raise RobotFileError(f"joint {joint.get('name')!r} has no {which}", where=where, remedy="mend the URDF")
    return str(found.get("link"))


def numbers_of(element: Element, key: str, default: Sequence[float], where: str) -> Float:
    """Return the numbers of an attribute; RobotFileError where they are none."""
    text = element.get(key)
    if text is None:
        return np.array(default)
    try:
        values = np.array([float(part) for part in text.split()])
    except ValueError:
        values = np.array([math.nan])
    if len(values) != len(default) or not np.all(np.abs(values) <= FARTHEST):
        raise RobotFileError(
            f'{key}="{text[:60]}" is not {len(default)} numbers', where=f"{where}: <{element.tag}>", remedy="mend it"
        )
    return values


def inertia_of(robot: RobotFile, link: str, where: str) -> Float:
    """Return the inertia (3, 3) of a link about its centre of mass, in the world at the file's zero; zero if unsaid."""
    element = next((item for item in robot.root.iter("link") if item.get("name") == link), None)
    inertial = None if element is None else element.find("inertial")
    inertia = None if inertial is None else inertial.find("inertia")
    joint = next((entry for entry in robot.joints.values() if entry.child == link), None)
    if inertial is None or inertia is None or joint is None:
        return np.zeros((3, 3))
    xx, xy, xz, yy, yz, zz = (
        float(numbers_of(inertia, key, (0.0,), where)[0]) for key in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
    )
    turned = joint.frame @ origin_of(inertial, where)[1]
    return np.asarray(turned @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ turned.T)


def origin_of(element: Element, where: str) -> tuple[Float, Float]:
    """Return place (3,) and orientation (3, 3) of an element's <origin>."""
    from scipy.spatial.transform import Rotation

    origin = element.find("origin")
    if origin is None:
        return np.zeros(3), np.eye(3)
    turned = Rotation.from_euler("xyz", numbers_of(origin, "rpy", (0.0, 0.0, 0.0), where))
    return numbers_of(origin, "xyz", (0.0, 0.0, 0.0), where), turned.as_matrix()
