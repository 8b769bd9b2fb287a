"""A torque text cut into words, and the refusal that points at the offending ones.

Every limit is checked here, before anything is parsed: how long the text is, which characters it has,
whether its numbers are finite.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from exoid.ground.errors import ExpressionError
from exoid.symbolic.language.tree import Span

LONGEST_TEXT = 2000
LONGEST_WORD = 40
MOST_TOKENS = 600

_TOKEN = re.compile(
    r"(?P<number>(?:[0-9]+(?:\.[0-9]*)?|\.[0-9]+)(?:[eE][+-]?[0-9]+)?)"
    r"|(?P<name>(?:d{0,2}theta|tau_rigid|tau_model)\[[A-Za-z][A-Za-z0-9_]*\]|[A-Za-z][A-Za-z0-9_]*)"
    r"|(?P<mark>\*\*|[-+*/^(),])"
    r"|(?P<blank>[ \t]+)"
)
_WINDOW = 60


@dataclass(frozen=True)
class Token:
    """A word of the text: `kind` is "number", "name", "mark" or "end"."""

    kind: str
    text: str
    span: Span
    value: float = 0.0


def tokenize(text: str) -> list[Token]:
    """Cut `text` into tokens, closed by an "end" token; ExpressionError for anything that is not in the
    language.
    """
    if not isinstance(text, str):
        what = f"a torque must be a text, not {type(text).__name__}"
        raise ExpressionError(what, remedy='write it in quotes: "c * dtheta"')
    if len(text) > LONGEST_TEXT:
        raise refusal(
            f"the torque text has {len(text)} characters, {LONGEST_TEXT} are allowed",
            text,
            (LONGEST_TEXT, LONGEST_TEXT + 1),
            "split it into several effects",
        )
    tokens: list[Token] = []
    at = 0
    while at < len(text):
        match = _TOKEN.match(text, at)
        if match is None:
            raise _stranger(text, at)
        if match.lastgroup != "blank":
            tokens.append(_token(text, match))
        if len(tokens) > MOST_TOKENS:
            raise refusal(
                f"more than {MOST_TOKENS} words and signs",
                text,
                match.span(),
                "split it into several effects",
            )
        at = match.end()
    return [*tokens, Token("end", "", (len(text), len(text) + 1))]


def refusal(what: str, text: str, span: Span, remedy: str) -> ExpressionError:
    """Return the error that says `what` is wrong with `text`, with carets under its characters `span`."""
    first = max(0, min(span[0], len(text)) - _WINDOW)
    shown = text[first : span[0] + _WINDOW]
    # One character of width one for each character of the text, or the carets would miss.
    plain = "".join(c if " " <= c <= "~" else "?" for c in shown)
    before, after = "..." if first else "", "..." if first + len(shown) < len(text) else ""
    carets = "^" * max(1, min(span[1] - span[0], first + len(shown) - span[0]))
    pointer = " " * (len(before) + span[0] - first) + carets
    return ExpressionError(what, where=f"{before}{plain}{after}\n{pointer}", remedy=remedy)


def _token(text: str, match: re.Match[str]) -> Token:
    """Turn a match into a token; refuses numbers that are not finite and words that are too long."""
    kind, word, span = str(match.lastgroup), match.group(), match.span()
    if kind == "mark":
        return Token(kind, "**" if word == "^" else word, span)
    if len(word) > LONGEST_WORD:
        raise refusal(f"a {kind} of {len(word)} characters", text, span, f"use at most {LONGEST_WORD} characters")
    if kind == "name":
        return Token(kind, word, span)
    value = float(word)
    lost = value == 0.0 and any(c in "123456789" for c in re.split("[eE]", word)[0])
    if not math.isfinite(value) or lost:
        raise refusal(
            f"{word} is too {'small' if lost else 'large'} for a number",
            text,
            span,
            "use SI units and ordinary magnitudes",
        )
    return Token(kind, word, span, value)


def _stranger(text: str, at: int) -> ExpressionError:
    """Return the refusal of the character at position `at`."""
    character = text[at]
    label = f"{character!r}" if " " <= character <= "~" else f"U+{ord(character):04X}"
    if character == "_":
        remedy = "a name begins with a letter"
    elif character in "'\"":
        remedy = "there are no texts inside a torque text, only numbers, names and functions"
    elif character in "\r\n":
        remedy = "write the torque on one line"
    elif character in "[]{}":
        remedy = "use round brackets"
    elif character == ".":
        remedy = "a point belongs into a number; functions have no module before them, as in sin(theta)"
    else:
        remedy = "use ASCII letters, digits, + - * / ** ( ) and commas"
    return refusal(f"the character {label} is not allowed", text, (at, at + 1), remedy)
