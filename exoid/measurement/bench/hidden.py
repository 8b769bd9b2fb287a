"""Effects hidden in the leg on the bench, each with its joint and its size.

A size is given as numbers for the effect's coefficients and shapes; what is not given takes its typical
value. On the command line: `ID[:joint][=size]`, where size is one number (the first coefficient; the others
keep their proportion to it) or a list such as `a=0.8,n=24`.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.errors import EffectError
from exoid.symbolic.effect import Effect
from exoid.symbolic.model import Model

NOTHING: Mapping[str, float] = MappingProxyType({})


@dataclass(frozen=True)
class Hidden:
    """An effect (id or `Effect`) on `joint` (None for one on both), with `values` by coefficient or shape
    name.

    `size`, where given, is the first coefficient; coefficients not named in `values` keep their typical
    proportion.
    """

    effect: str | Effect
    joint: str | None = None
    values: Mapping[str, float] = field(default_factory=lambda: NOTHING)
    size: float | None = None

    def __post_init__(self) -> None:
        """Take "stribeck:knee" apart."""
        if isinstance(self.effect, str) and ":" in self.effect and self.joint is None:
            identity, _, joint = self.effect.partition(":")
            object.__setattr__(self, "effect", identity)
            object.__setattr__(self, "joint", joint)

    @property
    def name(self) -> str:
        """The term's name: `stribeck:knee`, or `gravity_tilt` for an effect on both joints."""
        identity = self.effect if isinstance(self.effect, str) else self.effect.id
        return f"{identity}:{self.joint}" if self.joint else identity


def parse_hidden(text: str) -> Hidden:
    """Return the effect that `ID[:joint][=size]` names; EffectError where the text has another form or a number is not
    finite.
    """
    name, equals, size = text.partition("=")
    identity, _, joint = name.strip().partition(":")
    if not identity or (equals and not size.strip()):
        raise _unreadable(text)
    if not equals:
        return Hidden(identity, joint or None)
    if "=" not in size:
        return Hidden(identity, joint or None, size=_number(size, text))
    values: dict[str, float] = {}
    for part in size.split(","):
        key, inner, number = part.partition("=")
        if not inner or not key.strip() or key.strip() in values:
            raise _unreadable(text)
        values[key.strip()] = _number(number, text)
    return Hidden(identity, joint or None, MappingProxyType(values))


def hidden_in(effects: str | Effect | Hidden | Iterable[str | Effect | Hidden]) -> tuple[Hidden, ...]:
    """Return the effects hidden in a machine, one or several, those that are only named ("stribeck:knee=0.8") among
    them.
    """
    several = [effects] if isinstance(effects, (str, Effect, Hidden)) else effects
    found = (parse_hidden(item) if isinstance(item, str) else item for item in several)
    return tuple(Hidden(entry) if isinstance(entry, Effect) else entry for entry in found)


@dataclass(frozen=True, eq=False)
class TrueModel:
    """The model the bench obeys, with its numbers `linear` (P,) and `shape` (S,)."""

    model: Model
    linear: NDArray[np.float64]
    shape: NDArray[np.float64]

    def torque(self, motion: Any) -> NDArray[np.float64]:
        """Return the torque (N, J) in N·m that the drives supply along `motion`."""
        return self.model.torque(motion, self.linear, self.shape)

    def numbers(self) -> dict[str, float]:
        """Return every parameter and shape of the model by its full name (`stribeck:knee.v_s`)."""
        names = [entry.name for entry in self.model.parameters] + [entry.name for entry in self.model.shapes]
        return dict(zip(names, (float(value) for value in (*self.linear, *self.shape)), strict=True))


def true_model(model: Model, base: Iterable[float], effects: Iterable[Hidden]) -> TrueModel:
    """Return `model` with `effects` built in and all numbers set; `base` (8,) belongs to its first eight
    parameters.

    Terms that `model` has already keep their typical size unless an entry of `effects` names them. Raises
    EffectError for an effect, joint or value name that does not exist.
    """
    wanted = {entry.name: entry for entry in effects}
    for entry in wanted.values():
        if entry.name not in {term.name for term in model.terms}:
            model = model.with_effect(entry.effect, joint=entry.joint)
    by_name = {term.name: term for term in model.terms}
    missing = sorted(set(wanted) - set(by_name))
    if missing:
        what = f"the bench could not place {', '.join(missing)}"
        raise EffectError(what, remedy="name the joint, as in ID:knee; an effect on both joints takes none")
    numbers: dict[str, float] = {}
    for name, term in by_name.items():
        numbers |= _numbers(model, name, wanted.get(name, Hidden(term.effect, term.joint)))
    plain = tuple(base)
    linear = [*plain, *(numbers[entry.name] for entry in model.parameters[len(plain) :])]
    return TrueModel(model, np.array(linear), np.array([numbers[entry.name] for entry in model.shapes], dtype=float))


def _numbers(model: Model, name: str, hidden: Hidden) -> dict[str, float]:
    """Return {full name: value} for the parameters and shapes of term `name`."""
    linear = {entry.name: entry.typical for entry in model.parameters if entry.term == name}
    typical = {key: 1.0 if value is None else value for key, value in linear.items()}
    typical |= {entry.name: entry.typical for entry in model.shapes if entry.term == name}
    short = {full.rpartition(".")[2]: full for full in typical}
    unknown = sorted(set(hidden.values) - set(short))
    if unknown:
        what = f"{name} has no number called {', '.join(unknown)}"
        raise EffectError(what, where=name, remedy=f"its numbers are {', '.join(short)}")
    out = dict(typical)
    first = next(iter(typical), None)
    if hidden.size is not None and first is not None:
        # A transform such as a drive's gain has no coefficient: its first shape is its size.
        scale = hidden.size / typical[first] if typical[first] else 1.0
        out |= {key: typical[key] * scale for key in linear}
        out[first] = hidden.size
    return out | {short[key]: float(value) for key, value in hidden.values.items()}


def _number(text: str, whole: str) -> float:
    try:
        value = float(text)
    except ValueError:
        raise _unreadable(whole) from None
    if not math.isfinite(value):
        raise _unreadable(whole)
    return value


def _unreadable(text: str) -> EffectError:
    return EffectError(
        "this is not an effect with a size",
        where=repr(text),
        remedy="write ID[:joint][=size], for example stribeck:knee=2.6 or torque_ripple:knee=a=0.8,n=24",
    )
