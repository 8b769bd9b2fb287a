"""Text from outside (names of files, models and columns), made harmless for where it will stand, and templates."""

from __future__ import annotations

import re
import unicodedata
from collections.abc import Mapping, Sequence
from typing import Any

_ACTING = frozenset(("Cc", "Cf", "Cs", "Zl", "Zp"))
"""Categories of characters that act instead of being seen: controls, direction marks, halves, line separators."""


EMPTY = (None, "", "–")
"""Cells that have nothing to say."""


def without_accents(text: str) -> str:
    """Letters of `text` without their accents: "Hüfte" is "Hufte"."""
    return "".join(c for c in unicodedata.normalize("NFD", text) if not unicodedata.combining(c))


def printable(text: str) -> str:
    """Return `text` with every control character spelt out (ESC is \\x1b), line feeds and tabs kept.

    A terminal obeys them: a file name could clear the screen, or write what looks like a message of ours.
    """
    if text.isascii() and text.replace("\n", "").isprintable():
        return text
    seen = (c in "\n\t" or unicodedata.category(c) not in _ACTING for c in text)
    return "".join(c if keep else ascii(c)[1:-1] for c, keep in zip(text, seen, strict=True))


def digits(value: float, count: int = 3) -> str:
    """A number with `count` significant digits; without an exponent below a million (1230, not 1.23e+03)."""
    return f"{float(f'{value:.{count}g}'):g}"


def in_comment(text: str) -> str:
    """Return `text` as one line that cannot end a comment or a docstring of C, Python or XML.

    No backslash (before a line end it joins lines, and Python reads it in a docstring), no trigraph, no quote.
    """
    line = " ".join(printable(text).split()).replace("\\", "|").replace('"', "'")
    return re.sub(r"(?<=[?])(?=[?])|(?<=\*)(?=/)|(?<=/)(?=\*)|(?<=-)(?=-)", " ", line)


def filled(text: str, values: Mapping[str, Any]) -> str:
    """Return a template with a value for every @KEY@, one key after the other: a value may hold those that follow."""
    for key, value in values.items():
        text = text.replace(f"@{key}@", str(value))
    return text


def without_empty(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> tuple[list[str], list[list[Any]]]:
    """Return a table without the columns in which no row says anything; a table without rows keeps them all."""
    kept = [i for i in range(len(head)) if not rows or any(row[i] not in EMPTY for row in rows)]
    return [head[i] for i in kept], [[row[i] for i in kept] for row in rows]
