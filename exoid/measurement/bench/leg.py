"""Legs for the virtual bench: masses, lengths and friction of an exoskeleton leg with its wearer.

A leg is, for the mechanics, eight numbers (Φ1..Φ4 in kg·m², then Coulomb N·m and viscous N·m·s/rad friction
of hip and knee); the masses behind them are kept when they are known. Formulas: `Φ1 = I_th + I_sh + m_th
l_th² + m_sh (a_th² + l_sh²)`, `Φ2 = I_sh + m_sh l_sh²`, `Φ3 = m_sh a_th l_sh`, `Φ4 = m_th a_th l_th - I_th -
m_th l_th²`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from exoid.ground.errors import ExoidError
from exoid.symbolic.joints import Vector
from exoid.symbolic.mechanics.payload import Payload

KNEE = -0.925
"""rad: the knee in the middle of its range."""


class LegError(ExoidError):
    """A leg that cannot exist: a mass, length, inertia or friction that is negative or not finite."""


@dataclass(frozen=True)
class Segment:
    """Thigh or shank with what is strapped to it: `mass` kg, `com` m from its joint, `inertia` kg·m² about
    the COM.
    """

    mass: float
    com: float
    inertia: float


@dataclass(frozen=True)
class Leg:
    """The leg of the bench, by its parameters.

    `base` is (Φ1, Φ2, Φ3, Φ4, Coulomb hip, viscous hip, Coulomb knee, viscous knee), the order of the
    standard model's linear parameters. `torque_limit` (hip, knee) in N·m is where the motors saturate.
    `thigh` and `shank` are None for a leg of which only the lumped numbers are known.
    """

    name: str
    base: tuple[float, ...]
    torque_limit: tuple[float, float]
    thigh_length: float = 0.40
    thigh: Segment | None = None
    shank: Segment | None = None

    def __post_init__(self) -> None:
        if len(self.base) != 8 or not all(math.isfinite(value) for value in self.base):
            raise LegError(f"a leg needs eight finite base parameters, not {self.base!r}", where=self.name)
        if self.thigh_length <= 0 or min(self.torque_limit) <= 0:
            raise LegError("thigh length and torque limits must be positive", where=self.name)
        phi1, phi2, phi3 = self.base[:3]
        # M must be positive definite in every pose; its determinant is smallest at cos θ2 = ±1.
        if min(phi1, phi2, phi1 * phi2 - phi2**2 - phi3**2) <= 0:
            what = f"Φ1 = {phi1:g}, Φ2 = {phi2:g}, Φ3 = {phi3:g} kg·m² make a mass matrix that is not positive definite"
            remedy = "no real leg has such inertias: check the numbers, Φ1 > Φ2 > 0 and Φ2 (Φ1 - Φ2) > Φ3²"
            raise LegError(what, where=self.name, remedy=remedy)

    @classmethod
    def of(cls, name: str, thigh: Segment, shank: Segment, friction: tuple[float, float, float, float]) -> Leg:
        """Build a leg from its two segments; `friction` is (Coulomb, viscous) of the hip, then of the knee.

        Raises LegError when a mass or inertia is not positive or a friction is negative.
        """
        numbers = (thigh.mass, thigh.inertia, shank.mass, shank.inertia)
        if not all(number > 0 for number in numbers) or min(friction) < 0:
            what = "masses and inertias must be positive, friction must not be negative"
            raise LegError(what, where=name, remedy="give kg, m, kg·m², N·m and N·m·s/rad")
        about_hip = thigh.inertia + thigh.mass * thigh.com**2
        about_knee = shank.inertia + shank.mass * shank.com**2
        lumped = (
            about_hip + about_knee + shank.mass * cls.thigh_length**2,
            about_knee,
            shank.mass * cls.thigh_length * shank.com,
            thigh.mass * cls.thigh_length * thigh.com - about_hip,
        )
        return cls(name, (*lumped, *friction), (150.0, 100.0), thigh=thigh, shank=shank)

    def with_payload(self, mass: float, along: float | Vector, link: str = "shank") -> Leg:
        """Return the leg with a `mass` kg on the axis of `link`, `along` m from its upper joint; what is fastened to it
        can no longer be distinguished from the segments.
        """
        rigid = np.add(self.base[:4], Payload(mass, along, link).numbers(self.thigh_length))
        return replace(self, base=(*rigid.tolist(), *self.base[4:]), thigh=None, shank=None)

    @property
    def inertia(self) -> tuple[float, ...]:
        """The inertia that each drive feels, kg·m² (J,), with the knee in the middle of its range."""
        return tuple(np.diag(self.mass_matrix(KNEE)).tolist())

    @property
    def sensor_scale(self) -> tuple[float, ...]:
        """Noise of each torque sensor over that of a strong drive's (J,)."""
        return 1.0, 1.0

    def mass_matrix(self, knee: float) -> np.ndarray:
        """Return M (2, 2) in kg·m² at knee angle `knee` in rad, of the leg without any effect."""
        phi1, phi2, phi3 = self.base[:3]
        off = phi2 + phi3 * math.cos(knee)
        return np.array([[phi1 + 2.0 * phi3 * math.cos(knee), off], [off, phi2]])


def standard_leg() -> Leg:
    """Return the bench's standard leg: an adult's leg (Winter's segment shares at 65 kg) in a 5 kg
    exoskeleton.

    Thigh 6.5 kg and shank with foot 4.0 kg of the wearer, 3.0 kg of frame and knee drive on the thigh and 2.0
    kg on the shank. Friction is that of a geared joint drive: dry 4.0 and 3.0 N·m, viscous 2.0 and 1.2
    N·m·s/rad.
    """
    thigh = Segment(mass=9.5, com=0.18, inertia=0.14)
    shank = Segment(mass=6.0, com=0.22, inertia=0.11)
    return Leg.of("standard leg", thigh, shank, (4.0, 2.0, 3.0, 1.2))


def paper_leg() -> Leg:
    """Return the leg that the paper identified: its Φ_Huber. The masses behind it are not published."""
    base = (25.14, 7.42, 1.43, -10.42, 31.35, 12.53, 43.40, 28.01)
    return Leg("the paper's leg", base, torque_limit=(500.0, 350.0))


def random_leg(rng: np.random.Generator) -> Leg:
    """Draw a leg: the standard one with every mass, length and friction varied by about ±30 %.

    The thigh length stays 0.40 m, because a model takes it as known.
    """

    def vary(value: float, spread: float) -> float:
        return value * float(rng.uniform(1.0 - spread, 1.0 + spread))

    plain = standard_leg()
    assert plain.thigh is not None and plain.shank is not None
    thigh, shank = (
        Segment(vary(part.mass, 0.3), vary(part.com, 0.12), vary(part.inertia, 0.3))
        for part in (plain.thigh, plain.shank)
    )
    hip_dry, hip_viscous, knee_dry, knee_viscous = (vary(value, 0.45) for value in plain.base[4:])
    return Leg.of("random leg", thigh, shank, (hip_dry, hip_viscous, knee_dry, knee_viscous))
