"""Torques as plain text, with brackets only where they are needed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from exoid.symbolic.language.tree import FUNCTIONS, OPERATORS, Node
from exoid.symbolic.language.walk import Spelling, lower

SUM, PRODUCT, SIGN, POWER, ATOM = range(5)


@dataclass(frozen=True)
class WrittenTerm:
    """A written subtree and how strongly its outermost operation binds."""

    text: str
    strength: int = ATOM


def _inside(piece: WrittenTerm, strength: int) -> str:
    return piece.text if piece.strength >= strength else f"({piece.text})"


def _infix(sign: str, strength: int, right: int) -> Callable[[WrittenTerm, WrittenTerm], WrittenTerm]:
    """Write an operation that binds with `strength` and wants at least `right` behind it."""

    def write(a: WrittenTerm, b: WrittenTerm) -> WrittenTerm:
        return WrittenTerm(f"{_inside(a, strength)}{sign}{_inside(b, right)}", strength)

    return write


def number_text(value: float) -> str:
    """Return the shortest text that reads back as `value`."""
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


def _call(word: str) -> Callable[..., WrittenTerm]:
    return lambda *arguments: WrittenTerm(f"{word}({', '.join(a.text for a in arguments)})")


TEXT = Spelling(
    number=lambda value: WrittenTerm(number_text(value)),
    name=WrittenTerm,
    negative=lambda a: WrittenTerm("-" + _inside(a, SIGN), SIGN),
    power=lambda base, exponent: WrittenTerm(f"{_inside(base, ATOM)}**{number_text(exponent)}", POWER),
    binary={
        "+": _infix(" + ", SUM, PRODUCT),
        "-": _infix(" - ", SUM, PRODUCT),
        "*": _infix(" * ", PRODUCT, SIGN),
        "/": _infix(" / ", PRODUCT, SIGN),
    },
    functions={word: _call(word) for word in (*FUNCTIONS, *OPERATORS)},
)


def to_text(node: Node) -> str:
    """Return the torque as plain text, with the fewest brackets; parsing it gives the same tree."""
    return str(lower(node, TEXT).text)
