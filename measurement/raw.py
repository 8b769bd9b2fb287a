"""Named columns as they stand in a file, before anybody has decided what they mean."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from measurement.finding import Finding
from symbolic.motion import Float


@dataclass(frozen=True, eq=False)
class RawColumn:
    """One column: `values` (N,) with NaN where the cell is empty or not a number.

    `texts` are the cells that hold something else than a number: {index: cell}, at most the first twenty;
    `text_count` is how many there are. `unit` comes from the header, a unit row or an attribute ("" if unsaid).
    """

    name: str
    values: Float
    unit: str = ""
    texts: Mapping[int, str] = field(default_factory=dict)
    text_count: int = 0


@dataclass(frozen=True, eq=False)
class RawTable:
    """The columns of one file; `row` (N,) is where each sample stands in it, `notes` what the reader had to decide."""

    columns: tuple[RawColumn, ...]
    row: NDArray[np.int64]
    notes: tuple[Finding, ...] = ()

    @property
    def names(self) -> list[str]:
        """Column names in the order of the file."""
        return [column.name for column in self.columns]


def column_from_cells(name: str, cells: Any, unit: str = "") -> RawColumn:
    """Return a column from an array (N,) of numbers or of cells of any kind; what is not a number becomes NaN."""
    import pandas as pd

    series = pd.Series(cells)
    if pd.api.types.is_bool_dtype(series) or pd.api.types.is_complex_dtype(series):
        series = series.astype(str)
    if pd.api.types.is_numeric_dtype(series):
        return RawColumn(name, series.to_numpy(dtype=float, na_value=np.nan), unit)
    if pd.api.types.is_datetime64_any_dtype(series) or pd.api.types.is_timedelta64_dtype(series):
        return RawColumn(name, _seconds(series), "s")
    cells = series.astype(object)
    values = _to_numbers(cells)
    filled = ~cells.isna().to_numpy() & np.array([bool(str(cell).strip()) for cell in cells], dtype=bool)
    wrong = np.flatnonzero(np.isnan(values) & filled)
    texts = {int(i): str(cells.iloc[i])[:40] for i in wrong[:20]}
    return RawColumn(name, values, unit, texts, int(wrong.size))


def _to_numbers(cells: Any) -> Float:
    """Return (N,) floats; a cell counts as a number only when it is a plain ASCII decimal number."""
    import pandas as pd

    text = cells.astype(str).str.strip()
    odd = ~text.str.fullmatch(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?|[+-]?inf(inity)?", case=False).fillna(
        False
    )
    text = text.mask(odd, "nan").str.replace(r"(?<=\d)[dD]", "e", regex=True)
    return np.asarray(pd.to_numeric(text, errors="coerce"), dtype=float)


def _seconds(series: Any) -> Float:
    """Return seconds since the first stamp for a datetime or duration column (N,)."""
    first = series.dropna().iloc[0] if series.notna().any() else series.iloc[0]
    return np.asarray((series - first).dt.total_seconds(), dtype=float)


def table_from_arrays(
    arrays: Mapping[str, Any],
    *,
    where: str,
    units: Mapping[str, str] | None = None,
    notes: tuple[Finding, ...] = (),
) -> RawTable:
    """Return the columns held by named `arrays`: (N,), (N, 2) and (2, N) become one and two columns.

    N is the length most arrays share; arrays of another length (settings, other channels) are left out and said so.
    Raises RecordingError when there is no array of two samples or more.
    """
    from symbolic.errors import RecordingError

    units = units or {}
    flat = {name: np.squeeze(np.asarray(array)) for name, array in arrays.items()}
    lengths = [max(a.shape) for a in flat.values() if 1 <= a.ndim <= 2 and a.size]
    if not lengths or max(lengths) < 2:
        raise RecordingError(
            "no column of numbers was found in the file",
            where=where,
            remedy=f"store t, q1, q2, tau1, tau2 as arrays of equal length (found: {', '.join(arrays) or 'nothing'})",
        )
    count = max(set(lengths), key=lambda length: (lengths.count(length), length))
    columns: list[RawColumn] = []
    skipped: list[str] = []
    for name, array in flat.items():
        parts = _split(name, array, count)
        if not parts:
            skipped.append(f"{name} {array.shape}")
        columns += [column_from_cells(part, cells, units.get(name, "")) for part, cells in parts.items()]
    if skipped:
        text = f"{len(skipped)} entries are not columns of {count} samples and were left aside: {', '.join(skipped[:8])}"
        notes = (*notes, Finding("format", "info", text, where))
    return RawTable(tuple(columns), np.arange(1, count + 1), notes)


def _split(name: str, array: Any, count: int) -> dict[str, Any]:
    """Return {column name: (N,) cells} of one array, empty when its shape does not fit N = `count` samples."""
    if array.dtype.names:
        return {f"{name}.{key}": array[key] for key in array.dtype.names if array[key].shape == (count,)}
    if array.ndim == 1 and array.shape[0] == count:
        return {name: array}
    if array.ndim == 2 and count in array.shape and min(array.shape) <= 64:
        tall = array if array.shape[0] == count else array.T
        return {f"{name}{k + 1}": tall[:, k] for k in range(tall.shape[1])}
    return {}
