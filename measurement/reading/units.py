"""Units people write, and what one of them is in SI."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from types import MappingProxyType

DEGREE = math.pi / 180.0
QUANTITIES: Mapping[str, Mapping[str, float]] = MappingProxyType(
    {
        "t": {"s": 1.0, "sec": 1.0, "second": 1.0, "seconds": 1.0, "ms": 1e-3, "msec": 1e-3, "us": 1e-6,
              "ns": 1e-9, "min": 60.0},
        "q": {"rad": 1.0, "mrad": 1e-3, "deg": DEGREE, "degree": DEGREE, "degrees": DEGREE, "°": DEGREE,
              "rev": 2 * math.pi, "turn": 2 * math.pi},
        "dq": {"rad/s": 1.0, "rads-1": 1.0, "mrad/s": 1e-3, "deg/s": DEGREE, "degs-1": DEGREE, "°/s": DEGREE,
               "rpm": math.pi / 30.0, "rev/s": 2 * math.pi},
        "ddq": {"rad/s2": 1.0, "rads-2": 1.0, "rad/s/s": 1.0, "mrad/s2": 1e-3, "deg/s2": DEGREE,
                "degs-2": DEGREE, "°/s2": DEGREE, "deg/s/s": DEGREE},
        "tau": {"nm": 1.0, "mnm": 1e-3, "knm": 1e3, "ncm": 1e-2, "nmm": 1e-3, "lbfft": 1.3558179483314004,
                "ftlb": 1.3558179483314004, "lbfin": 0.1129848290276167, "inlb": 0.1129848290276167},
        "f": {"n": 1.0, "mn": 1e-3, "kn": 1e3, "lbf": 4.4482216152605},
    }
)  # fmt: skip
"""Factor to SI per quantity and unit in lower case, without points, blanks and carets."""


def plain(unit: str) -> str:
    """Return `unit` in the spelling of the table: "N·m" -> "nm", "rad/s²" -> "rad/s2", "µs" -> "us"."""
    unit = unit.strip().replace("²", "2").replace("⁻¹", "-1").replace("⁻²", "-2")
    unit = unit.replace("µ", "u").replace("μ", "u").replace("º", "°")
    return re.sub(r"[\s·⋅*.^_-]+(?!\d)|\^", "", unit).lower()


def is_unit(text: str) -> bool:
    """Whether `text` is a unit of any quantity a recording holds ("-" counts: a column without one)."""
    return text in ("-", "1", "") or any(plain(text) in table for table in QUANTITIES.values())


def factor(quantity: str, unit: str) -> float | None:
    """Return the factor from `unit` to SI for t, q, dq, ddq, tau or f, or None when the unit is not known.

    A number may stand in front ("10 ms" is a counter of ten-millisecond ticks), and so may a minus for a
    channel counted the other way round ("-Nm").
    """
    found = re.fullmatch(r"\s*([+-]?)\s*(\d{1,9}(?:\.\d{1,9})?|)\s*([^\d\s.+-].{0,30})", unit)
    if not found:
        return None
    known = QUANTITIES[quantity].get(plain(found[3]))
    scale = float(found[2] or 1.0) * (-1.0 if found[1] == "-" else 1.0)
    return None if known is None or scale == 0.0 else scale * known
