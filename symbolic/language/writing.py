"""How a torque reads: the tables for LaTeX and for plain text, with brackets only where they are needed."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from symbolic.language.tree import FUNCTIONS, OPERATORS, Node
from symbolic.language.walk import Spelling, lower

SUM, PRODUCT, SIGN, POWER, ATOM = range(5)


@dataclass(frozen=True)
class WrittenTerm:
    """A written subtree and how strongly its outermost operation binds."""

    text: str
    strength: int = ATOM


def _inside(piece: WrittenTerm, strength: int, brackets: tuple[str, str]) -> str:
    return piece.text if piece.strength >= strength else brackets[0] + piece.text + brackets[1]


def _infix(
    sign: str, strength: int, right: int, brackets: tuple[str, str]
) -> Callable[[WrittenTerm, WrittenTerm], WrittenTerm]:
    """Write an operation that binds with `strength` and wants at least `right` behind it."""

    def write(a: WrittenTerm, b: WrittenTerm) -> WrittenTerm:
        return WrittenTerm(f"{_inside(a, strength, brackets)}{sign}{_inside(b, right, brackets)}", strength)

    return write


_ROUND = ("(", ")")
_TALL = (r"\left(", r"\right)")


def number_text(value: float) -> str:
    """Return the shortest text that reads back as `value`."""
    return repr(int(value)) if value == int(value) and abs(value) < 1e15 else repr(float(value))


def _call(word: str) -> Callable[..., WrittenTerm]:
    return lambda *arguments: WrittenTerm(f"{word}({', '.join(a.text for a in arguments)})")


TEXT = Spelling(
    number=lambda value: WrittenTerm(number_text(value)),
    name=WrittenTerm,
    negative=lambda a: WrittenTerm("-" + _inside(a, SIGN, _ROUND), SIGN),
    power=lambda base, exponent: WrittenTerm(f"{_inside(base, ATOM, _ROUND)}**{number_text(exponent)}", POWER),
    binary={
        "+": _infix(" + ", SUM, PRODUCT, _ROUND),
        "-": _infix(" - ", SUM, PRODUCT, _ROUND),
        "*": _infix(" * ", PRODUCT, SIGN, _ROUND),
        "/": _infix(" / ", PRODUCT, SIGN, _ROUND),
    },
    functions={word: _call(word) for word in (*FUNCTIONS, *OPERATORS)},
)

_GREEK = frozenset(
    (
        *("alpha", "beta", "gamma", "delta", "epsilon", "zeta", "eta", "theta", "kappa", "lambda", "mu", "nu"),
        *("xi", "rho", "sigma", "tau", "phi", "chi", "psi", "omega"),
        *("Gamma", "Delta", "Theta", "Lambda", "Sigma", "Phi", "Psi", "Omega"),
    )
)
_STATE = re.compile(r"(d{0,2})theta([12]?)")
_TORQUE = re.compile(r"tau_(rigid|model)([12]?)")


def latex_name(name: str) -> str:
    """Return a name of the language in LaTeX: dtheta1 -> \\dot{\\theta}_{1}, v_s -> v_{s}."""
    if state := _STATE.fullmatch(name):
        dots, index = state.groups()
        letter = {"": r"\theta", "d": r"\dot{\theta}", "dd": r"\ddot{\theta}"}[dots]
        return letter + (f"_{{{index}}}" if index else "")
    if torque := _TORQUE.fullmatch(name):
        kind, index = torque.groups()
        return rf"\tau_{{\mathrm{{{kind}}}{',' + index if index else ''}}}"
    if name == "pi":
        return r"\pi"
    stem, _, below = name.partition("_")
    if not below and (ending := re.fullmatch(r"([A-Za-z]+?)([0-9]+)", stem)):
        stem, below = ending.groups()
    letter = "\\" + stem if stem in _GREEK else stem if len(stem) == 1 else rf"\mathrm{{{stem}}}"
    index = below.replace("_", ",")
    if len(index) > 1:
        index = rf"\mathrm{{{index}}}"
    return letter + (f"_{{{index}}}" if index else "")


def _latex_number(value: float) -> str:
    mantissa, _, exponent = number_text(value).partition("e")
    return rf"{mantissa} \cdot 10^{{{int(exponent)}}}" if exponent else mantissa


def _latex_call(word: str) -> Callable[..., WrittenTerm]:
    named = word if word in ("sin", "cos", "tan", "exp", "log", "tanh", "max", "min") else ""
    head = "\\" + named if named else rf"\mathrm{{{word}}}"
    return lambda *arguments: WrittenTerm(rf"{head}\left({', '.join(a.text for a in arguments)}\right)")


def _latex_power(base: WrittenTerm, exponent: float) -> WrittenTerm:
    return WrittenTerm(f"{_inside(base, ATOM, _TALL)}^{{{number_text(exponent)}}}", POWER)


def _fraction(a: WrittenTerm, b: WrittenTerm) -> WrittenTerm:
    return WrittenTerm(rf"\frac{{{a.text}}}{{{b.text}}}", POWER)


def _juxtapose(a: WrittenTerm, b: WrittenTerm) -> WrittenTerm:
    right = _inside(b, POWER, _TALL)
    sign = r" \cdot " if right[0].isdigit() else r" \, "
    return WrittenTerm(_inside(a, PRODUCT, _TALL) + sign + right, PRODUCT)


_SPECIAL: dict[str, Any] = {
    "abs": lambda a: WrittenTerm(rf"\left|{a.text}\right|"),
    "sqrt": lambda a: WrittenTerm(rf"\sqrt{{{a.text}}}"),
}

LATEX = Spelling(
    number=lambda value: WrittenTerm(_latex_number(value), ATOM if "e" not in number_text(value) else POWER),
    name=lambda name: WrittenTerm(latex_name(name)),
    negative=lambda a: WrittenTerm("-" + _inside(a, SIGN, _TALL), SIGN),
    power=_latex_power,
    binary={
        "+": _infix(" + ", SUM, PRODUCT, _TALL),
        "-": _infix(" - ", SUM, PRODUCT, _TALL),
        "*": _juxtapose,
        "/": _fraction,
    },
    functions={word: _SPECIAL.get(word) or _latex_call(word) for word in (*FUNCTIONS, *OPERATORS)},
)


def to_latex(node: Node) -> str:
    """Return the torque in LaTeX (the part of it that matplotlib understands too)."""
    return str(lower(node, LATEX).text)


def to_text(node: Node) -> str:
    """Return the torque as plain text, with the fewest brackets; parsing it gives the same tree."""
    return str(lower(node, TEXT).text)
