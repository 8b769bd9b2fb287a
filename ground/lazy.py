"""Short names for notebooks (`from exoid.optimisation import identify`) that cost nothing until they are used."""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Mapping
from types import ModuleType
from typing import Any

from exoid.ground.calling import no_such

HOUSE = __name__.partition(".")[0]
"""The one name under which everything is imported: exoid."""


class LazyPackage(ModuleType):
    """A package that imports the home of a short name at its first use."""

    _homes: Mapping[str, str]

    def __getattr__(self, name: str) -> Any:
        """Return what `name` stands for; AttributeError where it stands for nothing."""
        home = self._homes.get(name)
        if home is None:
            raise no_such(f"module {self.__name__!r}", name, self._homes)
        value = getattr(importlib.import_module(home), name)
        setattr(self, name, value)
        return value

    def __setattr__(self, name: str, value: Any) -> None:
        """Keep a short name a function although the import system sets the module of the same name.

        `identify` lives in `optimisation/fitting/identify.py`: whoever imports that file first would otherwise decide
        whether `from exoid.optimisation import identify` gives the function or the module.
        """
        if isinstance(value, ModuleType) and self._homes.get(name) == value.__name__:
            value = getattr(value, name)
        super().__setattr__(name, value)

    def __dir__(self) -> list[str]:
        """Return the names, the short ones included."""
        return sorted({*super().__dir__(), *self._homes})


def only_inside(package: str) -> None:
    """Raise ImportError where a package of exoid is imported by itself, as one can where its folder is on the path.

    Its modules would be loaded a second time, and a Model of the one is no Model of the other.
    """
    if package.partition(".")[0] != HOUSE:
        raise ImportError(
            f"{package!r} is a part of {HOUSE} and cannot be imported by itself\n"
            f"  what to do: write `from {HOUSE}.{package} import ...` instead of `from {package} import ...`",
            name=package,
        )


_LENT = re.compile(r"^    from (\S+) import (\w+|\*)", re.MULTILINE)
"""A line below `if TYPE_CHECKING:`."""


def lend(package: str) -> list[str]:
    """Let `package` hand out the short names that its own file imports for type checkers; return all of them.

    What stands below `if TYPE_CHECKING:` is so the one place that says which names there are and where they live. A
    star takes all names of another package that lends.
    """
    only_inside(package)
    module = sys.modules[package]
    homes: dict[str, str] = {}
    for home, name in _LENT.findall(module.__loader__.get_source(package)):  # type: ignore[union-attr]
        homes |= importlib.import_module(home).__dict__["_homes"] if name == "*" else {name: home}
    module.__dict__["_homes"] = homes
    module.__class__ = LazyPackage
    return list(homes)
