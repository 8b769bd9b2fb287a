"""A physical effect as data: its torque, its numbers with units, and what it means to a technician.

Sign convention, stated once: the torque of an effect stands on the left side of the equation of motion,

    M(θ) θ'' + C(θ, θ') θ' + G(θ) + Σ effects = τ ,

so it is *torque that the drive has to supply*. Friction therefore has the sign of the velocity, and a spring
that pulls back towards θ = 0 has the sign of θ. Built-in effects and a user's `[[custom_effects]]` are the
same type, written in the same torque language (`exoid/symbolic/language`).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

from exoid.ground.errors import EffectError
from exoid.ground.html import code, lines, table
from exoid.symbolic.effect_declaration import check_effect

NOTHING: Mapping[str, Any] = MappingProxyType({})


@dataclass(frozen=True)
class Coefficient:
    """A number the torque is linear in. `min`/`max` are physical bounds (None: none), `typical` its usual size."""

    unit: str
    min: float | None = None
    max: float | None = None
    typical: float | None = None
    explains: str = ""


@dataclass(frozen=True)
class Shape:
    """A number the torque is not linear in: bounded, or one of `choices` (then min and max span them).

    `spacing` says how a search should space its trial values: "linear", "log", "time" (a moment of the recording,
    or one before or after it), or "position" (a place on the
    joint's path: spaced by how often the joint is there, densest near the ends of its range). `points` is how many
    it needs so that neighbouring trial values still resemble each other. `per_recording` marks a value that each
    recording has to itself; a position is then one that mounting or strapping may move, and the same in all recordings
    unless the term has `own_places`. `turns` marks an angle that
    turns pairs of coefficients, sine and cosine parts in their order: one for all recordings is nothing that these do
    not describe, and where each has its own it follows from theirs.
    """

    unit: str
    min: float
    max: float
    choices: tuple[float, ...] = ()
    spacing: str = "linear"
    points: int = 9
    typical: float | None = None
    explains: str = ""
    per_recording: bool = False
    turns: bool = False
    counts_angle: bool = False
    """Whether it is a number per rad although its unit is 1 (cycles per turn), so that it is one per m of a slide."""
    sharp: bool = False
    """Whether its lowest value stands for the same effect without any transition, so that it is no limit there."""

    @property
    def is_own(self) -> bool:
        """True if each recording has a number of its own that is no place."""
        return self.per_recording and self.spacing != "position"


@dataclass(frozen=True)
class Effect:
    """One entry of the catalogue, or an effect of the user's own; EffectError or ExpressionError where it contradicts
    itself.

    `joints` is ("hip", "knee") or a part of it (or "hip") for an effect that belongs to one joint at a time, and
    ("both",) for an effect that acts on both joints at once. Exactly one of `torque`, `derive` and `deflection` is
    given:

    * `torque`: one text for a single-joint effect (`theta`, `dtheta`, `ddtheta`, `tau_rigid`, `tau_model` mean its
      own joint), or {"hip": text, "knee": text} for an effect on both joints.
    * `derive(mechanism, symbols)`: returns the changed Mechanism, or a SymPy torque for every joint; `symbols` maps
      each coefficient and shape to its SymPy symbol, and `mechanism.own` is the index of the effect's joint.
    * `deflection`: {coefficient: text} of the angle in rad by which the link of its joint stays behind what the encoder
      reads, for one unit of the coefficient; the torques of other joints change too (`language/deflection.py`).

    On machines that are not the leg an effect with joints ("hip", "knee") can be at every joint, one on ("both",) with
    torque texts at every pair of neighbours, and a derived one on ("both",) once, for the whole machine.
    """

    id: str
    explains: str = ""
    torque: str | Mapping[str, str] | None = None
    derive: Callable[[Any, Mapping[str, Any]], Any] | None = None
    joints: tuple[str, ...] = ("hip", "knee")
    coefficients: Mapping[str, Coefficient] = field(default_factory=lambda: NOTHING)
    """Of each number its `Coefficient`, or only its unit: {"c": "N·m·s/rad"}."""
    shape: Mapping[str, Shape] = field(default_factory=lambda: NOTHING)
    family: str = "other"
    title: str = ""
    absorbed_on: Mapping[str, str] = field(default_factory=lambda: NOTHING)
    """Joints on which the base model already contains the effect, with the reason (rotor inertia at the hip)."""
    tells_apart: str = ""
    reference: str = "no reference given"
    custom: bool = False
    drive: bool = False
    """Whether it is an effect of the drive or of its torque sensor: a joint without a drive cannot have it."""
    deflection: Mapping[str, str] | None = None
    machines: str = "all"
    """Which machines have it: "all", the "leg" with hip and knee, or "others"; only those that move in a plane where it
    is "planar" or "planar others", only those in space where it is "spatial".
    """
    bends_friction: bool = False
    """Whether it is another curve of the friction that its joint has anyhow, so that dry and viscous friction cannot be
    negative beside it.
    """
    worn: bool = False
    """Whether it is a person's own: machines with a hip and a knee have it, and it is looked for where the model has a
    wearer.
    """

    def __post_init__(self) -> None:
        if isinstance(self.joints, str):
            object.__setattr__(self, "joints", (self.joints,))
        units = {key: Coefficient(item) if isinstance(item, str) else item for key, item in self.coefficients.items()}
        object.__setattr__(self, "coefficients", units)
        if [self.torque, self.derive, self.deflection] == [None] * 3:
            place = "" if self.joints in (("hip", "knee"), ("both",)) else f":{self.joints[0]}"
            raise EffectError(
                "an Effect is a new one of your own, and this has no torque",
                where=str(self.id)[:60],
                remedy=f"name one of the catalogue: model.with_effect('{str(self.id)[:60]}{place}'); or give a torque: "
                "Effect('magnet', 'a magnet', torque='c * dtheta', coefficients={'c': Coefficient('N·m·s/rad')})",
            )
        check_effect(self)

    def _repr_html_(self) -> str:
        """Show what the catalogue says, in a notebook."""
        texts = {"": self.torque} if isinstance(self.torque, str) else dict(self.torque or {})
        torque = "\n".join(f"{joint}: {text}" if joint else text for joint, text in texts.items())
        numbers = [(n, c.unit, c.min, c.max, c.explains) for n, c in self.coefficients.items()]
        numbers += [(n, s.unit, s.min, s.max, s.explains) for n, s in self.shape.items()]
        return (
            lines(self.explains, strong=f"{self.id}: {self.title or self.family}")
            + (code(torque) if torque else lines(self.made_by))
            + table(("number", "unit", "at least", "at most", "meaning"), numbers)
            + lines(self.tells_apart and f"What distinguishes it: {self.tells_apart}", f"Reference: {self.reference}")
        )

    @property
    def made_by(self) -> str:
        """Origin of the torque of an effect without a text, in words."""
        if self.deflection is None:
            return "derived by Lagrange from the changed leg"
        angle = " + ".join(f"{key} · {text}" for key, text in self.deflection.items())
        return f"first-order change of both torques where the link stays behind its encoder by {angle} (rad)"

    @property
    def reach(self) -> str:
        """Whose torque the effect changes: "own" joint, "own and next", or "all" joints."""
        if self.derive is not None or self.deflection is not None:
            return "all"
        return "own and next" if self.on_both else "own"

    @property
    def has_own_numbers(self) -> bool:
        """True if each recording has a number of its own that is no place."""
        return any(shape.is_own for shape in self.shape.values())

    @property
    def on_both(self) -> bool:
        """True if the effect acts on both joints at once."""
        return self.joints == ("both",)
