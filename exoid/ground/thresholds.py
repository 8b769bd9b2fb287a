"""Numbers that decide, declared where they are used, each with what would be concluded without it; one table of all."""

from __future__ import annotations

import importlib
import pkgutil
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


_DECLARED: dict[str, dict[str, Rule]] = {}
"""Rules by the module that declares them and their name there."""


def threshold(module: str, name: str, value: float, prevents: str) -> float:
    """The number `value`; the table has it as `name` of `module` (its `__name__`), with what it `prevents`."""
    called = f"{module.rpartition('.')[2]}.{name}"
    _DECLARED.setdefault(module, {})[name] = Rule("", called, float(value), prevents)
    return value


def thresholds_in(place: ModuleType, group: str) -> Iterator[Rule]:
    """The thresholds that a module, or the modules of a package, declare, as those of the question `group`."""
    below = pkgutil.walk_packages(getattr(place, "__path__", ()), f"{place.__name__}.")
    for path in [place.__name__, *sorted(item.name for item in below)]:
        importlib.import_module(path)
        for rule in _DECLARED.get(path, {}).values():
            yield Rule(group, rule.name, rule.value, rule.prevents)


def home_of(rule: Rule) -> tuple[str, str]:
    """Module and name of the variable that holds a threshold."""
    return next(
        (module, name) for module, own in _DECLARED.items() for name, item in own.items() if item.name == rule.name
    )
