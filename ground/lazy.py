"""Short names for notebooks (`from exoid.optimisation import identify`, `model.torque(motion, numbers)`) that cost
nothing until they are used.
"""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Callable, Mapping
from functools import cached_property
from types import ModuleType
from typing import Any, Generic, TypeVar, cast

from exoid.ground.calling import no_such

Value = TypeVar("Value")
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


class _Lent:
    """A function of a module above that of a class, "module:function"; it is looked for at its first use."""

    def __init__(self, home: str) -> None:
        self._home = home

    def __set_name__(self, owner: type, name: str) -> None:
        self._owner, self._name = owner, name

    def _found(self) -> Callable[..., Any]:
        module, _, function = self._home.partition(":")
        return cast("Callable[..., Any]", getattr(importlib.import_module(module), function))

    def _exchanged(self, member: Any, instance: Any) -> Any:
        """Put `member` into the place of this one, and return what it is on `instance`."""
        setattr(self._owner, self._name, member)
        return getattr(self._owner if instance is None else instance, self._name)


class LentMethod(_Lent, Generic[Value]):
    """A method that a module above its class provides; it returns a Value.

    So the class imports nothing of what is computed from it, and pays for it at its first use alone.
    """

    def __get__(self, instance: Any, owner: type | None = None) -> Callable[..., Value]:
        return cast("Callable[..., Value]", self._exchanged(self._found(), instance))


class LentFunction(_Lent, Generic[Value]):
    """The same for what is called on the class, without an instance."""

    def __get__(self, instance: Any, owner: type | None = None) -> Callable[..., Value]:
        return cast("Callable[..., Value]", self._exchanged(staticmethod(self._found()), instance))


class LentProperty(_Lent, Generic[Value]):
    """The same for a property, which is computed once."""

    def __get__(self, instance: Any, owner: type | None = None) -> Value:
        member = cached_property(self._found())
        member.__set_name__(self._owner, self._name)
        return cast("Value", self._exchanged(member, instance))
