"""Settings of a verb, each written once: name, default, unit, range and meaning, for Python and the command line.

A verb with many settings takes a record of them, or the same names as keywords: `design(leg, harmonics=3)` is
`design(leg, DesignSettings(harmonics=3))`.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import Field, dataclass, field, fields, replace
from typing import Any, ClassVar, TypeVar

from exoid.ground.errors import ExoidError
from exoid.ground.suggest import did_you_mean

Record = TypeVar("Record", bound="VerbSettings")


class SettingError(ExoidError, TypeError):
    """A setting that there is not, or a value that it cannot have."""


@dataclass(frozen=True)
class Setting:
    """Meaning of a setting, its `unit`, and its allowed values: from `low` to `high`, or one of `choices`."""

    meaning: str
    low: float = -math.inf
    high: float = math.inf
    unit: str = ""
    choices: Sequence[str] = ()

    def objection(self, name: str, value: Any) -> tuple[str, str] | None:
        """Objection to a value, and the remedy; None where it is allowed or not given."""
        if value is None:
            return None
        if self.choices:
            wrong = f"there is no {name} {value!r}", f"one of: {', '.join(self.choices)}"
            return None if value in self.choices else wrong
        if math.isinf(self.high) or self.low <= value <= self.high:
            return None
        room = f"{self.low:g} to {self.high:g}"
        if not self.unit:
            return f"{name} {value:g}", f"give {room} {name}"
        return f"a {name} of {value:g} {self.unit}", f"give a {name} of {room} {self.unit}"


def setting(
    default: Any, meaning: str, low: float = -math.inf, high: float = math.inf, unit: str = "",
    *, choices: Sequence[str] = (),
) -> Any:  # fmt: skip
    """Return the field of a record for a setting with this `default`."""
    return field(default=default, metadata={"setting": Setting(meaning, low, high, unit, choices)})


@dataclass(frozen=True, kw_only=True)
class VerbSettings:
    """Settings of a verb beside its subject; a value that a setting cannot have is a `refusal`."""

    refusal: ClassVar[type[ExoidError]] = SettingError

    seed: int = setting(0, "seed of everything random")

    def __post_init__(self) -> None:
        for entry, about in settings_in(type(self)):
            objection = about.objection(entry.name, getattr(self, entry.name))
            if objection is not None:
                raise self.refusal(objection[0], remedy=objection[1])

    @classmethod
    def chosen(cls: type[Record], given: Record | None, changes: Mapping[str, Any]) -> Record:
        """Return `given`, or the defaults, with `changes`; SettingError for a name that there is not."""
        known = [entry.name for entry in fields(cls)]
        for name in changes:
            if name not in known:
                remedy = did_you_mean(name, known) or f"there are {', '.join(known)}"
                raise SettingError(f"there is no setting {name!r}", remedy=remedy)
        return replace(given or cls(), **changes)


def settings_in(record: type[VerbSettings]) -> Iterator[tuple[Field[Any], Setting]]:
    """Yield the settings of a record, with what each means."""
    return ((entry, entry.metadata["setting"]) for entry in fields(record))


def default_of(entry: Field[Any]) -> str:
    """Return " (10 s)" of a setting with this default; nothing where it is none, a switch or no plain value."""
    unit = entry.metadata["setting"].unit
    if isinstance(entry.default, bool) or not isinstance(entry.default, (str, int, float)):
        return ""
    value = f"{entry.default:g}" if isinstance(entry.default, float) else f"{entry.default}"
    return f" ({value}{unit and ' '}{unit})"
