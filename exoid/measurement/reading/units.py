"""Units people write, what one of them is in SI, and products that turn a current into a torque.

`Nm/A*0.123*6` is what a column in ampere is multiplied with: torque constant 0.123 N·m/A, gear 6. A product is numbers
and one unit, parted by * and /; it is read by the few lines below, never evaluated.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from types import MappingProxyType

from exoid.symbolic.units import QUANTITIES, plain_unit

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


def is_unit(text: str) -> bool:
    """True if `text` is a unit of any quantity a recording holds ("-" counts: a column without one)."""
    word = plain_unit(text)
    return (
        word in PASSED_OVER
        or text in PASSED_OVER
        or any(word in table for table in (*QUANTITIES.values(), *SOURCES))
        or any(is_scaled(quantity, text) for quantity in ("tau", "f"))
    )


def is_scaled(quantity: str, unit: str) -> bool:
    """True if `unit` says the quantity per something else ("Nm/kg", "%"): it becomes SI only with a further number."""
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
    """True if `unit` is written with factors, as `Nm/A*0.123`."""
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
    """Return the factor from `unit` to SI, apart from the numbers of the product, for a `column` in that unit."""
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
