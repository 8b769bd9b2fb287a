"""argparse that refuses like the rest of exoid: with a suggestion, and never by leaving the process."""

from __future__ import annotations

import argparse
import itertools
import sys
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NoReturn

from exoid.ground.errors import ExoidError
from exoid.ground.suggest import did_you_mean

HELP = ("--help", "--help-all")


class UsageError(ExoidError):
    """A command line that cannot be understood."""


@dataclass(frozen=True)
class Seldom:
    """A parser, or a group of its options, to which options are added that --help-all shows and --help does not."""

    group: argparse._ActionsContainer

    def add_argument(self, *names: str, **words: Any) -> argparse.Action:
        """Add an option, as argparse does."""
        action = self.group.add_argument(*names, **words)
        action.seldom = True  # type: ignore[attr-defined]
        return action


class Parser(argparse.ArgumentParser):
    """Parser of one verb. Options may stand between recordings; they are never guessed from abbreviations."""

    def __init__(self, **settings: Any) -> None:
        settings.setdefault("formatter_class", argparse.RawDescriptionHelpFormatter)
        super().__init__(allow_abbrev=False, add_help=False, **settings)
        # `parse` answers them: argparse would do so in the middle of its work, without the recordings.
        flag: dict[str, Any] = {"action": "store_true", "default": argparse.SUPPRESS}
        Seldom(self).add_argument("-h", "--help", help="show the everyday options and leave", **flag)
        Seldom(self).add_argument("--help-all", help="show every option and leave", **flag)

    def error(self, message: str) -> NoReturn:
        """Raise UsageError instead of printing and leaving."""
        raise UsageError(message, where=self.prog, remedy=self._advice(message))

    def parse(self, arguments: Sequence[str]) -> argparse.Namespace:
        """Return the parsed `arguments`; raises UsageError, and SystemExit after help was asked for and shown."""
        asked = set(itertools.takewhile(lambda word: word != "--", arguments)) & {*HELP, "-h"}
        if asked:
            sys.stdout.write(self.format_help() if "--help-all" in asked else self.everyday_help())
            self.exit()
        self._refuse_unknown(arguments)
        return self.parse_intermixed_args(list(arguments))

    def everyday_help(self) -> str:
        """Return help on what must be given and on the options of every day; all of them: `format_help`."""
        seldom = [action for action in self._actions if getattr(action, "seldom", False)]
        formatter = self._get_formatter()
        formatter.add_usage(None, [action for action in self._actions if action.required], [])
        formatter.add_text(self.description)
        for group in self._action_groups:
            formatter.start_section(group.title)
            formatter.add_arguments([action for action in group._group_actions if action not in seldom])
            formatter.end_section()
        names = ", ".join(action.option_strings[-1] for action in seldom[len(HELP) :])
        text = f"{self.prog} --help-all explains {names} as well"
        formatter.add_text("\n".join(textwrap.wrap(text, 78, break_on_hyphens=False)))
        return formatter.format_help()

    def _refuse_unknown(self, arguments: Sequence[str]) -> None:
        """Name an unknown option before argparse takes its value for a recording."""
        known = [name for action in self._actions for name in action.option_strings]
        for word in arguments:
            if word == "--":
                return
            name = word.split("=", 1)[0]
            if name.startswith("--") and name not in known:
                remedy = did_you_mean(name, known) or f"{self.prog} --help lists the options"
                raise UsageError(f"unknown option {name}", where=self.prog, remedy=remedy)

    def _advice(self, message: str) -> str:
        if "required: REC" in message and any("--verify" in a.option_strings for a in self._actions):
            return (
                "name the recordings to fit before --verify, which takes every file that follows it: "
                f"{self.prog} run1.csv run2.csv --verify run3.csv"
            )
        return f"{self.prog} --help shows how it is used"
