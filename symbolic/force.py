"""A measured external force that acts on the machine: on which link, where along it, and in which columns it is logged.

What the drives need not supply any more is Jᵀ F by virtual work, so that the torque of a force is -Jᵀ F:

    τ = ... - (a(q) + at · b(q)) · gain · F

`a` is what the force does at its link's upper joint, `b` what it does for each metre along the link. Where place and
gain are known this is a known torque without any number; one that is left out is a number of the model.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

from exoid.ground.errors import EffectError
from exoid.symbolic.joints import Joint, ancestors, is_leg
from exoid.symbolic.term import Parameter

NORMAL, WORLD, VERTICAL, TORQUE = "normal", "world", "vertical", "torque"
FRAMES = {NORMAL: 1, WORLD: 2, VERTICAL: 1, TORQUE: 1}
"""How the columns of a force are meant, and how many they are: normal to the link, positive to the front of a hanging
one; forwards and upwards; upwards alone; a torque about the joint, with the sign of its angle."""
LEG_LINKS = {"thigh": "hip", "shank": "knee"}
"""Other names for the links of a leg."""
FARTHEST = 3.0
"""m along a link beyond which a place is taken for a mistake in the units."""
SLOWEST = 0.5
"""s of delay beyond which a number is taken for a mistake in the units."""
NAME = re.compile(r"[A-Za-z][A-Za-z0-9_ -]{0,39}", re.ASCII)
LEAST_GAIN = 1e-6
"""Gains nearer to 0 are taken for none."""


@dataclass(frozen=True)
class Force:
    """A force on `link` (the name of the joint it follows), `at` m along it from that joint, in `columns` of a
    recording: N, or N·m for a torque about the joint.

    `frame` is one of `FRAMES`, `sign` -1 where the columns are those of the machine's force on what pushes it. `at`
    and `gain` are identified where they are None; `delay` is how many s later than the torque the columns were logged.
    EffectError for a number that cannot be.
    """

    name: str
    link: str
    columns: tuple[str, ...]
    at: float | None = None
    frame: str = ""
    gain: float | None = 1.0
    delay: float = 0.0
    sign: int = 1

    def __post_init__(self) -> None:
        if not self.frame:
            object.__setattr__(self, "frame", WORLD if len(self.columns) == 2 else NORMAL)
        if not NAME.fullmatch(self.name):
            raise EffectError(
                f"{self.name[:40]!r} is not a force's name",
                where="forces",
                remedy="use a letter first, then letters (a to z), digits, blanks, - and _, 40 characters at most",
            )
        if self.frame not in FRAMES:
            raise EffectError(f"unknown frame {self.frame!r}", where=self.name, remedy=f"use {', '.join(FRAMES)}")
        if len(self.columns) != FRAMES[self.frame]:
            what = f"{len(self.columns)} columns for the frame {self.frame!r}"
            remedy = f"give {FRAMES[self.frame]}: one is normal to the link, two are forwards and upwards"
            raise EffectError(what, where=self.name, remedy=remedy)
        if self.at is not None and not (math.isfinite(self.at) and abs(self.at) <= FARTHEST):
            remedy = f"give m from the link's upper joint, at most {FARTHEST:g}, or leave it out"
            raise EffectError(f"at is {self.at!r}", where=self.name, remedy=remedy)
        if self.gain is not None and not (math.isfinite(self.gain) and self.gain >= LEAST_GAIN):
            remedy = "give a positive number; sign = -1 turns the force round"
            raise EffectError(f"gain is {self.gain!r}", where=self.name, remedy=remedy)
        if self.sign not in (1, -1):
            raise EffectError(f"sign is {self.sign!r}", where=self.name, remedy="give 1 or -1")
        if not (math.isfinite(self.delay) and abs(self.delay) <= SLOWEST):
            raise EffectError(f"delay is {self.delay!r}", where=self.name, remedy=f"give s, at most {SLOWEST:g}")

    def index(self, joints: Sequence[Joint]) -> int:
        """Return which link of a machine it acts on; EffectError where that has no such link."""
        names = [joint.name for joint in joints]
        link = LEG_LINKS.get(self.link, self.link) if is_leg(joints) else self.link
        if link not in names:
            remedy = f"name the joint that the link follows: {' or '.join(names)}"
            raise EffectError(f"there is no link {self.link!r}", where=self.name, remedy=remedy)
        return names.index(link)

    def reaches(self, joints: Sequence[Joint]) -> tuple[bool, bool]:
        """Return whether it does anything at its link's upper joint, and whether more the farther along the link.

        EffectError where it does neither: a force across the way of a machine that only slides.
        """
        index = self.index(joints)
        path = ancestors(joints, index)
        if self.frame == TORQUE:
            return True, False
        slides = not joints[index].turns
        carried = len(path) > 1 or (slides and self.frame != NORMAL)
        along = any(joints[k].turns for k in path)
        if not (carried or along):
            remedy = 'leave it out, or give its parts forwards and upwards: frame = "world"'
            raise EffectError("a force across a link that only slides does no work", where=self.name, remedy=remedy)
        return carried, along

    def parameters(self, joints: Sequence[Joint]) -> tuple[Parameter, ...]:
        """Return its numbers that are identified: "at" in m, "gain", or "gain_at", the product of both."""
        carried, along = self.reaches(joints)
        moves = along and self.at is None
        reach = joints[self.index(joints)].length
        if self.gain is not None:
            if not moves:
                return ()
            label = f"place of {self.name}: m along the link after the {self.link}"
            return (Parameter(f"{self.name}.at", label, "m", 0.0, reach or FARTHEST, None, 0.25),)
        found = []
        if carried or not moves:
            found.append(Parameter(f"{self.name}.gain", f"gain of {self.name}", "1", 0.0, None, None, 1.0))
        if moves:
            label = f"gain times place of {self.name}"
            found.append(Parameter(f"{self.name}.gain_at", label, "m", 0.0, None, None, 0.25))
        return tuple(found)

    def known(self, joints: Sequence[Joint]) -> bool:
        """Whether a part of its torque needs no number."""
        carried, _ = self.reaches(joints)
        return self.gain is not None and (carried or self.at is not None)


def check_forces(forces: Sequence[Force], joints: Sequence[Joint], taken: Sequence[str]) -> None:
    """Refuse forces of which two have one name or one column, or that a machine with `joints` cannot have: EffectError.

    `taken` are names of the model's terms.
    """
    names: list[str] = []
    columns: dict[str, str] = {}
    for force in forces:
        force.reaches(joints)
        if force.name in (*names, *taken):
            raise EffectError(f"there are two called {force.name!r}", where="forces", remedy="rename one")
        for column in force.columns:
            if column in columns:
                what = f"the column {column} is that of {columns[column]} already"
                raise EffectError(what, where=force.name, remedy="give every force columns of its own")
            columns[column] = force.name
        names.append(force.name)


def channels_of(forces: Sequence[Force]) -> tuple[str, ...]:
    """Return the columns (C,) of all forces, in the order in which a motion has them."""
    return tuple(column for force in forces for column in force.columns)
