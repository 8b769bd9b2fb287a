"""A known mass that hangs on the leg: what it adds to the base parameters, derived like everything else.

A recording with a known mass and one without differ by a torque that is known in N·m. That gives the torques of all
recordings a scale which no motion of the bare leg gives: it distinguishes the gains of the two drives (Gautier, Briot,
ASME Journal of Dynamic Systems, Measurement, and Control 136(5), 2014).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exoid.ground.errors import ExoidError
from exoid.symbolic.joints import JOINT_NAME, Vector
from exoid.symbolic.mechanics.spatial import about_joint
from exoid.symbolic.model_structure import ModelStructure
from exoid.symbolic.motion import Float, read_only

LINKS = ("thigh", "shank")
HEAVIEST, FARTHEST = 200.0, 3.0
"""kg and m beyond which a payload is taken for a mistake in the units."""


class PayloadError(ExoidError):
    """A payload that cannot be: its mass, its place or its link."""


@dataclass(frozen=True)
class Payload:
    """A small body of `mass` kg on the axis of `link`, `along` m from that link's upper joint; of a spatial machine at
    `along` (3,) m in the frame of that joint.

    The links of the leg are its thigh and shank, those of another machine have the names of their joints, and "shank"
    means the last of them. PayloadError where the mass is not positive, or a number is not finite or far from any leg.
    """

    mass: float
    along: float | Vector
    link: str = "shank"

    def __post_init__(self) -> None:
        if not JOINT_NAME.fullmatch(self.link):
            raise self._no_link("thigh or shank")
        if not (math.isfinite(self.mass) and 0.0 < self.mass <= HEAVIEST):
            raise PayloadError(
                f"a payload of {self.mass:g} kg", where=str(self), remedy=f"give kg, more than 0, at most {HEAVIEST:g}"
            )
        if isinstance(self.along, (list, tuple)):
            object.__setattr__(self, "along", tuple(float(value) for value in self.along))
        if len(self._place) not in (1, 3) or not all(abs(value) <= FARTHEST for value in self._place):
            raise PayloadError(
                f"a payload {self.place} m down the {self.link}",
                where=str(self),
                remedy=f"give m from the link's upper joint, at most {FARTHEST:g}: one number, in space three",
            )

    def __str__(self) -> str:
        return f"{self.link}:{self.mass:g}@{self.place}"

    @property
    def place(self) -> str:
        """Place as the command line takes it: "0.35", or "0,0,0.05" in space."""
        return ",".join(f"{value:g}" for value in self._place)

    @property
    def _place(self) -> tuple[float, ...]:
        return self.along if isinstance(self.along, tuple) else (self.along,)

    def numbers(self, thigh_length: float) -> Float:
        """Addition to Φ1..Φ4 (4,), kg·m², of a leg whose thigh is `thigh_length` m long."""
        return self.added(ModelStructure.standard(thigh_length))

    def added(self, model: ModelStructure) -> Float:
        """Addition to the base parameters (P,) of a model's machine; PayloadError where that has no such
        link, or other coordinates.
        """
        if model.spatial != (len(self._place) == 3):
            what, remedy = "on the axis of a link", "give one number, m along the link from its joint"
            if model.spatial:
                what, remedy = "in the frame of a joint", "give three numbers, m along its x, y and z: 2@0,0,0.05"
            raise PayloadError(f"a mass of this machine is somewhere {what}", where=str(self), remedy=remedy)
        names = model.joint_names if model.chain else LINKS
        if self.link not in (*names, "shank"):
            raise self._no_link(" or ".join(names))
        index = names.index(self.link) if self.link in names else len(names) - 1
        return read_only(model.mixture[:, index] @ (self.mass * one_kg_at(self._place)))

    def _no_link(self, links: str) -> PayloadError:
        return PayloadError(f"there is no link {self.link!r}", where=str(self), remedy=links)


def one_kg_at(place: Sequence[float]) -> Float:
    """Inertia, first moment and mass of 1 kg at a `place` on the axis of a link about its upper joint, (3,), or its ten
    numbers in space.
    """
    if len(place) == 1:
        return np.array([place[0] ** 2, place[0], 1.0])
    return np.array([*about_joint(1.0, place, np.zeros((3, 3))).values()])
