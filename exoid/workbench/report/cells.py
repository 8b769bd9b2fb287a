"""Cells of a table whose text is not the number they are sorted by."""

from __future__ import annotations

import math
from typing import Any


def share(value: float | None, form: str = ".0f") -> dict[str, Any] | None:
    """Return a share as per cent in a `form`, sorted by its number; None where there is none."""
    if value is None or not math.isfinite(value):
        return None
    return {"value": float(value), "text": f"{100 * float(value):{form}} %"}
