"""argparse that refuses like the rest of exoid: with a suggestion, and never by leaving the process."""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from typing import Any, NoReturn

from ground.errors import ExoidError
from ground.suggest import did_you_mean


class UsageError(ExoidError):
    """A command line that cannot be understood."""


class Parser(argparse.ArgumentParser):
    """Parser of one verb. Options may stand between recordings; they are never guessed from abbreviations."""

    def __init__(self, **settings: Any) -> None:
        settings.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(allow_abbrev=False, **settings)

    def error(self, message: str) -> NoReturn:
        """Raise UsageError instead of printing and leaving."""
        raise UsageError(message, where=self.prog, remedy=self._advice(message))

    def parse(self, arguments: Sequence[str]) -> argparse.Namespace:
        """Return the parsed `arguments`; raises UsageError."""
        self._refuse_unknown(arguments)
        return self.parse_intermixed_args(list(arguments))

    def _refuse_unknown(self, arguments: Sequence[str]) -> None:
        """Name an unknown option before argparse takes its value for a recording."""
        known = [name for action in self._actions for name in action.option_strings]
        for word in arguments:
            if word == "--":
                return
            name = word.split("=", 1)[0]
            if name.startswith("--") and name not in known:
                raise UsageError(
                    f"unknown option {name}",
                    where=self.prog,
                    remedy=did_you_mean(name, known) or f"{self.prog} --help lists the options",
                )

    def _advice(self, message: str) -> str:
        if "required: REC" in message and any("--verify" in a.option_strings for a in self._actions):
            return (
                "name the recordings to fit before --verify, which takes every file that follows it: "
                f"{self.prog} run1.csv run2.csv --verify run3.csv"
            )
        return f"{self.prog} --help shows how it is used"
