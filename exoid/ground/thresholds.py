"""Numbers that decide, declared where they are used, each with what would be concluded without it; one table of all.

    LEAST_SHARE: Threshold = 0.01
    \"""share of the error that is worth a line: what curves follow by chance\"""
"""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise
from types import ModuleType

Threshold = float
"""Annotation of a number that decides: what it is, and what it prevents, stands below it."""


@dataclass(frozen=True)
class Rule:
    """One threshold as a table shows it: the question it belongs to, its name, value, and what it prevents; the
    variable that holds it is that of its name in `module`.
    """

    group: str
    name: str
    value: float
    prevents: str
    module: str = ""


def thresholds_in(place: ModuleType, group: str) -> Iterator[Rule]:
    """The thresholds that a module, or the modules of a package, declare, as those of the question `group`."""
    below = pkgutil.walk_packages(getattr(place, "__path__", ()), f"{place.__name__}.")
    for path in [place.__name__, *sorted(item.name for item in below)]:
        module = importlib.import_module(path)
        for name, prevents in _declared(module):
            yield Rule(group, f"{path.rpartition('.')[2]}.{name}", float(getattr(module, name)), prevents, path)


def _declared(module: ModuleType) -> Iterator[tuple[str, str]]:
    """Names of the thresholds of a module, and what stands below each."""
    if "Threshold" not in getattr(module, "__annotations__", {}).values():
        return
    for line, below in pairwise(ast.parse(inspect.getsource(module)).body):
        match line, below:
            case (
                ast.AnnAssign(target=ast.Name(id=name), annotation=ast.Name(id="Threshold")),
                ast.Expr(value=ast.Constant(value=str(text))),
            ):
                yield name, " ".join(text.split())
