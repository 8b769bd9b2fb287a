"""The forms of export: the modules of the folder `export`, so that a new one is a new file."""

from __future__ import annotations

import importlib
import pkgutil
from types import ModuleType

from workbench import export


def formats() -> tuple[str, ...]:
    """Return the names of all formats, sorted; none is imported."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(export.__path__)))


def exporter(name: str) -> ModuleType:
    """Import one format."""
    return importlib.import_module(f"{export.__name__}.{name}")
