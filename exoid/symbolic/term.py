"""The members of a model: a term is an effect at its place; its numbers are parameters and shapes with full
names.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

from exoid.ground.errors import EffectError
from exoid.symbolic.effect import Effect, Shape
from exoid.symbolic.joints import LEG, LEVER, SLIDING, Joint, is_spatial, parents
from exoid.symbolic.language.deflection import deflected
from exoid.symbolic.quantity import JOINTS


@dataclass(frozen=True)
class Parameter:
    """A number the torque is linear in: full name ("stribeck:knee.c"), label, unit, bounds, and its term."""

    name: str
    label: str
    unit: str
    min: float | None
    max: float | None
    term: str | None
    typical: float | None = None


@dataclass(frozen=True)
class ShapeParameter:
    """A number the torque is not linear in, with its full name ("stribeck:knee.v_s")."""

    name: str
    shape: Shape
    term: str

    @property
    def typical(self) -> float:
        """The usual value: as the effect states it, else the middle of its range (first of its choices)."""
        if self.shape.typical is not None:
            return self.shape.typical
        if self.shape.choices:
            return self.shape.choices[0]
        if self.shape.spacing == "log" and self.shape.min > 0.0:
            return float((self.shape.min * self.shape.max) ** 0.5)
        return 0.5 * (self.shape.min + self.shape.max)


@dataclass(frozen=True, eq=False)
class Term:
    """An `effect` at a `joint` (its name), or on both joints of the leg (None); `among` are the machine's joints.

    Where the machine is not the leg, an effect on both is one on a joint and the next, and `joint` is the first; one
    that changes the mechanism of the whole machine has no joint there either. A place that may move between recordings
    (of a stop, a strap) is one and the same in all of them, unless they have `own_places`.
    """

    effect: Effect
    joint: str | None
    among: tuple[Joint, ...] = LEG
    own_places: bool = False

    def __post_init__(self) -> None:
        effect = self.effect
        places = places_of(effect, self.among)
        if self.joint is not None and places == (None,):
            what = f"{effect.id} acts on {'both' if self.among is LEG else 'all'} joints at once"
            raise EffectError(what, where=f"{effect.id}:{self.joint}", remedy=f"leave the joint out: {effect.id}")
        if self.joint not in places:
            reason = self._why_not()
            raise EffectError(
                f"{effect.id} needs a joint"
                if self.joint is None and places
                else f"{effect.id} has no place "
                + ("here" if self.joint is None else f"at {self.joint!r}")
                + (f": {reason}" if reason else ""),
                where=effect.id,
                remedy="use " + " or ".join(f"{effect.id}:{joint}" for joint in places)
                if places
                else "use another effect: this one has no place on this machine",
            )

    def _why_not(self) -> str:
        """Return the reason why the effect cannot be at its joint, where one is known."""
        effect = self.effect
        if not fits(effect, self.among):
            if is_spatial(self.among):
                return "machines that move in a plane alone have it"
            if effect.machines == "spatial":
                return "machines in space alone have it"
            return "the leg with hip and knee alone has it" if effect.machines == "leg" else "the leg has others"
        if self.among is LEG:
            return effect.absorbed_on.get(str(self.joint), "")
        if self.joint in [joint.name for joint in self.among] and effect.absorbed_on:
            return "the base model contains it already"
        return ""

    @cached_property
    def name(self) -> str:
        """Full name: "stribeck:knee", or "gravity_tilt" for an effect on both joints of the leg."""
        return self.effect.id if self.joint is None else f"{self.effect.id}:{self.joint}"

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """The term's linear parameters, in the order of the effect's coefficients."""
        title = self.effect.title or self.effect.id.replace("_", " ")
        return tuple(
            Parameter(
                name=f"{self.name}.{key}",
                label=f"{title} {self.joint or ''}".strip() + (f" ({c.explains})" if c.explains else ""),
                unit=self.unit(c.unit),
                min=c.min,
                max=c.max,
                term=self.name,
                typical=None if c.typical is None else self._scale(c.unit) * c.typical,
            )
            for key, c in self.effect.coefficients.items()
        )

    @cached_property
    def shapes(self) -> tuple[ShapeParameter, ...]:
        """The term's shape parameters, in the order of the effect."""
        return tuple(ShapeParameter(f"{self.name}.{key}", shape, self.name) for key, shape in self.placed_shape.items())

    @cached_property
    def placed_shape(self) -> Mapping[str, Shape]:
        """The effect's shapes as they are at the term's joint, by short name."""
        return {key: self._shape(shape) for key, shape in self.effect.shape.items()}

    @property
    def may_move(self) -> bool:
        """True if it has a place that mounting or strapping may move between recordings."""
        return any(item.per_recording and item.spacing == "position" for item in self.effect.shape.values())

    @property
    def first(self) -> int:
        """Index of the term's joint, of the first of them for an effect on two."""
        return 0 if self.joint is None else [joint.name for joint in self.among].index(self.joint)

    def unit(self, unit: str) -> str:
        """Return a unit of the catalogue as it is at the term's joint: N for N·m, m for rad where that slides."""
        if not self._slides:
            return unit
        for turning, sliding in SLIDING:
            unit = unit.replace(turning, sliding)
        return unit

    @property
    def _slides(self) -> bool:
        """True if numbers of the catalogue, which are those of a turning joint, have to be those of a sliding one."""
        return not self.effect.custom and self.joint is not None and not self.among[self.first].turns

    def _scale(self, unit: str) -> float:
        """Return the factor on a number with a `unit` of the catalogue at its joint: where that slides, that of a drum
        of radius `LEVER`.
        """
        if not self._slides:
            return 1.0
        above, _, below = unit.partition("/")
        return float(LEVER ** (_power_of_angle(above) - _power_of_angle(below)))

    def _shape(self, shape: Shape) -> Shape:
        """Return a shape as it is at the term's joint. Places keep their range: they are not sizes, and a stage may be
        long.
        """
        if shape.spacing == "position" and not self.own_places:
            shape = replace(shape, per_recording=False)
        if not self._slides:
            return shape
        unit = "1/rad" if shape.counts_angle else shape.unit
        scale = self._scale(unit) if shape.min >= 0.0 else 1.0
        usual = None if shape.typical is None else scale * shape.typical
        return replace(shape, unit=self.unit(unit), min=scale * shape.min, max=scale * shape.max, typical=usual)

    @property
    def texts(self) -> Iterator[tuple[int, str]]:
        """Yield (joint index, torque text) of every joint the effect acts on; nothing for a derived effect."""
        torque = self.effect.torque
        if isinstance(torque, str):
            yield self.first, torque
        elif torque is not None:
            yield from ((self.first + JOINTS.index(joint), text) for joint, text in torque.items())
        elif self.effect.deflection is not None:
            yield from deflected(self.effect.deflection, self.first, self.among)

    @cached_property
    def reaches(self) -> tuple[int, ...]:
        """Indices of the joints whose torque the effect changes."""
        if self.effect.reach == "all":
            return tuple(range(len(self.among)))
        return (self.first,) if self.effect.reach == "own" else (self.first, self.first + 1)


def fits(effect: Effect, among: tuple[Joint, ...]) -> bool:
    """True if machines of these joints have the effect at all."""
    if effect.machines == "spatial" or is_spatial(among):
        return is_spatial(among) and effect.machines in ("spatial", "all", "others")
    kind = effect.machines.removeprefix("planar").strip()
    return kind in ("", "all") or (kind == "leg") == (among is LEG)


def places_of(effect: Effect, among: tuple[Joint, ...]) -> tuple[str | None, ...]:
    """Return the joints of a machine at which an effect can be; for one on two joints, the first of them; None for an
    effect on the whole machine.
    """
    names = tuple(joint.name for joint in among)
    if not fits(effect, among):
        return ()
    if effect.on_both and (among is LEG or effect.derive is not None):
        return (None,)
    if among is LEG:
        return effect.joints
    above = parents(among)
    if effect.worn:
        return effect.joints if {*JOINTS} <= {*names} else ()
    if effect.on_both:
        return tuple(name for k, name in enumerate(names) if k + 1 < len(names) and above[k + 1] == k)
    if effect.custom and effect.joints != JOINTS:
        return tuple(joint for joint in effect.joints if joint in names)
    if effect.absorbed_on:
        return tuple(name for name, gone in zip(names, _absorbed(among), strict=True) if not gone)
    return names


def _absorbed(among: tuple[Joint, ...]) -> tuple[bool, ...]:
    """Return of which joints (J,) the base model contains the inertia of the drive."""
    if not is_spatial(among):
        return tuple(carrier is None for carrier in parents(among))
    from exoid.symbolic.mechanics.base_parameters import absorbed_rotors

    return absorbed_rotors(among)


def _power_of_angle(unit: str) -> int:
    """Return the power of rad in a product of units: 2 in "N·m·s²·rad²"."""
    return sum({"²": 2, "³": 3}.get(raised, 1) for raised in re.findall(r"rad([²³]?)", unit))
