"""A measured external force that acts on the machine: on which link, where along it, and in which columns it is logged.

What the drives need not supply any more is Jᵀ F by virtual work, so that the torque of a force is -Jᵀ F:

    τ = ... - (a(q) + at · b(q)) · gain · F

`a` is what the force does at its link's upper joint, `b` what it does for each metre along the link. Where place and
gain are known this is a known torque without any number; one that is left out is a number of the model.

Of a machine in space it is a force (3,), or a wrench (6,) of a force and a moment, at a known point of a link.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType

from exoid.ground.errors import EffectError
from exoid.symbolic.joints import Joint, Origin, Vector, ancestors, is_leg, is_spatial, three_numbers
from exoid.symbolic.term import Parameter

NORMAL, WORLD, VERTICAL, TORQUE = "normal", "world", "vertical", "torque"
LINK, FIXED = "link", "base"
FRAMES: Mapping[str, tuple[int, ...]] = MappingProxyType(
    {NORMAL: (1,), WORLD: (2,), VERTICAL: (1,), TORQUE: (1,), LINK: (3, 6), FIXED: (3, 6)}
)
"""How the columns of a force are meant, and how many they are: normal to the link, positive to the front of a hanging
one; forwards and upwards; upwards alone; a torque about the joint, with the sign of its angle. In space the parts of a
force, and of a moment, along the axes of a sensor on the link, or of the base."""
IN_SPACE = (LINK, FIXED, TORQUE)
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
    recording: N, or N·m for a torque about the joint. In space `at` (3,) m is a point in the frame of that joint, its
    origin where left out, and `rpy` (3,) rad how the sensor's axes are turned in that frame.

    `frame` is one of `FRAMES`, `sign` -1 where the columns are those of the machine's force on what pushes it. `at`
    and `gain` are identified where they are None; `delay` is how many s later than the torque the columns were logged.
    EffectError for a number that cannot be.
    """

    name: str
    link: str
    columns: tuple[str, ...]
    at: float | Vector | None = None
    frame: str = ""
    gain: float | None = 1.0
    delay: float = 0.0
    sign: int = 1
    rpy: Vector = (0.0, 0.0, 0.0)

    def __post_init__(self) -> None:
        if not self.frame:
            object.__setattr__(self, "frame", {2: WORLD, 3: LINK, 6: LINK}.get(len(self.columns), NORMAL))
        if not NAME.fullmatch(self.name):
            raise EffectError(
                f"{self.name[:40]!r} is not a force's name",
                where="forces",
                remedy="use a letter first, then letters (a to z), digits, blanks, - and _, 40 characters at most",
            )
        if self.frame not in FRAMES:
            raise EffectError(f"unknown frame {self.frame!r}", where=self.name, remedy=f"use {', '.join(FRAMES)}")
        if len(self.columns) not in FRAMES[self.frame]:
            what = f"{len(self.columns)} columns for the frame {self.frame!r}"
            counts = " or ".join(map(str, FRAMES[self.frame]))
            meant = "a force, and a moment" if self.in_space else "one is normal to the link, two forwards and upwards"
            raise EffectError(what, where=self.name, remedy=f"give {counts}: {meant}")
        if isinstance(self.at, (list, tuple)):
            object.__setattr__(self, "at", three_numbers(self.at, "at"))
        object.__setattr__(self, "rpy", three_numbers(self.rpy, "rpy"))
        parts = () if self.at is None else self.at if isinstance(self.at, tuple) else (self.at,)
        if not all(abs(part) <= FARTHEST for part in parts):
            remedy = f"give m from the link's upper joint, at most {FARTHEST:g}, or leave it out"
            raise EffectError(f"at is {self.at!r}", where=self.name, remedy=remedy)
        if self.gain is not None and not (math.isfinite(self.gain) and self.gain >= LEAST_GAIN):
            remedy = "give a positive number; sign = -1 turns the force round"
            raise EffectError(f"gain is {self.gain!r}", where=self.name, remedy=remedy)
        if self.sign not in (1, -1):
            raise EffectError(f"sign is {self.sign!r}", where=self.name, remedy="give 1 or -1")
        if not (math.isfinite(self.delay) and abs(self.delay) <= SLOWEST):
            raise EffectError(f"delay is {self.delay!r}", where=self.name, remedy=f"give s, at most {SLOWEST:g}")

    @property
    def in_space(self) -> bool:
        """True if it is a force or a wrench in space."""
        return self.frame in (LINK, FIXED)

    @property
    def along(self) -> float:
        """The place along its link at which it acts, m; 0 where that is not known, and of one in space, which is
        `placed`.
        """
        return 0.0 if isinstance(self.at, tuple) else self.at or 0.0

    @property
    def placed(self) -> Origin:
        """Place of its sensor in space: its place and its turn in the frame of its link's joint."""
        return Origin(self.at if isinstance(self.at, tuple) else (0.0, 0.0, 0.0), self.rpy)

    def index(self, joints: Sequence[Joint]) -> int:
        """Index of the link it acts on; EffectError where that has no such link."""
        names = [joint.name for joint in joints]
        link = LEG_LINKS.get(self.link, self.link) if is_leg(joints) else self.link
        if link not in names:
            remedy = f"name the joint that the link follows: {' or '.join(names)}"
            raise EffectError(f"there is no link {self.link!r}", where=self.name, remedy=remedy)
        return names.index(link)

    def reaches(self, joints: Sequence[Joint]) -> tuple[bool, bool]:
        """Flags that it does anything at its link's upper joint, and whether more the farther along the link.

        EffectError where it does neither: a force across the way of a machine that only slides.
        """
        index = self.index(joints)
        path = ancestors(joints, index)
        self._check_place(joints)
        if self.frame == TORQUE or self.in_space:
            return True, False
        slides = not joints[index].turns
        carried = len(path) > 1 or (slides and self.frame != NORMAL)
        along = any(joints[k].turns for k in path)
        if not (carried or along):
            remedy = 'leave it out, or give its parts forwards and upwards: frame = "world"'
            raise EffectError("a force across a link that only slides does no work", where=self.name, remedy=remedy)
        return carried, along

    def _check_place(self, joints: Sequence[Joint]) -> None:
        """Refuse a place or a frame in a plane for a machine in space, and the other way round."""
        spatial = is_spatial(joints)
        if spatial != (self.frame in IN_SPACE) and self.frame != TORQUE:
            frames = ", ".join(IN_SPACE if spatial else (name for name in FRAMES if name not in (LINK, FIXED)))
            meant = "three are a force, six a force and a moment" if spatial else "one is normal to the link"
            here = "a plane" if spatial else "space"
            raise EffectError(
                f"{len(self.columns)} columns in the frame {self.frame!r} are a force in {here}, the machine is not",
                where=self.name,
                remedy=f"use {frames}; of columns {meant}",
            )
        if self.at is not None and isinstance(self.at, tuple) != self.in_space:
            wanted = "three numbers, m in the frame of the link's joint" if self.in_space else "one number, m"
            raise EffectError(f"at is {self.at!r}", where=self.name, remedy=f"give {wanted}, or leave it out")

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
        """True if a part of its torque needs no number."""
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
