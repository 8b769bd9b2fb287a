"""Text that a person reads in the terminal: sentences and tables that survive a plain pipe."""

from __future__ import annotations

import argparse
import os
import shutil
import sys
import textwrap
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from exoid.ground.text import printable, without_empty
from exoid.workbench.terminal.encoding import ascii_text, spells

BLOCKS = " ▏▎▍▌▋▊▉█"
STYLES = {
    "good": "bold green",
    "bad": "bold red",
    "warn": "bold yellow",
    "head": "bold",
    "faint": "dim",
    "": "",
}


@dataclass(frozen=True)
class Screen:
    """Standard output for people; `silent` with --quiet, and with `--json -`, when programs read it."""

    silent: bool = False

    @classmethod
    def of(cls, args: argparse.Namespace) -> Screen:
        """Return the screen that `args` ask for."""
        return cls(silent=args.quiet or args.json == "-")

    def say(self, text: str = "", style: str = "") -> None:
        """Write `text` as a line, in a style of `STYLES` when the terminal has colours."""
        if self.silent:
            return
        text = printable(text)
        if sys.stdout.isatty():
            from rich.text import Text

            _console().print(Text(text, style=STYLES[style]))
            return
        for line in (text if spells(sys.stdout) else ascii_text(text)).split("\n"):
            sys.stdout.write(folded(line) + "\n")

    def table(self, title: str, head: Sequence[str], rows: Sequence[Sequence[Any]], note: str = "") -> None:
        """Write a table, numbers set to the right; sentences fold, nothing is cut off."""
        if self.silent:
            return
        title, note, head = printable(title), printable(note), [printable(name) for name in head]
        head, rows = without_empty(
            head, [[printable(str(cell)) if isinstance(cell, str) else cell for cell in row] for row in rows]
        )
        from rich import box
        from rich.table import Table
        from rich.text import Text

        colours = sys.stdout.isatty()
        spelt = spells(sys.stdout)
        lines = box.ASCII2 if not spelt else box.ROUNDED if colours else box.SIMPLE_HEAD
        table = Table(title=title or None, title_justify="left", title_style="bold", caption=note or None,
                      caption_justify="left", box=lines, pad_edge=colours or not spelt)  # fmt: skip
        for index, name in enumerate(head):
            numeric = bool(rows) and all(_is_number(row[index]) for row in rows)
            # A sentence and a head may wrap, a number or an identifier may not, nor a word of the head.
            name, cells = (name if spelt else ascii_text(name)), (str(row[index]) for row in rows)
            longest = max((len(cell if spelt else ascii_text(cell)) for cell in cells), default=0)
            word = max((len(part) for part in name.split()), default=0)
            table.add_column(name, justify="right" if numeric else "left", overflow="fold",
                             min_width=max(word, longest if longest <= 24 else 0))  # fmt: skip
        for row in rows:
            # Spelt out before the table is laid out: "N*m" is as wide as "N·m", "theta" is not as wide as "θ".
            table.add_row(*(Text(str(cell) if spelt else ascii_text(str(cell))) for cell in row))
        if colours:
            _console().print(table)
            return
        pipe = _console()
        with pipe.capture() as captured:
            pipe.print(table)
        lines = (line.rstrip() for line in captured.get().splitlines())
        sys.stdout.write("\n".join(lines).strip("\n") + "\n")


def width() -> int:
    """Return the columns of the terminal; of a pipe, COLUMNS where it is set to a number above 20, else 80."""
    if sys.stdout.isatty():
        return shutil.get_terminal_size().columns
    asked = os.environ.get("COLUMNS", "")
    return int(asked) if asked.isdecimal() and int(asked) > 20 else 80


def folded(line: str) -> str:
    """Return a line for a pipe, folded at spaces under its own indent; a long word or path stays whole."""
    inner = line.lstrip(" ")
    indent = " " * (len(line) - len(inner))
    if len(line) <= width() or not inner:
        return line
    return textwrap.fill(
        inner, width(), initial_indent=indent, subsequent_indent=indent + "  ", break_long_words=False,
        break_on_hyphens=False, replace_whitespace=False, drop_whitespace=True,
    )  # fmt: skip


def warn(text: str) -> None:
    """Write `text` to stderr; --quiet does not hide it."""
    sys.stderr.write(f"exoid: {printable(text)}\n")


def bar(share: float, width: int = 24) -> str:
    """Return a bar of `width` characters filled to `share` (0..1), in eighths of a character."""
    eighths = round(max(0.0, min(1.0, share)) * width * 8)
    return BLOCKS[8] * (eighths // 8) + (BLOCKS[eighths % 8] if eighths % 8 else "")


def _is_number(cell: Any) -> bool:
    text = str(cell).strip().rstrip("%").strip()
    try:
        float(text)
    except ValueError:
        return text in ("", "-", "–")
    return True


def _console() -> Any:
    from rich.console import Console

    if sys.stdout.isatty():
        return Console(highlight=False)
    return Console(highlight=False, width=width(), color_system=None, force_terminal=False)
