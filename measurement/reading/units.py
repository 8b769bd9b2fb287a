"""Units people write, what one of them is in SI, and products that turn a current into a torque.

`Nm/A*0.123*6` is what a column in ampere is multiplied with: torque constant 0.123 N·m/A, gear 6. A product is numbers
and one unit, parted by * and /; it is read by the few lines below, never evaluated.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from types import MappingProxyType

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
SLIDING: Mapping[str, str] = MappingProxyType({"q": "x", "dq": "dx", "ddq": "ddx", "tau": "f"})
"""Which of them a quantity is where the joint slides."""
SOURCES: tuple[Mapping[str, float], ...] = (
    {"a": 1.0, "ma": 1e-3},
    {"%": 1.0, "percent": 1.0, "‰": 0.1, "permille": 0.1},
    {"v": 1.0, "mv": 1e-3},
    {"kg": 1.0},
    {"count": 1.0, "counts": 1.0, "lsb": 1.0, "bit": 1.0, "tick": 1.0, "ticks": 1.0},
)
"""What a column may be in that is not yet a torque, an angle or a force; units of one line convert into each other."""
RATIOS: Mapping[str, float] = MappingProxyType({"%": 0.01, "percent": 0.01, "‰": 0.001, "permille": 0.001})
"""Shares of a rated value, which has to be given: `%*45`."""
PASSED_OVER = frozenset({"-", "1", "", "bool", "hz", "mm", "m", "cm", "m/s", "m/s2", "g", "w", "°c", "frame"})
"""Units of other columns, which may stand in a row of units too."""
LONGEST, MOST_FACTORS = 80, 12
NUMBER = re.compile(r"\d{1,12}(?:\.\d{0,12})?(?:[eE][+-]?\d{1,2})?|\.\d{1,12}", re.ASCII)


def plain_unit(unit: str) -> str:
    """Return `unit` in the spelling of the table: "N·m" -> "nm", "rad/s²" -> "rad/s2", "µs" -> "us"."""
    unit = unit.strip().replace("²", "2").replace("⁻¹", "-1").replace("⁻²", "-2")
    unit = unit.replace("µ", "u").replace("μ", "u").replace("º", "°")
    word = re.sub(r"[\s·⋅*.^_-]+(?!\d)|\^", "", unit)
    if word.startswith("MN"):  # the only prefix that is spelt with a capital; all in capitals it could be either
        return "mega" + word[1:].lower() if word == "MN" or not word.isupper() else "mega or milli"
    return word.lower()


def is_unit(text: str) -> bool:
    """Whether `text` is a unit of any quantity a recording holds ("-" counts: a column without one)."""
    word = plain_unit(text)
    return (
        word in PASSED_OVER
        or text in PASSED_OVER
        or any(word in table for table in (*QUANTITIES.values(), *SOURCES))
        or any(is_scaled(quantity, text) for quantity in ("tau", "f"))
    )


def is_scaled(quantity: str, unit: str) -> bool:
    """Whether `unit` says the quantity per something else ("Nm/kg", "%"): it becomes SI only with a further number."""
    word = plain_unit(unit)
    above, slash, below = word.rpartition("/")
    if slash:
        return above in QUANTITIES.get(quantity, {}) and any(below in table for table in SOURCES)
    return quantity in ("tau", "f", "q", "dq", "x", "dx") and any(word in table for table in SOURCES)


def factor(quantity: str, unit: str, column_unit: str = "") -> float | None:
    """Return the factor from `unit` to SI for a key of QUANTITIES, or None when the unit is not known.

    A number may stand in front ("10 ms" is a counter of ten-millisecond ticks), and so may a minus for a
    channel counted the other way round ("-Nm"). `unit` may be a product: "Nm/A*0.123*6" for a column of currents,
    "Nm*6" for a torque before the gear, "%*45" for per cent of 45 N·m, "deg/6"; `column_unit` is what the file says of
    the column, so that mA are not taken for A.
    """
    if len(unit) > LONGEST:
        return None
    found = re.fullmatch(r"\s*([+-]?)\s*(\d{1,9}(?:\.\d{1,9})?|)\s*([^\d\s.+-].{0,30})", unit)
    if found:
        known = QUANTITIES[quantity].get(plain_unit(found[3]))
        scale = float(found[2] or 1.0) * (-1.0 if found[1] == "-" else 1.0)
        if known is not None and scale != 0.0:
            return scale * known
    return _product(quantity, unit, column_unit)


def is_product(unit: str) -> bool:
    """Whether `unit` is written with factors, as `Nm/A*0.123`."""
    return any(NUMBER.fullmatch(part.strip()) for part in re.split(r"[*·×/]", unit.strip().lstrip("+-")))


def _product(quantity: str, text: str, column_unit: str) -> float | None:
    """Return the factor of a product of numbers and one unit, None where it is none."""
    text = text.strip()
    sign = -1.0 if text.startswith("-") else 1.0
    pieces = re.split(r"([*·×/])", text.lstrip("+-"), maxsplit=2 * MOST_FACTORS)
    if len(pieces) > 2 * MOST_FACTORS or len(pieces) < 3:
        return None
    value, words, numbers = 1.0, "", 0
    for operator, piece in zip(["*", *pieces[1::2]], pieces[::2], strict=True):
        piece = piece.strip()
        if NUMBER.fullmatch(piece):
            number = float(piece)
            if number == 0.0:
                return None
            numbers += 1
            value = value / number if operator == "/" else value * number
        elif not piece:
            return None
        else:
            words += ("/" if operator == "/" else "*" if words else "") + piece
    if not words or not numbers or words.startswith("/"):
        return None
    base = _base(quantity, plain_unit(words), plain_unit(column_unit))
    if base is None:
        return None
    scale = sign * value * base
    return scale if math.isfinite(scale) and abs(scale) > 1e-30 else None


def _base(quantity: str, unit: str, column: str) -> float | None:
    """Return what one of `unit` is in SI, apart from the numbers of the product, for a `column` in that unit."""
    table = QUANTITIES[quantity]
    if unit in table:
        return table[unit]
    above, slash, below = unit.rpartition("/")
    if slash and above not in table:
        return None
    source = next((line for line in SOURCES if (below if slash else unit) in line), None)
    if source is None:
        return None
    below = below if slash else unit
    if "/" in column and column != unit:
        return None
    here = column.rpartition("/")[2] or below
    if here not in source:
        return None
    if not slash:  # "A*0.123*6": what is left when the ampere has been multiplied away is the quantity in SI
        return RATIOS.get(unit, source[unit]) * (source[here] / source[unit])
    return table[above] * source[here] / source[below]
