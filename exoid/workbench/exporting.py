"""The forms of export: the modules of the folder `export`, so that a new one is a new file."""

from __future__ import annotations

import importlib
from types import ModuleType

from exoid.ground.folder import names_in
from exoid.workbench import export


def formats() -> tuple[str, ...]:
    """Return the names of all formats, sorted; none is imported."""
    return names_in(export)


def usual_formats() -> tuple[str, ...]:
    """Return those that are written where none is asked for."""
    return tuple(name for name in formats() if not getattr(exporter(name), "ON_REQUEST", False))


def exporter(name: str) -> ModuleType:
    """Import one format."""
    return importlib.import_module(f"{export.__name__}.{name}")
