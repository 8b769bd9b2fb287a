"""The members of a model: a term is an effect at its place; its numbers are parameters and shapes with full
names.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

from ground.errors import EffectError
from symbolic.effect import Effect, Shape
from symbolic.language.deflection import deflected
from symbolic.quantity import JOINTS


@dataclass(frozen=True)
class Parameter:
    """A number the torque is linear in: full name ("stribeck:knee.c"), label, unit, bounds, LaTeX, and its
    term.
    """

    name: str
    label: str
    unit: str
    min: float | None
    max: float | None
    latex: str
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
    """An `effect` at a `joint` ("hip", "knee"), or on both (None)."""

    effect: Effect
    joint: str | None

    def __post_init__(self) -> None:
        effect = self.effect
        if effect.on_both and self.joint is not None:
            raise EffectError(
                f"{effect.id} acts on both joints at once",
                where=f"{effect.id}:{self.joint}",
                remedy=f"leave the joint out: {effect.id}",
            )
        if not effect.on_both and self.joint not in effect.joints:
            reason = effect.absorbed_on.get(str(self.joint), "")
            raise EffectError(
                f"{effect.id} needs a joint"
                if self.joint is None
                else f"{effect.id} has no place at {self.joint!r}" + (f": {reason}" if reason else ""),
                where=effect.id,
                remedy="use " + " or ".join(f"{effect.id}:{joint}" for joint in effect.joints),
            )

    @property
    def name(self) -> str:
        """Full name: "stribeck:knee", or "gravity_tilt" for an effect on both joints."""
        return self.effect.id if self.joint is None else f"{self.effect.id}:{self.joint}"

    @cached_property
    def parameters(self) -> tuple[Parameter, ...]:
        """The term's linear parameters, in the order of the effect's coefficients."""
        title = self.effect.title or self.effect.id.replace("_", " ")
        return tuple(
            Parameter(
                name=f"{self.name}.{key}",
                label=f"{title} {self.joint or ''}".strip() + (f" ({c.explains})" if c.explains else ""),
                unit=c.unit,
                min=c.min,
                max=c.max,
                latex=_latex(key, self.effect.id, self.joint),
                term=self.name,
                typical=c.typical,
            )
            for key, c in self.effect.coefficients.items()
        )

    @cached_property
    def shapes(self) -> tuple[ShapeParameter, ...]:
        """The term's shape parameters, in the order of the effect."""
        return tuple(ShapeParameter(f"{self.name}.{key}", shape, self.name) for key, shape in self.effect.shape.items())

    @property
    def texts(self) -> Iterator[tuple[int, str]]:
        """Yield (joint index, torque text) of every joint the effect acts on; nothing for a derived effect."""
        torque = self.effect.torque
        if isinstance(torque, str):
            yield JOINTS.index(str(self.joint)), torque
        elif torque is not None:
            yield from ((JOINTS.index(joint), text) for joint, text in torque.items())
        elif self.effect.deflection is not None:
            yield from deflected(self.effect.deflection, JOINTS.index(str(self.joint)))

    @property
    def reaches(self) -> tuple[int, ...]:
        """Indices of the joints whose torque the effect changes."""
        if self.joint is None or self.effect.deflection is not None:
            return tuple(range(len(JOINTS)))
        return (JOINTS.index(self.joint),)


def _latex(key: str, effect: str, joint: str | None) -> str:
    place = effect.replace("_", r"\ ") + (f",{joint}" if joint else "")
    stem, _, index = key.partition("_")
    return f"{stem}_{{\\mathrm{{{index + ',' if index else ''}{place}}}}}"
