"""Short names for notebooks (`from optimisation import identify`, `model.torque(motion, numbers)`) that cost nothing
until they are used.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import itertools
import sys
from collections.abc import Callable, Collection, Mapping
from functools import cached_property
from types import ModuleType
from typing import Any, TypeVar

Owner = TypeVar("Owner", bound=type)


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


def lend(package: str) -> list[str]:
    """Let `package` hand out the short names that its own file imports for type checkers; return all of them.

    What stands below `if TYPE_CHECKING:` is so the one place that says which names there are and where they live. A
    star takes all names of another package that lends.
    """
    module = sys.modules[package]
    blocks = (block.body for block in ast.parse(inspect.getsource(module)).body if isinstance(block, ast.If))
    homes: dict[str, str] = {}
    for line in itertools.chain.from_iterable(blocks):
        if isinstance(line, ast.ImportFrom) and line.module:
            star = line.names[0].name == "*"
            lent = importlib.import_module(line.module).__dict__["_homes"] if star else {}
            homes |= lent or {name.name: line.module for name in line.names}
    module.__dict__["_homes"] = homes
    module.__class__ = LazyPackage
    return list(homes)


_METHODS: dict[str, Mapping[str, Any]] = {}
"""What a class takes, {name: method or property}, by the full name of the class."""


def lend_methods(owner: str, homes: Mapping[str, str], properties: Collection[str] = ()) -> None:
    """Let the class `owner` ("package.module.Class") have functions of modules above its own as methods.

    `homes` is {method: "module:function"}; the object is the function's first argument, and the only one of
    `properties`, which are computed once. Only a package's `__init__` lends, so that the class itself imports nothing
    of what is computed from it.
    """
    made = {name: _method(name, *home.split(":")) for name, home in homes.items()}
    _METHODS[owner] = {name: cached_property(made[name]) if name in properties else made[name] for name in made}


def takes_methods(owner: Owner) -> Owner:
    """Give a class the methods that were lent to it: a decorator."""
    for name, member in _METHODS.get(f"{owner.__module__}.{owner.__qualname__}", {}).items():
        setattr(owner, name, member)
        if isinstance(member, cached_property):
            member.__set_name__(owner, name)
    return owner


def _method(name: str, module: str, function: str) -> Callable[..., Any]:
    def method(self: Any, *arguments: Any, **named: Any) -> Any:
        return getattr(importlib.import_module(module), function)(self, *arguments, **named)

    method.__name__ = name
    method.__doc__ = f"Return `{module}.{function}` of this object."
    return method
