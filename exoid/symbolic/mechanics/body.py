"""The limb of a person who wears the machine: masses, centres and inertias of its segments, from mass and height.

It is a known load: the numbers that are identified are those of the machine alone. How far a person differs from the
table is a part of their intervals.

Source of the table: Winter, Biomechanics and Motor Control of Human Movement, 4th ed., Wiley 2009, table 4.1 (after
Dempster) and figure 4.1 (lengths, after Drillis and Contini). Source of how far persons differ from such tables:
Durkin, Dowling, Analysis of body segment parameter differences between four human populations and the estimation
errors of four popular mathematical models, Journal of Biomechanical Engineering 125(4), 515-522, 2003.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Protocol

import numpy as np

from exoid.ground.errors import ExoidError
from exoid.symbolic.joints import Joint, parents
from exoid.symbolic.motion import Float

TABLE = "Winter 2009, table 4.1"
"""What is said of where the numbers come from."""
MASSES, HEIGHTS = (10.0, 300.0), (0.8, 2.5)
"""kg and m of a person; beyond them it is another unit."""
SPREAD = (0.10, 0.05, 0.10)
"""Standard deviation of persons from the table: of mass, place of the centre, and radius of gyration, as shares."""
REMEDY = "write mass=70,height=1.78 (kg, m)"


class Linked(Protocol):
    """The part of a model that a limb is put on: its joints, and base parameters (P, J, 3) of inertia, first moment and
    mass of every link.
    """

    @property
    def joints(self) -> tuple[Joint, ...]: ...  # noqa: D102
    @property
    def mixture(self) -> Float: ...  # noqa: D102


class BodyError(ExoidError):
    """A person who cannot be, or a machine that has no link for a leg."""


@dataclass(frozen=True)
class Share:
    """A segment as the table has it: `mass` over that of the body, `length` over the height, and over the length where
    its centre of mass lies, `centre`, and its radius of `gyration` about that.
    """

    mass: float
    length: float
    centre: float
    gyration: float


SEGMENTS: Mapping[str, Share] = MappingProxyType({
    "hip": Share(0.100, 0.245, 0.433, 0.323),
    "knee": Share(0.0465, 0.246, 0.433, 0.302),
    "ankle": Share(0.0145, 0.152, 0.50, 0.475),
})  # fmt: skip
"""What hangs from a joint: thigh, shank, and foot, from the ankle to its toes."""
SHANK_AND_FOOT = Share(0.061, 0.246, 0.606, 0.416)
"""What hangs from the knee of a machine without an ankle."""


@dataclass(frozen=True)
class Body:
    """A person of `mass` kg and `height` m in the machine, whose joints and its own are in the same places.

    BodyError for numbers that are no person's.
    """

    mass: float
    height: float

    def __post_init__(self) -> None:
        for name, unit, value, (low, high) in (
            ("mass", "kg", self.mass, MASSES),
            ("height", "m", self.height, HEIGHTS),
        ):
            if not (math.isfinite(value) and low <= value <= high):
                what = f"a wearer whose {name} is {value:g} {unit}"
                raise BodyError(what, remedy=f"give {low:g} to {high:g} {unit}: {REMEDY}")

    def __str__(self) -> str:
        return f"mass={self.mass:g},height={self.height:g}"

    @classmethod
    def named(cls, text: str) -> Body:
        """Return the person that a text such as "mass=70,height=1.78" means; BodyError where it means none."""
        found: dict[str, float] = {}
        for part in text.split(","):
            name, _, value = part.partition("=")
            try:
                found[name.strip()] = float(value)
            except ValueError:
                found.clear()
                break
        if found.keys() != {"mass", "height"}:
            raise BodyError(f"{text[:60]!r} is no wearer", remedy=REMEDY)
        return cls(found["mass"], found["height"])

    def check(self, joints: Sequence[Joint]) -> None:
        """Refuse a machine that has no joint of a leg: BodyError."""
        self._limb(joints)

    def added(self, model: Linked) -> Float:
        """Addition of the limb to the base parameters (P,) of a model's machine; BodyError where that has no joint
        of a leg.
        """
        total = np.zeros(len(model.mixture))
        for link, segment in self._limb(model.joints).items():
            total += model.mixture[:, link] @ self._inertial(segment)
        return total

    def deviation(self, model: Linked) -> Float:
        """Return the standard deviation of `added` (P,): how far persons of this mass and height differ."""
        square = np.zeros(len(model.mixture))
        for link, segment in self._limb(model.joints).items():
            plain = self._inertial(segment)
            for factors in np.eye(3) * SPREAD:
                mass, centre, gyration = 1.0 + factors
                other = Share(
                    segment.mass * mass, segment.length, segment.centre * centre, segment.gyration * gyration
                )
                square += (model.mixture[:, link] @ (self._inertial(other) - plain)) ** 2
        return np.asarray(np.sqrt(square))

    def _limb(self, joints: Sequence[Joint]) -> dict[int, Share]:
        """Return the segment on each link that has one."""
        called = [next((name for name in SEGMENTS if name in _words(joint.name)), "") for joint in joints]
        ends = {above for above, name in zip(parents(joints), called, strict=True) if name == "ankle"}
        limb = {
            k: SHANK_AND_FOOT if name == "knee" and k not in ends else SEGMENTS[name]
            for k, name in enumerate(called)
            if name and joints[k].turns
        }
        if not limb:
            remedy = f"no joint of it is called {', '.join(SEGMENTS)}: name them so, or leave the wearer out"
            raise BodyError("the machine has no link for the limb of a wearer", remedy=remedy)
        return limb

    def _inertial(self, segment: Share) -> Float:
        """Return inertia about the upper joint kg·m², first moment kg·m and mass kg (3,) of a segment."""
        mass, length = segment.mass * self.mass, segment.length * self.height
        along = segment.centre * length
        return mass * np.array([along**2 + (segment.gyration * length) ** 2, along, 1.0])


def _words(name: str) -> list[str]:
    return re.split(r"[_\d]+", name.lower())
