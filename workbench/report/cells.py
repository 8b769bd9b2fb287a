"""Cells of a table whose text is not the number they are sorted by."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

EMPTY = "–"
"""What stands in a cell that has nothing to say."""


def share(value: float | None) -> dict[str, Any] | None:
    """Return a share as per cent, sorted by its number; None where there is none."""
    if value is None or not math.isfinite(value):
        return None
    return {"value": float(value), "text": f"{100 * float(value):.0f} %"}


def without_empty(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> tuple[tuple[str, ...], list[tuple[Any, ...]]]:
    """Return a table without the columns in which no row says anything; a table without rows keeps them all."""
    kept = [i for i in range(len(head)) if not rows or any(row[i] not in (None, EMPTY) for row in rows)]
    return tuple(head[i] for i in kept), [tuple(row[i] for i in kept) for row in rows]
