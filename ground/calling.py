"""Calls as people write them: other words for a parameter are understood, and a call that cannot be is refused with
what is meant, as an ExoidError.
"""

from __future__ import annotations

import functools
import inspect
from collections.abc import Callable
from typing import Any, TypeVar

from exoid.ground.errors import ExoidError
from exoid.ground.suggest import did_you_mean

Called = TypeVar("Called", bound=Callable[..., Any])


class CallError(ExoidError, TypeError):
    """A call with a parameter that there is not, or without one that it needs."""


def understood(also: dict[str, str] | None = None) -> Callable[[Called], Called]:
    """Let a function or a class take the words in `also`, {word: parameter}, for its parameters as well, and refuse
    calls that it cannot take with its signature and what was probably meant (CallError).
    """
    words = dict(also or {})

    def made(called: Called) -> Called:
        if isinstance(called, type):
            called.__init__ = _taking(called.__init__, called, words)  # type: ignore[misc]
            return called
        return _taking(called, called, words)

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
