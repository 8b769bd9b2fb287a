"""The joints of a planar machine as data: names, kinds, lengths, and who hangs from whom.

A chain by default, a tree with `parent`. Angles are as in the leg: the first link's from the downward vertical, each
further one's relative to its parent link. A prismatic joint slides its link along the link's own axis.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from exoid.ground.errors import EffectError

KINDS = ("revolute", "prismatic")
BASE = "base"
"""Name of what does not move, as a joint's `parent`."""
MOST = 12
"""Joints of one machine."""
JOINT_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]{0,39}")
TAKEN = frozenset((BASE, "both", "next", "t"))
UNITS = {"q": ("rad", "m"), "dq": ("rad/s", "m/s"), "ddq": ("rad/s²", "m/s²"), "tau": ("N·m", "N"), "f": ("N", "N")}
LEVER = 0.1
"""m that a sliding joint moves where a turning one moves 1 rad, in thresholds written for angles: a drum of this
radius."""
SLIDING = (("kg·m²", "kg"), ("(N·m)", "N"), ("N·m", "N"), ("rad", "m"))
"""Units of a turning joint, and what they are where it slides."""


@dataclass(frozen=True)
class Joint:
    """A joint and its link: `length` in m from the joint to where the next one sits (None: nothing hangs there).

    `parent` is the joint whose link carries this one, "base" for the base, None for the joint before.
    """

    name: str
    kind: str = "revolute"
    length: float | None = None
    parent: str | None = None

    @property
    def turns(self) -> bool:
        """Whether it is revolute (rad, N·m); a prismatic joint has m and N."""
        return self.kind == "revolute"

    @property
    def reach(self) -> float:
        """What of its own unit counts as 1 rad in thresholds written for angles."""
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


def is_leg(joints: Sequence[Joint]) -> bool:
    """Whether these are hip and knee of a leg, whatever the length of its thigh."""
    return names(joints) == names(LEG) and all(joint.turns for joint in joints) and parents(joints) == (None, 0)


def check_joints(joints: Sequence[Joint]) -> None:
    """Refuse joints that make no machine: EffectError with the joint."""
    if not 1 <= len(joints) <= MOST:
        raise EffectError(f"{len(joints)} joints", where="joints", remedy=f"give 1 to {MOST}")
    names = [joint.name for joint in joints]
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
        if joint.length is not None and not (math.isfinite(joint.length) and joint.length >= 0.0):
            raise EffectError(f"length is {joint.length!r}", where=where, remedy="give 0 or more (m)")
        if joint.parent is not None and joint.parent != BASE and joint.parent not in names[:k]:
            raise EffectError(
                f"there is no joint {joint.parent!r} before it",
                where=where,
                remedy='name an earlier joint or "base" as parent, or leave it out: the joint before',
            )
    for k, parent in enumerate(parents(joints)):
        if parent is not None and joints[parent].length is None:
            raise EffectError(
                f"the length of {names[parent]} is missing: {names[k]} hangs from its link",
                where=f"joint {parent + 1} ({names[parent]})",
                remedy=f'give the length in m from one joint to the other: Joint("{names[parent]}", length=0.4)',
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
