"""Folders in which every file is one of a kind: commands, formats, checks, sections. Nothing is registered."""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType


def names_in(package: ModuleType) -> tuple[str, ...]:
    """Return the names of the modules in a package, sorted; none is imported."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(package.__path__)))


def modules_in(package: ModuleType) -> dict[str, ModuleType]:
    """Return {name: module} of a package, sorted by name."""
    return {name: importlib.import_module(f"{package.__name__}.{name}") for name in names_in(package)}
