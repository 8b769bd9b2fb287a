"""The structure of a model: geometry, limits, and the physical effects it knows of.

    τ = Σ_p columns_p(motion; shape) · linear_p

with Φ1..Φ4 of the rigid leg first, Coulomb and viscous friction of hip and knee next, then where measured forces act,
as far as that is not known, then the numbers of each term. A structure is a value: `with_effect` and `without` return
another one. `exoid.symbolic.model.Model` is a structure that computes its torque, and has files; what derives, compiles
and evaluates equations takes structures, and stands between the two.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from exoid.ground.errors import EffectError
from exoid.ground.html import lines, table
from exoid.symbolic.effect import Effect
from exoid.symbolic.effect_catalogue import find_effect
from exoid.symbolic.force import Force, channels_of, check_forces
from exoid.symbolic.joints import (
    HEAVIEST,
    LEG,
    LIGHTEST,
    LONGEST,
    SHORTEST,
    Joint,
    Vector,
    check_joints,
    is_spatial,
    names,
    three_numbers,
    units,
)
from exoid.symbolic.language.torque import check_units
from exoid.symbolic.mechanics.body import Body
from exoid.symbolic.mechanics.friction import friction_parameters
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import JOINTS
from exoid.symbolic.term import Parameter, ShapeParameter, Term, places_of

if TYPE_CHECKING:
    from exoid.symbolic.mechanics.mechanism import Mechanism

STANDARD_GRAVITY = 9.81
"""m/s² where nobody says another."""
INERTIAL = ("Phi1", "Phi2", "Phi3", "Phi4")
"""Base parameters of the rigid leg, kg·m²; what they are made of is derived in regressor.py."""


@dataclass(frozen=True)
class Limits:
    """Limits of a joint: `angle` (low, high) rad, |velocity| rad/s, |acceleration| rad/s²."""

    angle: tuple[float, float]
    velocity: float
    acceleration: float

    def filled(self, usual: Limits) -> Limits:
        """Return the limits with `usual` ones where there are none."""
        angle = self.angle if all(map(math.isfinite, self.angle)) else usual.angle
        velocity = self.velocity if math.isfinite(self.velocity) else usual.velocity
        return Limits(angle, velocity, self.acceleration if math.isfinite(self.acceleration) else usual.acceleration)


TABLE_1: Mapping[str, Limits] = MappingProxyType(
    {"hip": Limits((-0.13, 1.26), 1.92, 5.16), "knee": Limits((-1.62, -0.23), 1.64, 5.16)}
)
"""Table 1 of the paper."""
UNLIMITED = Limits((-math.inf, math.inf), math.inf, math.inf)
USUAL: Mapping[bool, Limits] = MappingProxyType(
    {True: Limits((-1.0, 1.0), 2.0, 6.0), False: Limits((-0.15, 0.15), 0.3, 1.0)}
)
"""Limits of motions that are drawn for a joint whose model has none: where it turns, and where it slides (m)."""


@dataclass(frozen=True, eq=False)
class ModelStructure:
    """A leg with thigh length m, gravity m/s², the limits of its joints, and its terms beyond rigid body
    and friction.

    `joints` (J,) make another machine of it, in the order of every axis of length J: Joints, or the names of ones that
    turn. `terms` may be named: "stribeck:hip". EffectError for joints
    that make no machine, and effects that have no place there.
    """

    name: str = "standard leg"
    thigh_length: float = 0.40
    gravity: float = STANDARD_GRAVITY
    limits: Mapping[str, Limits] = field(default_factory=lambda: TABLE_1)
    terms: tuple[Term, ...] = ()
    custom: tuple[Effect, ...] = ()
    """Effects of the user's own, known beside the catalogue whether or not they are among the terms."""
    joints: tuple[Joint, ...] = LEG
    """Those of the leg, or of another machine, whose gravity may be 0."""
    moving_base: bool = False
    """Whether the machine's base moves and its recordings say how: angle (three in space) and, where they have it,
    acceleration."""
    forces: tuple[Force, ...] = ()
    """External forces that its recordings have measured; they are no effects, and belong to the base model."""
    wearer: Body | None = None
    """A person who wears it in all recordings, a known load: its numbers are those of the machine alone."""
    gravity_vector: Vector | None = None
    """Gravity (3,) m/s² in the frame of the base of a spatial machine; None where `gravity` pulls along -z."""

    def __post_init__(self) -> None:
        if not isinstance(self.name, str) or self.name.endswith(".toml"):
            remedy = f"read a file with exoid.Model.load({str(self.name)[:60]!r})"
            raise EffectError(f"Model makes a new model, and {str(self.name)[:60]!r} is no name for it", remedy=remedy)
        given = self.terms
        self._take_joints()
        object.__setattr__(self, "terms", ())
        if self.chain:
            check_joints(self.chain)
        self._take_gravity()
        for what, value, low, high, unit in (
            ("thigh_length", self.thigh_length, SHORTEST, LONGEST, "m"),
            ("gravity", self.gravity, LIGHTEST, HEAVIEST, "m/s²"),
        ):
            if not (low <= value <= high or (self.chain and value == 0.0)):
                raise EffectError(f"{what} is {value!r}", where="geometry", remedy=f"give {low:g} to {high:g} {unit}")
        for effect in self.custom:
            check_custom(effect, self.joints)
        object.__setattr__(self, "terms", self._named(given))
        for term in self.terms:
            if term.among is not self.joints and term.among != self.joints:
                raise EffectError(
                    f"{term.name} belongs to a machine with other joints", where=self.name, remedy="use with_effect()"
                )
            if term.effect.custom:
                check_units(term)
        if self.spatial:
            self._check_spatial()
        if self.wearer is not None:
            self.wearer.check(self.joints)
        called = [term.name for term in self.terms]
        check_forces(self.forces, self.joints, called)
        for name in called:
            if called.count(name) > 1:
                remedy = "keep one; its numbers could not be distinguished"
                raise EffectError(f"the model has {name} twice", where=self.name, remedy=remedy)

    def _check_spatial(self) -> None:
        """Refuse what a spatial machine cannot have yet."""
        for there, what, key in (
            (self.wearer is not None, "a wearer", "[wearer]"),
        ):
            if there:
                raise EffectError(
                    f"{what}: a machine whose joints have axes and origins cannot have that yet",
                    where=self.name,
                    remedy=f"leave {key} out, and keep the machine so meanwhile",
                )

    def __setstate__(self, state: dict[str, Any]) -> None:
        """Know the leg again in another process, where its joints come as a copy."""
        self.__dict__.update(state)
        self._take_joints()

    def _take_joints(self) -> None:
        """Know the leg by its joints; on a base that moves, and lying in a plane without gravity, it is another machine
        of the same joints.
        """
        joints = joints_of(self.joints)
        if joints is LEG and (self.moving_base or self.gravity == 0.0):
            # Its hip says where it sits: what is kept of one of the two machines is never taken for the other's.
            joints = (replace(LEG[0], length=self.thigh_length, parent="base"), *LEG[1:])
        object.__setattr__(self, "joints", joints)

    def _take_gravity(self) -> None:
        """Know gravity by its size and, where it is not that along -z, its vector; a vector may be given as `gravity`.
        """
        given = self.gravity_vector if isinstance(self.gravity, (int, float)) else self.gravity
        if given is None:
            return
        vector = three_numbers(given, "gravity")
        if not self.spatial:
            what = "gravity is a vector, and the machine is planar"
            raise EffectError(what, where=self.name, remedy="give a number, m/s² downwards within the plane")
        size = math.hypot(*vector)
        if given is self.gravity_vector and self.gravity not in (STANDARD_GRAVITY, size):
            what = f"gravity is {self.gravity:g} m/s², and its vector {size:g} m/s² long"
            raise EffectError(what, where=self.name, remedy="give the vector alone, as gravity")
        object.__setattr__(self, "gravity", size)
        object.__setattr__(self, "gravity_vector", None if vector == (0.0, 0.0, -size) else vector)

    @cached_property
    def effects(self) -> tuple[str, ...]:
        """The names of its terms, "stribeck:hip", in their order."""
        return tuple(term.name for term in self.terms)

    @classmethod
    def standard(cls, thigh_length: float = 0.40, gravity: float = STANDARD_GRAVITY) -> Self:
        """Return the eight-parameter leg of the paper."""
        return cls(thigh_length=float(thigh_length), gravity=float(gravity))

    def with_effect(self, effect: Effect | str, joint: str | None = None, *, own_places: bool = False) -> Self:
        """Return this model with one more effect; `effect` may be "stribeck", "stribeck:knee" or an Effect.

        A stop or a strap has one place in all recordings, or, with `own_places`, another in each. EffectError where
        there is no such effect, not at that joint, or where the model has it already.
        """
        return replace(self, terms=(*self.terms, replace(self._term(effect, joint), own_places=own_places)))

    def _term(self, effect: Effect | str, joint: str | None = None) -> Term:
        """Return the effect, or the one of that name, at its place; an Effect of one joint alone is at that one."""
        if isinstance(effect, Effect):
            alone = effect.joints[0] if len(effect.joints) == 1 and not effect.on_both else None
            return Term(effect, joint or alone, self.joints)
        if not isinstance(effect, str):
            kind = type(effect).__name__
            raise EffectError(f"a {kind} is no effect", where=self.name, remedy='name it: "stribeck:hip"')
        name, _, place = effect.partition(":")
        return Term(self.find_effect(name), joint or place or None, self.joints)

    def _named(self, terms: str | Effect | Iterable[Term | Effect | str]) -> tuple[Term, ...]:
        """Return `terms`, those that are only named among them."""
        several = [terms] if isinstance(terms, (str, Effect)) else terms
        return tuple(term if isinstance(term, Term) else self._term(term) for term in several)

    def without(self, *names: str) -> Self:
        """Return this model without the terms of these names; EffectError where it has none of one."""
        known = [term.name for term in self.terms]
        for name in names:
            if name not in known:
                remedy = "its terms are: " + (", ".join(known) or "none")
                raise EffectError(f"the model has no term {name!r}", where=self.name, remedy=remedy)
        return replace(self, terms=tuple(term for term in self.terms if term.name not in names))

    def base(self) -> Self:
        """Return the model of the same machine, with the same measured forces, without terms."""
        return replace(self, terms=()) if self.terms else self

    def with_forces(self, *forces: Force) -> Self:
        """Return this model with measured `forces` in place of its own; EffectError where it cannot have them."""
        return replace(self, forces=tuple(forces))

    def with_wearer(self, mass: float, height: float) -> Self:
        """Return this model worn by a person of `mass` kg and `height` m; BodyError for numbers that are no person's,
        and where the machine has no link for a leg.
        """
        return replace(self, wearer=Body(mass, height))

    @cached_property
    def unpushed(self) -> Self:
        """This model of the same machine while no force is measured."""
        return replace(self, forces=()) if self.forces else self

    def find_effect(self, id: str) -> Effect:
        """Return the effect of that id, of the user's own or of the catalogue; EffectError names the nearest."""
        own = {effect.id: effect for effect in (*self.custom, *(t.effect for t in self.terms if t.effect.custom))}
        if id in own:
            return own[id]
        return find_effect(id)

    @property
    def chain(self) -> tuple[Joint, ...]:
        """The joints of a machine that is not the leg; empty for the leg."""
        return () if self.joints is LEG else self.joints

    @cached_property
    def spatial(self) -> bool:
        """True if its joints move in space: they say axes and origins."""
        return is_spatial(self.joints)

    @property
    def pull(self) -> float | Vector:
        """Gravity as the machine's equations take it: m/s² downwards in a plane, (3,) in the base's frame in space."""
        return (self.gravity_vector or (0.0, 0.0, 0.0 - self.gravity)) if self.spatial else self.gravity

    @cached_property
    def joint_names(self) -> tuple[str, ...]:
        """Names of the joints (J,)."""
        return tuple(joint.name for joint in self.joints)

    @property
    def torque_unit(self) -> str:
        """The unit of its torques in words: "N·m", "N" where joints slide, "N·m, N" where some do."""
        return units(self.joints, "tau")

    @cached_property
    def inertial(self) -> tuple[Parameter, ...]:
        """Base parameters of the rigid machine."""
        if not self.chain:
            bounds = {"Phi1": 0.0, "Phi2": 0.0}
            return tuple(
                Parameter(name, f"inertia Φ{name[-1]}", "kg·m²", bounds.get(name), None, None) for name in INERTIAL
            )
        from exoid.symbolic.mechanics.base_parameters import base_parameters

        found = enumerate(base_parameters(self.chain, self.pull, self.moving_base), 1)
        return tuple(
            Parameter(f"Phi{k}", f"Φ{k} = {p.formula(self.chain)}", p.unit, 0.0 if p.positive else None, None, None)
            for k, p in found
        )

    @property
    def mixture(self) -> Float:
        """Base parameters (P, J, 3) of inertia, first moment and mass of every link, about its upper joint; (P, J, 10)
        of the ten of a spatial machine (`mechanics.spatial.KINDS`).
        """
        from exoid.symbolic.mechanics.base_parameters import leg_mixture, tree_mixture

        if not self.chain:
            return leg_mixture(self.thigh_length)
        return tree_mixture(self.chain, self.pull, self.moving_base)

    @property
    def base_state(self) -> tuple[str, ...]:
        """The quantities that a motion has of its base, in that order; nothing where the base stands still."""
        from exoid.symbolic.codegen.layout import base_state

        return base_state(self.moving_base, self.spatial)

    @property
    def friction(self) -> slice:
        """The place of the parameters of friction among all, two per joint."""
        return slice(len(self.inertial), len(self.inertial) + 2 * len(self.joints))

    @property
    def bent_friction(self) -> tuple[int, ...]:
        """The places of dry and viscous friction that a term bends, so that they cannot be negative."""
        bent = [term.first for term in self.terms if term.effect.bends_friction]
        return tuple(self.friction.start + 2 * joint + k for joint in bent for k in range(2))

    @cached_property
    def base_count(self) -> int:
        """Number of parameters of the model without terms: inertial, of friction, and of measured forces."""
        return int(self.friction.stop + sum(len(force.parameters(self.joints)) for force in self.forces))

    @cached_property
    def channels(self) -> tuple[str, ...]:
        """The columns (C,) of the measured forces, in the order in which a motion has them."""
        return channels_of(self.forces)

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """Linear parameters (P,), in the order of the columns."""
        places = tuple(p for force in self.forces for p in force.parameters(self.joints))
        own = tuple(p for term in self.terms for p in term.parameters)
        return self.inertial + friction_parameters(self.joints) + places + own

    @cached_property
    def shapes(self) -> tuple[ShapeParameter, ...]:
        """Shape parameters (S,): what the torque is not linear in."""
        return tuple(shape for term in self.terms for shape in term.shapes)

    @cached_property
    def typical_shape(self) -> Float:
        """The usual shape values (S,)."""
        return np.array([shape.typical for shape in self.shapes], dtype=float)

    @property
    def derived(self) -> tuple[Term, ...]:
        """The terms that change the mechanism itself."""
        return tuple(term for term in self.terms if term.effect.derive is not None)

    @property
    def mechanism(self) -> Mechanism:
        """The mechanism in symbols, with the changes its derived terms make; lengths are numbers, but for the leg's."""
        from exoid.symbolic.mechanics.mechanism import leg, machine
        from exoid.symbolic.mechanics.rigid import changed

        return changed(machine(self.chain) if self.chain else leg(), self.derived)[0]

    @property
    def motion_limits(self) -> Mapping[str, Limits]:
        """The limits of every joint, in the order of the joints, with usual ones where the model says none."""
        return {joint.name: self.limits.get(joint.name, UNLIMITED).filled(USUAL[joint.turns]) for joint in self.joints}

    def _repr_html_(self) -> str:
        size = f"gravity {self.gravity:g} m/s²"
        size += f" along {self.gravity_vector}" if self.gravity_vector else ""
        machine = f"joints {', '.join(self.joint_names)}" if self.chain else f"thigh {self.thigh_length:g} m"
        linear = [(p.name, p.label, p.unit, p.min, p.max) for p in self.parameters]
        shape = [(s.name, s.shape.explains or "shape", s.shape.unit, s.shape.min, s.shape.max) for s in self.shapes]
        rows = table(("number", "meaning", "unit", "at least", "at most"), [*linear, *shape])
        return lines(f"{machine}, {size}", strong=self.name) + rows

    def __repr__(self) -> str:
        terms = "".join(f" + {item}" for item in [*(f.name for f in self.forces), *(t.name for t in self.terms)])
        machine = f"{', '.join(self.joint_names)}" if self.chain else "leg"
        machine += "" if self.wearer is None else f" worn by {self.wearer}"
        return f"Model({self.name!r}: rigid {machine} + Coulomb + viscous{terms}; {len(self.parameters)} parameters)"


def joints_of(given: Any) -> tuple[Joint, ...]:
    """Return `given` joints, those that are only named among them as ones that turn; none are the leg's."""
    several = tuple(given or LEG) if isinstance(given, (list, tuple)) else (given,)
    wrong = next((item for item in several if not isinstance(item, (str, Joint))), None)
    if wrong is not None:
        raise EffectError(f"a {type(wrong).__name__} is no joint", remedy='name it, "hip", or give a Joint("hip")')
    if several in (names(LEG), LEG):
        return LEG
    return tuple(entry if isinstance(entry, Joint) else Joint(entry) for entry in several)


def require_still_base(model: ModelStructure, what: str) -> None:
    """Refuse a machine whose base is measured; EffectError says `what` takes the base to stand still."""
    if model.moving_base:
        raise EffectError(
            f"{what} takes the base to stand still, and that of this model is measured",
            where=model.name,
            remedy='give the same model with [base] motion = "fixed", and keep the base still meanwhile',
        )


def require_no_force(model: ModelStructure, what: str) -> None:
    """Refuse a machine whose recordings have measured forces; EffectError says that `what` does not read them."""
    if model.forces:
        raise EffectError(
            f"{what} does not read measured forces, and the model has {' and '.join(f.name for f in model.forces)}",
            where=model.name,
            remedy="give the same model without [[forces]], and let nothing push the machine meanwhile",
        )


def check_custom(effect: Effect, joints: tuple[Joint, ...]) -> None:
    """Refuse a user's effect that has no place among the joints, or not the unit of one of its own."""
    unknown = [name for name in effect.joints if name not in ("both", *(joint.name for joint in joints))]
    if unknown and effect.joints != JOINTS:
        what = f"joints are {effect.joints!r}; the machine has no {', '.join(unknown)}"
        raise EffectError(what, where=effect.id, remedy=f"use {', '.join(joint.name for joint in joints)}")
    if effect.torque is not None:
        for place in places_of(effect, joints):
            check_units(Term(effect, place, joints))
