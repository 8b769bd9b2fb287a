"""Units that people write: what one of them is in SI, and the dimension of a product of SI units.

Recordings may be in any of `QUANTITIES`. Of the numbers of a model "N·m·s/rad" becomes powers of m, kg, s, A and K; the
radian counts as 1, as in SI. Only coherent SI units are read there, so that no factor is hidden in a unit: "deg", "mm"
or "rpm" are refused with the unit to use.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from types import MappingProxyType

from exoid.ground.errors import EffectError, ExpressionError
from exoid.ground.suggest import nearest
from exoid.ground.text import without_accents
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

DEGREE = math.pi / 180.0
QUANTITIES: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "t": {"s": 1.0, "sec": 1.0, "secs": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3,
              "millis": 1e-3, "milliseconds": 1e-3, "us": 1e-6, "usec": 1e-6, "micros": 1e-6, "microseconds": 1e-6,
              "ns": 1e-9, "nsec": 1e-9, "nanoseconds": 1e-9, "min": 60.0},
        "q": {"rad": 1.0, "radian": 1.0, "radians": 1.0, "rads": 1.0, "mrad": 1e-3, "deg": DEGREE, "degree": DEGREE,
              "degrees": DEGREE, "°": DEGREE, "rev": 2 * math.pi, "revs": 2 * math.pi, "turn": 2 * math.pi,
              "turns": 2 * math.pi},
        "dq": {"rad/s": 1.0, "rads": 1.0, "rad/sec": 1.0, "rads-1": 1.0, "mrad/s": 1e-3, "deg/s": DEGREE,
               "deg/sec": DEGREE, "degs": DEGREE, "degs-1": DEGREE, "°/s": DEGREE, "dps": DEGREE,
               "rpm": math.pi / 30.0, "rev/s": 2 * math.pi, "turn/s": 2 * math.pi, "turns/s": 2 * math.pi},
        "ddq": {"rad/s2": 1.0, "rads2": 1.0, "rads-2": 1.0, "rad/s/s": 1.0, "mrad/s2": 1e-3, "deg/s2": DEGREE,
                "degs-2": DEGREE, "°/s2": DEGREE, "deg/s/s": DEGREE},
        "tau": {"nm": 1.0, "mnm": 1e-3, "knm": 1e3, "meganm": 1e6, "ncm": 1e-2, "nmm": 1e-3,
                "lbfft": 1.3558179483314004, "ftlb": 1.3558179483314004, "lbfin": 0.1129848290276167,
                "inlb": 0.1129848290276167},
        "f": {"n": 1.0, "mn": 1e-3, "kn": 1e3, "megan": 1e6, "lbf": 4.4482216152605},
        "load": {"n": 1.0, "kn": 1e3, "lbf": 4.4482216152605, "v": 1.0, "mv": 1e-3, "%": 1.0, "bool": 1.0},
        "i": {"a": 1.0, "ma": 1e-3},
        "x": {"m": 1.0, "mm": 1e-3, "cm": 1e-2, "um": 1e-6, "in": 0.0254},
        "dx": {"m/s": 1.0, "ms-1": 1.0, "mm/s": 1e-3, "mms-1": 1e-3, "cm/s": 1e-2, "m/min": 1.0 / 60.0},
        "ddx": {"m/s2": 1.0, "ms-2": 1.0, "mm/s2": 1e-3, "mms-2": 1e-3, "cm/s2": 1e-2},
    }
)  # fmt: skip
"""Factor to SI per quantity and unit in lower case, without points, blanks and carets."""
SI_UNIT: Mapping[str, str] = MappingProxyType(
    {"t": "s", "q": "rad", "dq": "rad/s", "ddq": "rad/s²", "tau": "N·m", "f": "N", "load": "N", "i": "A", "x": "m",
     "dx": "m/s", "ddx": "m/s²"}
)  # fmt: skip
"""The unit of each of them whose factor is 1."""
SPELT: Mapping[str, tuple[str, ...]] = {
    "deg": ("degree", "degrees", "grad", "grado", "grados", "gradi", "degre", "degres", "graden", "grau", "graus",
            "winkelgrad"),
    "rad": ("radian", "radians", "radiant", "radianten", "radiante", "radianti", "radiane", "radianes", "radianos",
            "radialen", "bogenmass"),
    "turn": ("turns", "revolution", "revolutions", "umdrehung", "umdrehungen", "tour", "tours", "vuelta", "vueltas",
             "giro", "giri", "revolucion", "revoluciones"),
    "rpm": ("rev/min", "u/min", "umin", "tr/min", "tours/min", "giri/min", "1/min", "min-1", "upm"),
    "s": ("sek", "sekunde", "sekunden", "seconde", "secondes", "segundo", "segundos", "secondo", "secondi", "seg",
          "second", "seconds", "sec"),
    "ms": ("millisecond", "milliseconds", "millisekunde", "millisekunden", "milliseconde", "millisecondes",
           "milisegundo", "milisegundos", "millisecondo", "millisecondi"),
    "us": ("microsecond", "microseconds", "mikrosekunde", "mikrosekunden", "microsecondes", "microsegundos",
           "microsecondi"),
    "nm": ("newtonmeter", "newtonmeters", "newtonmetre", "newtonmetres", "newtonmetro", "newtonmetros",
           "newtonmetri"),
    "n": ("newton", "newtons"),
    "a": ("amp", "amps", "ampere", "amperes", "amperio", "amperios"),
    "ma": ("milliamp", "milliamps", "milliampere", "milliamperes", "miliamperio", "miliamperios"),
    "m": ("meter", "meters", "metre", "metres", "metro", "metros", "metri"),
    "mm": ("millimeter", "millimeters", "millimetre", "millimetres", "milimetro", "milimetros", "millimetri"),
    "v": ("volt", "volts", "voltio", "voltios"),
    "%": ("prozent", "pourcent", "porciento", "percento"),
}  # fmt: skip
"""Units written out, in some languages, without accents."""
_SPELT = {word: unit for unit, words in SPELT.items() for word in words}
NOT_SI = {
    "km": "m", "h": "s", "g": "kg", "t": "kg", "°C": "K", "degC": "K", "%": "1", "percent": "1", "-": "1",
}  # fmt: skip
"""Further units with a factor in them, and what to use instead."""


def plain_unit(unit: str) -> str:
    """Return `unit` in the spelling of the table: "N·m" -> "nm", "rad/s²" -> "rad/s2", "µs" -> "us"."""
    unit = unit.strip().replace("²", "2").replace("⁻¹", "-1").replace("⁻²", "-2")
    unit = unit.replace("µ", "u").replace("μ", "u").replace("º", "°")
    word = re.sub(r"[\s·⋅*.^_-]+(?!\d)|\^", "", unit)
    if word.startswith("MN"):  # the only prefix that is spelt with a capital; all in capitals it could be either
        return "mega" + word[1:].lower() if word == "MN" or not word.isupper() else "mega or milli"
    word = word.lower()
    word = without_accents(word)
    return _SPELT.get(word) or "/".join(_SPELT.get(part, part) for part in word.split("/"))


def _coherent(word: str) -> str:
    """Return the text to write instead of a unit with a factor in it, "" for any other word."""
    plain = plain_unit(word)
    found = ((key, table[plain]) for key, table in QUANTITIES.items() if plain in table and key != "load")  # or in volt
    return NOT_SI.get(word) or next((SI_UNIT[key] for key, factor in found if factor != 1.0), "")


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
    for word in re.findall("^-$|[A-Za-zµ°%]+", text):
        if word not in UNITS and (instead := _coherent(word)):
            what = f"the unit {word} has a factor in it; all numbers here are in SI units"
            raise EffectError(what, remedy=f"use {instead}, and convert bounds and values")
        if word not in UNITS:
            near = nearest(word, UNITS, 2)
            remedy = (f"did you mean {' or '.join(near)}? " if near else "") + "known: " + " ".join(UNITS)
            raise EffectError(f"unknown unit {word[:20]!r} in {text!r}", remedy=remedy)
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
