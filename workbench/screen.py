"""What a person reads in the terminal: sentences and tables that survive a plain pipe."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any

from symbolic.quantity import JOINTS

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
        if style and sys.stdout.isatty():
            from rich.text import Text

            _console().print(Text(text, style=STYLES[style]))
        else:
            sys.stdout.write(text + "\n")

    def table(self, title: str, head: Sequence[str], rows: Sequence[Sequence[Any]], note: str = "") -> None:
        """Write a table, numbers set to the right; in a pipe nothing is cut off."""
        if self.silent:
            return
        from rich import box
        from rich.table import Table
        from rich.text import Text

        colours = sys.stdout.isatty()
        table = Table(title=title or None, title_justify="left", title_style="bold", caption=note or None,
                      caption_justify="left", box=box.ROUNDED if colours else box.SIMPLE_HEAD, safe_box=True,
                      pad_edge=colours)  # fmt: skip
        for index, name in enumerate(head):
            numeric = bool(rows) and all(_is_number(row[index]) for row in rows)
            # A sentence may wrap, a number or an identifier may not.
            longest = max((len(str(row[index])) for row in rows), default=0)
            table.add_column(name, justify="right" if numeric else "left", no_wrap=longest <= 24, overflow="fold")
        for row in rows:
            table.add_row(*(Text(str(cell)) for cell in row))
        if colours:
            _console().print(table)
            return
        plain = _console()
        with plain.capture() as captured:
            plain.print(table)
        lines = (line.rstrip() for line in captured.get().splitlines())
        sys.stdout.write("\n".join(lines).strip("\n") + "\n")


def warn(text: str) -> None:
    """Write `text` to stderr; --quiet does not hide it."""
    sys.stderr.write(f"exoid: {text}\n")


def per_joint(values: Iterable[float], unit: str = "N·m") -> str:
    """Return "hip 0.71, knee 0.53 N·m"."""
    return ", ".join(f"{joint} {value:.3g}" for joint, value in zip(JOINTS, values, strict=True)) + f" {unit}"


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
    return Console(highlight=False, width=400, color_system=None, force_terminal=False)
