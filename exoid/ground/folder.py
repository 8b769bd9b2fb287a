"""Folders in which every file is one of a kind: commands, formats, checks, sections. Nothing is registered.

An app adds to a folder of the core by a folder of the same name: `exoid/apps/watch/commands` to
`exoid/workbench/commands`.
"""

from __future__ import annotations

import importlib
import pkgutil
from pathlib import Path
from types import ModuleType

APPS = "exoid.apps"


def names_in(package: ModuleType) -> tuple[str, ...]:
    """Names of the modules in a package, sorted; none is imported."""
    return tuple(sorted(module.name for module in pkgutil.iter_modules(package.__path__)))


def modules_in(package: ModuleType) -> dict[str, ModuleType]:
    """Modules of a package by name, sorted."""
    return {name: importlib.import_module(f"{package.__name__}.{name}") for name in names_in(package)}


def apps() -> tuple[str, ...]:
    """Names of the apps that are there, sorted; none is imported."""
    folder = Path(__file__).parents[1] / "apps"
    return tuple(sorted(path.parent.name for path in folder.glob("*/__init__.py")))


def with_apps(package: ModuleType) -> dict[str, str]:
    """Dotted names of the modules in a package of the core and in the folders that apps add to it, by name, sorted;
    none is imported.
    """
    kind = package.__name__.rpartition(".")[2]
    places = {f"{APPS}.{app}.{kind}": [str(Path(__file__).parents[1] / "apps" / app / kind)] for app in apps()}
    places |= {package.__name__: [*package.__path__]}
    found = {
        module.name: f"{place}.{module.name}"
        for place, folders in places.items()
        for module in pkgutil.iter_modules(folders)
    }
    return dict(sorted(found.items()))
