"""Short names for notebooks (`from optimisation import identify`) that cost nothing until they are used."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Mapping
from types import ModuleType
from typing import Any


class LazyPackage(ModuleType):
    """A package that imports the home of a short name at its first use."""

    _homes: Mapping[str, str]

    def __getattr__(self, name: str) -> Any:
        """Return what `name` stands for; AttributeError where it stands for nothing."""
        home = self._homes.get(name)
        if home is None:
            raise AttributeError(f"module {self.__name__!r} has no attribute {name!r}")
        value = getattr(importlib.import_module(home), name)
        setattr(self, name, value)
        return value

    def __setattr__(self, name: str, value: Any) -> None:
        """Keep a short name a function although the import system sets the module of the same name.

        `identify` lives in `optimisation/fitting/identify.py`: whoever imports that file first would otherwise decide
        whether `from optimisation import identify` gives the function or the module.
        """
        if isinstance(value, ModuleType) and self._homes.get(name) == value.__name__:
            value = getattr(value, name)
        super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        """Return the names, the short ones included."""
        return sorted({*super().__dir__(), *self._homes})


def lend(package: str, homes: Mapping[str, str]) -> None:
    """Let `package` hand out each short name of {name: module that defines it}."""
    module = sys.modules[package]
    module.__dict__["_homes"] = homes
    module.__class__ = LazyPackage
