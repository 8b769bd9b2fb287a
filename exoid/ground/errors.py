"""Errors written for the person who can do something about them: what, where, what to do."""

from __future__ import annotations

import contextlib
from collections.abc import Iterator

from exoid.ground.text import printable


class ExoidError(Exception):
    """Something the user can mend. The command line prints it and exits with status 2, without a traceback.

    `what` is one sentence, `where` names file, row, column, key or offending text, `remedy` says what to do.
    """

    def __init__(self, what: str, *, where: str = "", remedy: str = "") -> None:
        self.what = what
        self.where = where
        self.remedy = remedy
        super().__init__(str(self))

    def __str__(self) -> str:
        place = f"{self.where}: " if self.where else ""
        advice = f"\n  what to do: {self.remedy}" if self.remedy else ""
        return f"{place}{self.what}{advice}"


    def about(self, name: str, place: object) -> ExoidError:
        """Return the same error about a file called `name`, which lies at `place`."""
        what, where, remedy = (text.replace(str(place), name) for text in (self.what, self.where, self.remedy))
        return type(self)(what, where=where, remedy=remedy)


class ExpressionError(ExoidError):
    """A torque text that the grammar refuses; `where` carries the text with a caret under the offence."""


class EffectError(ExoidError):
    """An effect that does not exist, does not exist on that joint, or contradicts its own declaration."""


class ModelFileError(ExoidError):
    """A model file with a wrong, missing or unknown key."""


class RecordingError(ExoidError):
    """A recording that cannot be used as it is."""

    kind = ""
    """The kind of a file that is no recording at all and can be left out of a folder; "" for any other."""


NO_NUMBERS = "without numbers"


class NoNumbersError(RecordingError):
    """A file in which no numbers stand."""

    kind = NO_NUMBERS


class StandingError(RecordingError):
    """A recording of a machine that stands still."""

    kind = "without motion"


class NoChannelsError(RecordingError):
    """A table in which neither an angle nor a torque is found."""

    kind = "without angles and torques"


class NotEnoughDataError(ExoidError):
    """Recordings that are readable but cannot carry the question asked of them."""


@contextlib.contextmanager
def refused(
    error: type[ExoidError],
    what: str,
    where: object,
    remedy: str = "",
    causes: tuple[type[BaseException], ...] = (OSError,),
) -> Iterator[None]:
    """Raise `error` for what goes wrong inside by one of `causes`; "{}" in `what` is what it says.

    What is an ExoidError already passes as it is.
    """
    try:
        yield
    except ExoidError:
        raise
    except causes as problem:
        said = str(getattr(problem, "strerror", None) or problem)[:300]
        raise error(what.replace("{}", said), where=str(where), remedy=remedy) from problem


def error_json(error: ExoidError) -> dict[str, str]:
    """An error as what, where and what to do."""
    return {"what": printable(error.what), "where": printable(error.where), "remedy": printable(error.remedy)}


def internal(error: Exception) -> ExoidError:
    """Answer of a page to a mistake of exoid's own; whoever started it sees the traceback in the terminal."""
    what = f"internal error in exoid ({type(error).__name__})"
    return ExoidError(what, remedy="please report what the terminal says")
