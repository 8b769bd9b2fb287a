"""The leg as links, joints and gravity: data from which the equations of motion are derived.

A planar chain hangs from the hip. The angle of a link from the downward vertical is the sum of the joint
angles up to it (plus whatever its encoder is off by), so for thigh and shank φ1 = θ1 and φ2 = θ1 + θ2,
flexion negative:

        hip o                     x to the front, z upwards
             \\  thigh, a_th       centre of mass `along` the link from its upper joint,
              \\                   and `across` it, positive to the front of a hanging link
          knee o
               |  shank

Every quantity is a SymPy expression, so that an effect changes the mechanism by replacing one of them.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

from exoid.symbolic.joints import Joint, ancestors

if TYPE_CHECKING:
    from sympy import Expr, Symbol


@dataclass(frozen=True)
class Link:
    """A rigid link: `mass` kg, `inertia` about its centre of mass kg·m², `length` to the next joint m.

    The centre of mass lies `along` the link from its upper joint and `across` it, both in m.
    """

    name: str
    mass: Expr
    inertia: Expr
    length: Expr
    along: Expr
    across: Expr


@dataclass(frozen=True)
class Mechanism:
    """A planar chain of J links under gravity (m/s²).

    `tilt` rad turns gravity, `joint_offset` (J,) rad is what each encoder reads too little,
    `base_acceleration` (2,) m/s² is the acceleration of the hip to the front and upwards, `time` the symbol
    it may depend on, `leaning` rad the angle of a base that is measured. `joints` (J,) say
    who hangs from whom; `own` is the index of the joint of the effect that is asked to change the mechanism, of the
    last one for an effect on the whole machine.
    """

    links: tuple[Link, ...]
    gravity: Expr
    tilt: Expr
    joint_offset: tuple[Expr, ...]
    base_acceleration: tuple[Expr, Expr]
    time: Symbol
    joints: tuple[Joint, ...]
    own: int = 0
    leaning: Expr | int = 0

    @property
    def angle(self) -> tuple[Symbol, ...]:
        """Joint angles θ (J,), rad."""
        return self._state("theta")

    @property
    def velocity(self) -> tuple[Symbol, ...]:
        """Joint velocities θ' (J,), rad/s."""
        return self._state("dtheta")

    @property
    def acceleration(self) -> tuple[Symbol, ...]:
        """Joint accelerations θ'' (J,), rad/s²."""
        return self._state("ddtheta")

    @property
    def unknowns(self) -> tuple[Symbol, ...]:
        """Inertial quantities nobody has measured: inertia, mass and centre of mass of every link."""
        candidates = [quantity for link in self.links for quantity in (link.inertia, link.mass, link.along)]
        return tuple(quantity for quantity in candidates if quantity.is_Symbol)

    def with_link(self, name: str, **changes: Any) -> Mechanism:
        """Return the mechanism with fields of link `name` replaced; KeyError where there is no such link."""
        if name not in {link.name for link in self.links}:
            raise KeyError(f"no link {name!r}; the links are {[link.name for link in self.links]}")
        links = tuple(replace(link, **changes) if link.name == name else link for link in self.links)
        return replace(self, links=links)

    def link(self, name: str) -> Link:
        """Return the link called `name`; KeyError where there is none."""
        return {link.name: link for link in self.links}[name]

    def absolute_angle(self, index: int) -> Expr:
        """Angle of link `index` from the downward vertical, rad: the joint angles and offsets up to it."""
        turning = [k for k in ancestors(self.joints, index) if self.joints[k].turns]
        return sum((self.angle[k] + self.joint_offset[k] for k in turning), start=self.leaning + 0 * self.gravity)

    def point(self, index: int, along: Expr, across: Expr = 0) -> tuple[Expr, Expr]:
        """Position (x to the front, z upwards) in m of a point on link `index`, seen from the hip."""
        from sympy import cos, sin

        x = z = 0 * self.gravity
        for k in ancestors(self.joints, index):
            phi = self.absolute_angle(k)
            down, out = (along, across) if k == index else (self.links[k].length, 0)
            if not self.joints[k].turns:
                down += self.angle[k] + self.joint_offset[k]
            x += down * sin(phi) + out * cos(phi)
            z += -down * cos(phi) + out * sin(phi)
        return x, z

    def _state(self, stem: str) -> tuple[Symbol, ...]:
        return tuple(real(f"{stem}{k + 1}") for k in range(len(self.links)))


def real(name: str) -> Symbol:
    """Return the real SymPy symbol of that name: the one kind of symbol used for states, shapes and
    coefficients.
    """
    from sympy import Symbol

    return Symbol(name, real=True)


def positive(name: str) -> Symbol:
    """Return the positive SymPy symbol of that name: masses, inertias, lengths, gravity."""
    from sympy import Symbol

    return Symbol(name, positive=True)


def chain(*suffixes: str) -> Mechanism:
    """Return a plain chain with one link per suffix: m_, I_, a_ (length), l_ (along) followed by the
    suffix.
    """
    from sympy import Integer

    zero = Integer(0)
    names = {"th": "thigh", "sh": "shank"}
    links = tuple(
        Link(
            names.get(suffix, suffix),
            mass=positive(f"m_{suffix}"),
            inertia=positive(f"I_{suffix}"),
            length=positive(f"a_{suffix}"),
            along=positive(f"l_{suffix}"),
            across=zero,
        )
        for suffix in suffixes
    )
    joints = tuple(Joint(suffix) for suffix in suffixes)
    return Mechanism(links, positive("g"), zero, (zero,) * len(links), (zero, zero), real("t"), joints)


def machine(joints: tuple[Joint, ...]) -> Mechanism:
    """Return the mechanism of a machine that is not the leg: lengths (m) are numbers, links named as the joints."""
    from sympy import Float, Integer

    plain = chain(*(joint.name for joint in joints))
    links = tuple(
        replace(link, length=Integer(0) if joint.length is None else Float(joint.length))
        for link, joint in zip(plain.links, joints, strict=True)
    )
    return replace(plain, links=links, joints=joints)


def leg() -> Mechanism:
    """Return the leg of the paper: thigh and shank, centres of mass on the link axes, a still and level
    base.
    """
    return chain("th", "sh")
