"""Units as dimensions: "N·m·s/rad" becomes powers of m, kg, s, A and K.

The radian counts as 1, as in SI. Only coherent SI units are read, so that no factor is hidden in a unit: "deg", "mm" or
"rpm" are refused with the unit to use.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import lru_cache

from exoid.ground.errors import EffectError, ExpressionError
from exoid.ground.suggest import nearest
from exoid.symbolic.language.parser import parse
from exoid.symbolic.language.tree import Binary, Name, Node, Number

BASE = ("m", "kg", "s", "A", "K")
LONGEST = 60
"""Characters of a unit."""
DEEPEST = 8
"""Brackets of a unit."""


@dataclass(frozen=True)
class Dimension:
    """Powers of m, kg, s, A, K."""

    powers: tuple[float, ...] = (0.0,) * len(BASE)

    def __mul__(self, other: Dimension) -> Dimension:
        return Dimension(tuple(a + b for a, b in zip(self.powers, other.powers, strict=True)))

    def __truediv__(self, other: Dimension) -> Dimension:
        return self * other**-1

    def __pow__(self, exponent: float) -> Dimension:
        return Dimension(tuple(round(a * exponent, 6) + 0.0 for a in self.powers))

    def __str__(self) -> str:
        """Write it with N·m in front where a mass is in it once, else in base units."""
        rest = self
        parts: list[str] = []
        over: list[str] = []
        if self.powers[1] == 1:
            rest, parts = self / TORQUE, ["N·m"]
            if rest.powers[0] == -1:
                rest, parts = self / FORCE, ["N"]
        for name, power in zip(BASE, rest.powers, strict=True):
            if power:
                (parts if power > 0 else over).append(_power_text(name, abs(power)))
        above = "·".join(parts) or "1"
        return above + "".join(f"/{part}" for part in over)


def _power_text(name: str, power: float) -> str:
    if power == int(power):
        return name + ("" if power == 1 else str(int(power)).translate(_RAISED))
    return f"{name}^{power:g}"


_RAISED = str.maketrans("0123456789-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁻")
_LOWERED = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁻", "0123456789-")


def _of(**powers: int) -> Dimension:
    return Dimension(tuple(float(powers.get(name, 0)) for name in BASE))


NONE = _of()
LENGTH, TIME = _of(m=1), _of(s=1)
FORCE = _of(m=1, kg=1, s=-2)
TORQUE = FORCE * LENGTH

UNITS = {
    "1": NONE, "rad": NONE, "m": LENGTH, "kg": _of(kg=1), "s": TIME, "A": _of(A=1), "K": _of(K=1), "Hz": TIME**-1,
    "N": FORCE, "Nm": TORQUE, "Nms": TORQUE * TIME, "J": TORQUE, "W": TORQUE / TIME, "Pa": FORCE / LENGTH**2,
    "V": TORQUE / TIME / _of(A=1),
}  # fmt: skip
"""Words of the unit language."""

NOT_SI = {
    "deg": "rad", "°": "rad", "degree": "rad", "degrees": "rad", "turn": "rad", "rev": "rad", "rpm": "rad/s",
    "mm": "m", "cm": "m", "km": "m", "ms": "s", "us": "s", "µs": "s", "min": "s", "h": "s", "g": "kg", "t": "kg",
    "mN": "N", "kN": "N", "mNm": "N·m", "kNm": "N·m", "Nmm": "N·m", "mA": "A", "°C": "K", "degC": "K",
    "%": "1", "percent": "1", "-": "1",
}  # fmt: skip
"""Units with a factor in them, and what to use instead."""

def dimension(unit: str, where: str) -> Dimension:
    """Return the dimension of a unit text; EffectError at `where` for one that is missing or not SI."""
    try:
        return _dimension(str(unit).strip())
    except EffectError as error:
        raise EffectError(error.what, where=where, remedy=error.remedy) from error


@lru_cache(maxsize=512)
def _dimension(text: str) -> Dimension:
    if not text:
        raise EffectError("the unit is missing", remedy='give it, or "1" for a plain number')
    if len(text) > LONGEST:
        raise EffectError(f"a unit of {len(text)} characters", remedy=f"use at most {LONGEST}")
    if text in NOT_SI:
        raise _not_si(text)
    for word in re.findall("[A-Za-zµ°%]+", text):
        if word in NOT_SI:
            raise _not_si(word)
        if word not in UNITS:
            near = nearest(word, UNITS, 2)
            raise EffectError(
                f"unknown unit {word[:20]!r} in {text!r}",
                remedy=(f"did you mean {' or '.join(near)}? " if near else "") + "known: " + " ".join(UNITS),
            )
    refusal = EffectError(f"{text!r} is not a unit", remedy="write it like N·m·s/rad, kg·m² or 1/rad")
    if text.count("(") > DEEPEST:
        raise refusal
    for pattern, written in _AS_PRODUCTS:
        text = re.sub(pattern, written, text)
    try:
        found = _worth(parse(text.translate(_LOWERED), UNITS))
    except ExpressionError:
        found = None
    if found is None:
        raise refusal
    return found


_AS_PRODUCTS = (
    (r"([⁰¹²³⁴⁵⁶⁷⁸⁹⁻]+)", r"**\1"), (r"[·⋅]|(?<![0-9])\.(?![0-9])", "*"),
    (r"(?<=[A-Za-z0-9)])(\s*(?=\()|\s+(?=[A-Za-z1]))", "*"),
)  # fmt: skip
"""How what is usual in units is written in torques: raised powers, dots, and nothing at all for products."""


def _worth(node: Node) -> Dimension | None:
    """Return the dimension of a tree of units; None where it is more than a product."""
    if isinstance(node, Name):
        return UNITS[node.name]
    if isinstance(node, Number):
        return NONE if node.value == 1.0 else None
    if not isinstance(node, Binary) or (left := _worth(node.left)) is None:
        return None
    if node.operator == "**" and isinstance(node.right, Number):
        return left**node.right.value
    right = _worth(node.right)
    return None if right is None or node.operator in "+-" else left * right if node.operator == "*" else left / right


def _not_si(word: str) -> EffectError:
    return EffectError(
        f"the unit {word} has a factor in it; all numbers here are in SI units",
        remedy=f"use {NOT_SI[word]}, and convert bounds and values",
    )
