"""Thresholds that decide, where they are used: each a number that says what it prevents, gathered into one table."""

from __future__ import annotations

import importlib
import pkgutil
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from types import ModuleType


@dataclass(frozen=True)
class Rule:
    """One threshold as a table shows it: the question it belongs to, its name, value, and what it prevents."""

    group: str
    name: str
    value: float
    prevents: str


class Threshold(float):
    """A number that decides; it `prevents` what would be concluded without it."""

    prevents: str
    module: str

    def __new__(cls, value: float, prevents: str) -> Threshold:
        """Return the number `value`, and remember which module declares it."""
        number = super().__new__(cls, value)
        number.prevents = prevents
        number.module = sys._getframe(1).f_globals["__name__"]  # where it is declared, as a namedtuple knows it
        return number

    def __getnewargs__(self) -> tuple[float, str]:  # type: ignore[override]
        return float(self), self.prevents


def thresholds_in(place: ModuleType, group: str) -> Iterator[Rule]:
    """Yield the thresholds that a module, or the modules of a package, declare; a name says the module as well."""
    below = pkgutil.walk_packages(getattr(place, "__path__", ()), f"{place.__name__}.")
    for path in [place.__name__, *sorted(one.name for one in below)]:
        for name, value in vars(importlib.import_module(path)).items():
            if isinstance(value, Threshold) and value.module == path:
                yield Rule(group, f"{path.rpartition('.')[2]}.{name}", float(value), value.prevents)
