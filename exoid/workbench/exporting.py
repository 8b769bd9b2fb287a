"""The forms of export: the modules of the folders `export`, here and in apps, so that a new one is a new file."""

from __future__ import annotations

import importlib
from types import ModuleType

from exoid.ground.folder import with_apps
from exoid.workbench import export
from exoid.workbench.identified import ExportError


def formats() -> tuple[str, ...]:
    """Return the names of all formats, sorted; none is imported."""
    return tuple(with_apps(export))


def usual_formats() -> tuple[str, ...]:
    """Return those that are written where none is asked for."""
    return tuple(name for name in formats() if not getattr(exporter(name), "ON_REQUEST", False))


def exporter(name: str) -> ModuleType:
    """Import one format; ExportError where there is none of this name."""
    found = with_apps(export)
    if name not in found:
        raise ExportError(f"there is no format {name!r} here", remedy=f"there are {', '.join(found)}")
    return importlib.import_module(found[name])
