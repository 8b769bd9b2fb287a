"""Calls as people write them: other words for a parameter are understood, and a call that cannot be is refused with
what is meant, as an ExoidError.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable, Iterable, Mapping
from typing import TYPE_CHECKING, Any, ClassVar, TypeVar, cast

from exoid.ground.errors import ExoidError
from exoid.ground.suggest import did_you_mean

Called = TypeVar("Called", bound=Callable[..., Any])


class CallError(ExoidError, TypeError):
    """A call with a parameter that there is not, or without one that it needs."""


class NoSuchName(ExoidError, AttributeError):
    """A name that a result, a model or a package does not have."""


def no_such(owner: str, name: str, known: Iterable[str], instead: str = "") -> AttributeError:
    """Return the error for a name that `owner` does not have; what Python itself asks for needs no remedy."""
    if name.startswith("_"):
        return AttributeError(f"{owner} has no attribute {name!r}")
    public = sorted(one for one in known if not one.startswith("_"))
    remedy = instead or did_you_mean(name, public) or f"there are {', '.join(public)}"
    return NoSuchName(f"{owner} has no attribute {name!r}", remedy=remedy)


class Telling:
    """A class that says what it has where it is asked for what it has not; `INSTEAD` maps words to what to write."""

    INSTEAD: ClassVar[Mapping[str, str]] = {}

    if not TYPE_CHECKING:

        def __getattr__(self, name: str) -> Any:
            raise no_such(f"a {type(self).__name__}", name, dir(type(self)), self.INSTEAD.get(name, ""))


def understood(also: dict[str, str] | None = None) -> Callable[[Called], Called]:
    """Let a function or a class take the words in `also`, {word: parameter}, for its parameters as well, and refuse
    calls that it cannot take with its signature and what was probably meant (CallError).
    """
    words = dict(also or {})

    def made(called: Called) -> Called:
        if isinstance(called, type):
            called.__init__ = _taking(called.__init__, called, words)  # type: ignore[misc]
            return called
        return cast("Called", _taking(called, called, words))

    return made


def _taking(does: Any, called: Any, words: dict[str, str]) -> Any:
    @functools.wraps(does)
    def taken(*given: Any, **named: Any) -> Any:
        for word in words.keys() & named.keys():
            if words[word] in named:
                raise CallError(f"{called.__name__} is given {word} and {words[word]}", remedy="give one of them")
            named[words[word]] = named.pop(word)
        try:
            return does(*given, **named)
        except TypeError as error:
            refusal = None if isinstance(error, ExoidError) else _unbound(called, given, named)
            if refusal is None:
                raise
            raise refusal from None

    return taken


def _unbound(called: Any, given: tuple[Any, ...], named: dict[str, Any]) -> CallError | None:
    """Return what is wrong with the arguments; None where they fit, and the error is another one."""
    signature = inspect.signature(called)
    try:
        signature.bind(*(given[1:] if isinstance(called, type) else given), **named)
    except TypeError as error:
        wrong = [name for name in named if name not in signature.parameters]
        hint = next((hint for name in wrong if (hint := did_you_mean(name, signature.parameters))), "")
        shown = ", ".join(
            name if one.default is one.empty else f"{name}=..." for name, one in signature.parameters.items()
        )
        return CallError(
            f"{called.__name__} cannot be called like this: {error}", remedy=hint or f"{called.__name__}({shown})"
        )
    return None
