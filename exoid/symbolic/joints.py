"""The joints of a machine as data: names, kinds, where they sit, and who hangs from whom.

A chain by default, a tree with `parent`. Of a planar machine a joint says the `length` of its link. Angles are as in
the leg: the first link's from the downward vertical, each further one's relative to its parent link. A prismatic joint
slides its link along the link's own axis.

A machine is spatial where a joint says its `axis` or its `origin`; then all of them do, as a URDF does: the joint's
frame lies at `origin` in the frame of the link that carries it, and its link turns about `axis`, or slides along it.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

from exoid.ground.errors import EffectError

KINDS = ("revolute", "prismatic")
BASE = "base"
"""Name of what does not move, as a joint's `parent`."""
FARTHEST = 1e6
"""m or rad of an origin, beyond which it is a mistake."""
MOST = 12
"""Joints of one machine."""
JOINT_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
TAKEN = frozenset((BASE, "both", "next", "t"))
UNITS = {"q": ("rad", "m"), "dq": ("rad/s", "m/s"), "ddq": ("rad/s²", "m/s²"), "tau": ("N·m", "N"), "f": ("N", "N")}
SHORTEST, LONGEST = 1e-3, 100.0
"""m between two joints, from a watch's to a crane's: other numbers are slips, and sums with their squares lose all
others."""
LIGHTEST, HEAVIEST = 1e-3, 100.0
"""m/s² of gravity, where there is any."""
LEVER = 0.1
"""m that a sliding joint moves where a turning one moves 1 rad, in thresholds written for angles: a drum of this
radius."""
SLIDING = (("kg·m²", "kg"), ("(N·m)", "N"), ("N·m", "N"), ("rad", "m"))
"""Units of a turning joint, and what they are where it slides."""

Vector = tuple[float, float, float]
Rows = tuple[tuple[float, ...], ...]
UNIT = 1e-12
"""Difference of an axis's length from 1 up to which it is one already: what is read again stays what it was."""


def three_numbers(given: Any, what: str) -> Vector:
    """Return three finite numbers; EffectError where they are something else."""
    try:
        values = tuple(float(value) for value in given)
    except (TypeError, ValueError):
        values = ()
    if len(values) != 3 or not all(math.isfinite(value) and abs(value) <= FARTHEST for value in values):
        raise EffectError(f"{what} is {str(given)[:60]}", where="joints", remedy="give three numbers")
    return values[0], values[1], values[2]


def _unit(axis: Vector) -> Vector:
    size = math.hypot(*axis)
    if not size > 0.0:
        raise EffectError("an axis has the length zero", where="joints", remedy="give its direction, such as [0, 0, 1]")
    if abs(size - 1.0) <= UNIT:
        return axis
    return axis[0] / size, axis[1] / size, axis[2] / size


@dataclass(frozen=True)
class Origin:
    """Place of a joint's frame in that of the link that carries it: `xyz` m, and the angles `rpy` rad about the fixed
    axes x, y, z in this order (URDF's roll, pitch and yaw).
    """

    xyz: Vector = (0.0, 0.0, 0.0)
    rpy: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        for name in ("xyz", "rpy"):
            object.__setattr__(self, name, three_numbers(getattr(self, name), f"the origin's {name}"))
        if not max(map(abs, (*self.xyz, *self.rpy))) <= LONGEST:
            what = f"the origin is {list(self.xyz)} m, {list(self.rpy)} rad away"
            raise EffectError(what, where="joints", remedy=f"give m and rad, up to {LONGEST:g}")


HERE = Origin()
"""Of a joint that says no origin: where its parent's joint, or the base, is."""


@dataclass(frozen=True)
class Joint:
    """A joint and its link: `length` in m from the joint to where the next one sits (None: nothing hangs there), or, of
    a spatial machine, the `axis` (3,) in its own frame and the `origin` of that.

    `parent` is the joint whose link carries this one, "base" for the base, None for the joint before. The axis is made
    a unit vector; three numbers are an origin without rotation. EffectError for an axis or an origin that is none.
    `motor` says how far the motor of its name turns (rad) for each rad of joints, {joint: ratio}: its gear, and what
    couples it to others; empty where motors are not spoken of. `body` is what a robot's file says of the link: mass kg,
    centre of mass (3,) m in the joint's frame, inertia about that (xx, xy, xz, yy, yz, zz); it is fitted, not believed.
    """

    name: str
    kind: str = "revolute"
    length: float | None = None
    parent: str | None = None
    axis: Vector | None = None
    origin: Origin | None = None
    motor: tuple[tuple[str, float], ...] = ()
    body: tuple[float, ...] = field(default=(), compare=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, "motor", tuple(dict(self.motor).items()))
        if self.axis is not None:
            object.__setattr__(self, "axis", _unit(three_numbers(self.axis, f"the axis of {self.name}")))
        if self.origin is not None and not isinstance(self.origin, Origin):
            object.__setattr__(self, "origin", Origin(self.origin))

    @property
    def turns(self) -> bool:
        """True if it is revolute (rad, N·m); a prismatic joint has m and N."""
        return self.kind == "revolute"

    @property
    def reach(self) -> float:
        """Amount of its own unit that counts as 1 rad in thresholds written for angles."""
        return 1.0 if self.turns else LEVER

    def unit(self, quantity: str) -> str:
        """Return the SI unit of its "q", "dq", "ddq", "tau" or "f"."""
        return UNITS[quantity][not self.turns]


LEG = (Joint("hip", length=0.40), Joint("knee"))
"""The joints of the leg; which length its thigh has is the model's to say."""


UNNAMED = "joint"
"""Before a number: the joint of a recording whose machine nobody named."""


def names(joints: Sequence[Joint]) -> tuple[str, ...]:
    """Return the names of `joints` (J,)."""
    return tuple(joint.name for joint in joints)


def units(joints: Sequence[Joint], quantity: str) -> str:
    """Return the unit of a quantity of all `joints` in words: "N·m", or "N·m, N" where some turn and some slide."""
    return ", ".join(dict.fromkeys(joint.unit(quantity) for joint in joints))


def is_spatial(joints: Sequence[Joint]) -> bool:
    """True if these are joints of a spatial machine: one says an axis or an origin."""
    return any(joint.axis is not None or joint.origin is not None for joint in joints)


def is_leg(joints: Sequence[Joint]) -> bool:
    """True if these are hip and knee of a leg, whatever the length of its thigh."""
    turning = all(joint.turns for joint in joints) and not is_spatial(joints)
    return turning and names(joints) == names(LEG) and parents(joints) == (None, 0)


def machine_word(joints: Sequence[Joint]) -> str:
    """Word for a machine of these joints in a sentence: "leg" or "machine"."""
    return "leg" if is_leg(joints) else "machine"


def check_joints(joints: Sequence[Joint]) -> None:
    """Refuse joints that make no machine: EffectError with the joint."""
    if not 1 <= len(joints) <= MOST:
        raise EffectError(f"{len(joints)} joints", where="joints", remedy=f"give 1 to {MOST}")
    names, spatial = [joint.name for joint in joints], is_spatial(joints)
    for k, joint in enumerate(joints):
        where = f"joint {k + 1} ({joint.name[:40]})"
        if joint.name in TAKEN:
            raise EffectError(
                f"no joint can be called {joint.name!r}, which has a meaning of its own",
                where=where,
                remedy="rename it",
            )
        if not JOINT_NAME.fullmatch(joint.name):
            raise EffectError(
                f"{joint.name[:40]!r} is not a joint's name",
                where=where,
                remedy="use a letter first, then letters (a to z), digits and _, 40 characters at most",
            )
        if joint.name in names[:k]:
            raise EffectError(f"there are two joints called {joint.name!r}", where=where, remedy="rename one")
        if joint.kind not in KINDS:
            raise EffectError(f"unknown kind {joint.kind!r}", where=where, remedy='use "revolute" or "prismatic"')
        if joint.length is not None and joint.length != 0.0 and not SHORTEST <= joint.length <= LONGEST:
            remedy = f"give 0, or {SHORTEST:g} to {LONGEST:g} (m)"
            raise EffectError(f"length is {joint.length!r}", where=where, remedy=remedy)
        if joint.parent is not None and joint.parent != BASE and joint.parent not in names[:k]:
            raise EffectError(
                f"there is no joint {joint.parent!r} before it",
                where=where,
                remedy='name an earlier joint or "base" as parent, or leave it out: the joint before',
            )
        if spatial:
            _check_spatial(joint, where)
    if any(joint.motor for joint in joints):
        motors_of(joints)
    for k, parent in enumerate(parents(joints)):
        if parent is not None and joints[parent].length is None and not spatial:
            raise EffectError(
                f"the length of {names[parent]} is missing: {names[k]} hangs from its link",
                where=f"joint {parent + 1} ({names[parent]})",
                remedy=f'give the length in m from one joint to the other: Joint("{names[parent]}", length=0.4)',
            )


def motors_of(joints: Sequence[Joint]) -> Rows:
    """Turns of each joint's motor for each joint's angle (J, J), one to one where nothing is said;
    EffectError where that names other joints, or leaves angles open.
    """
    import numpy as np

    known, rows = names(joints), np.eye(len(joints))
    for k, joint in enumerate(joints):
        if not joint.motor:
            continue
        rows[k] = 0.0
        for other, ratio in joint.motor:
            if other not in known or not 0.0 < abs(ratio) <= FARTHEST:
                what = f"its motor turns {ratio!r} times as far as {str(other)[:40]!r}"
                raise EffectError(what, where=f"joint {k + 1} ({joint.name})",
                                  remedy=f"give numbers that are not zero, of {', '.join(known)}")  # fmt: skip
            rows[k, known.index(other)] = ratio
    length = np.linalg.norm(rows, axis=1)
    if np.linalg.matrix_rank(rows / length[:, None]) < len(joints):
        remedy = "each motor has to turn with its own joint"
        raise EffectError("the angles of the motors do not tell those of the joints", where="couplings", remedy=remedy)
    return tuple(tuple(float(value) for value in row) for row in rows)


def _check_spatial(joint: Joint, where: str) -> None:
    """Refuse a joint of a spatial machine that is one of a planar one."""
    if joint.axis is None:
        raise EffectError(
            f"{joint.name} says no axis, and other joints say an axis or an origin: the machine is spatial",
            where=where,
            remedy="give every joint its axis, such as [0, 0, 1], or none of them an axis or an origin",
        )
    if joint.length is not None:
        raise EffectError(
            f"{joint.name} has a length, and the machine is spatial",
            where=where,
            remedy="leave the length out: the origin of the next joint says where that sits",
        )


def parents(joints: Sequence[Joint]) -> tuple[int | None, ...]:
    """Return the index of the joint that carries each joint (J,), None for the base."""
    places = {joint.name: k for k, joint in enumerate(joints)}
    found: list[int | None] = []
    for k, joint in enumerate(joints):
        if joint.parent is None:
            found.append(k - 1 if k else None)
        else:
            found.append(places.get(joint.parent))
    return tuple(found)


def ancestors(joints: Sequence[Joint], index: int) -> tuple[int, ...]:
    """Return the joints from the base to joint `index`, itself included."""
    above, path = parents(joints), [index]
    while (parent := above[path[-1]]) is not None:
        path.append(parent)
    return tuple(reversed(path))
