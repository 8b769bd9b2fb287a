"""What a user maps by hand: a column by its name, or the product of several ("duty*volts")."""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.ground.suggest import nearest
from exoid.measurement.reading.raw import RawColumn, RawTable
from exoid.measurement.reading.units import MOST_FACTORS

DIMENSIONLESS = ("", "-", "1")


def mapped(table: RawTable, mapping: Mapping[str, str], where: str) -> dict[str, RawColumn]:
    """Return {canonical name: column} of what a user maps by hand; RecordingError for what is not in the table."""
    chosen: dict[str, RawColumn] = {}
    for name, wanted in mapping.items():
        called = factors_of(wanted, numbered(table.names))
        factors = tuple(_called(table, one, name, where) for one in called)
        found = factors[0] if len(factors) == 1 else _product(wanted, factors)
        double = [other for other, column in chosen.items() if column is found]
        if double:
            raise RecordingError(
                f"column {wanted!r} is mapped to both {double[0]} and {name}",
                where=where,
                remedy="map each column once",
            )
        chosen[name] = found
    return chosen


def factors_of(text: str, names: Collection[str]) -> list[str]:
    """Return the columns that `text` names in a mapping: one of the `names`, or the factors of "duty*volts"."""
    parts = [part.strip() for part in re.split(r"[*·×]", text)]
    return [text] if text in names or len(parts) > MOST_FACTORS or not all(parts) else parts


def _called(table: RawTable, wanted: str, name: str, where: str) -> RawColumn:
    """Return the one column that is called `wanted`, to be read as `name`; RecordingError where there is none."""
    found = [c for c, n in zip(table.columns, numbered(table.names), strict=True) if wanted in (c.name, n)]
    found = found or [c for c in table.columns if c.name.lower() == wanted.strip().lower()]
    if len(found) == 1:
        return found[0]
    close = nearest(wanted, table.names, 1, cutoff=0.5)
    hint = f"did you mean {close[0]!r}? " if close and not found else ""
    what = "is not in the file" if not found else f"stands {len(found)} times in the file"
    hint = f"write {wanted}#1 for the first of them. " if found else hint
    raise RecordingError(
        f"column {wanted!r} ({name}) {what}", where=where, remedy=f"{hint}columns found: {listed(table.names)}"
    )


def _product(text: str, factors: tuple[RawColumn, ...]) -> RawColumn:
    """Return the product of columns; what is no number in one of them is none in it."""
    unit = "*".join(column.unit for column in factors if column.unit not in DIMENSIONLESS)
    with np.errstate(over="ignore", invalid="ignore"):
        values = np.prod([column.values for column in factors], axis=0)
    texts = {row: cell for column in factors for row, cell in column.texts.items()}
    return RawColumn(text, values, unit, texts, sum(column.text_count for column in factors), factors=factors)


def numbered(names: Sequence[str]) -> list[str]:
    """Return names that can be distinguished: of several alike, the second is "name#2"."""
    return [f"{name}#{names[:k].count(name) + 1}" if names.count(name) > 1 else name for k, name in enumerate(names)]


def listed(names: Sequence[str], most: int = 20) -> str:
    """Return names for a message, the long tail cut."""
    text = ", ".join(name[:40] or "(no name)" for name in names[:most])
    return text + (f" and {len(names) - most} more" if len(names) > most else "")
