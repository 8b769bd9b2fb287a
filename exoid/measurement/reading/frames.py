"""Tables that are in memory already: pandas, polars, PyArrow, NumPy structured arrays, xarray, mappings of arrays.

None of these libraries is needed for it: an object is known by what it can do, and who has a DataFrame has pandas.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.raw import RawColumn, RawTable, named_column, of_lists, split_unit, table_from_arrays

FRAMES = ("pandas.DataFrame", "polars.DataFrame", "polars.LazyFrame", "pyarrow.Table")


def is_table(source: Any) -> bool:
    """True if this is a table or an array in memory, as `table_from` reads them or refuses them with a reason."""
    kind = _kind(source)
    return kind in FRAMES or kind.startswith("xarray.") or isinstance(source, (np.ndarray, Mapping))


def _kind(source: Any) -> str:
    return f"{type(source).__module__.partition('.')[0]}.{type(source).__name__}"


def table_from(source: Any, where: str, joints: int | None = None) -> RawTable:
    """Return the columns of a table in memory; RecordingError where `source` is none, or has no rows.

    An array (N, 1 + 2 J) has the columns t, q1, ..., tau1, ...; `joints` is J where it is known.
    """
    kind = _kind(source)
    if kind == "pandas.DataFrame":
        table = _from_pandas(source)
    elif kind == "polars.LazyFrame":
        return table_from(source.collect(), where, joints)
    elif kind in ("polars.DataFrame", "pyarrow.Table"):
        names = list(source.columns if kind.startswith("polars") else source.column_names)
        table = _table([(name, _cells(source[name]), "") for name in names])
    elif kind.startswith("xarray."):
        table = _from_xarray(source)
    elif isinstance(source, np.ndarray) and source.dtype.names:
        return table_from_arrays({name: source[name] for name in source.dtype.names}, where=where)
    elif isinstance(source, np.ndarray):
        return _from_matrix(source, where, joints)
    elif isinstance(source, Mapping):
        return table_from_arrays({str(name): np.asarray(cells) for name, cells in source.items()}, where=where)
    else:
        raise RecordingError(
            f"a {type(source).__name__} is not a recording",
            where=where,
            remedy="give a path, a DataFrame (pandas or polars), an array with the columns t, q1, ..., tau1, ..., a "
            "structured NumPy array, an xarray Dataset, or a mapping {name: array}",
        )
    if not table.columns or not table.row.size:
        raise RecordingError("the table has no rows", where=where, remedy="give one row per sample")
    return table


def _from_matrix(matrix: np.ndarray, where: str, joints: int | None) -> RawTable:
    """Return the columns t, q1, ..., tau1, ... of an array whose width says of how many joints it is."""
    shape = matrix.shape
    fits = matrix.ndim == 2 and shape[1] % 2 == 1 and shape[1] >= 3 and joints in (None, (shape[1] - 1) // 2)
    if not fits or matrix.dtype.kind not in "iuf":
        wanted = "1 + 2 J columns" if joints is None else f"{1 + 2 * joints} columns"
        turned = matrix.ndim == 2 and shape[0] in ([1 + 2 * joints] if joints else (3, 5, 7)) and shape[0] < shape[1]
        raise RecordingError(
            f"an array {shape} of {matrix.dtype} is not a recording: {wanted} of numbers are needed, the time, then "
            "the angles, then the torques of all joints",
            where=where,
            remedy="turn it round: array.T" if turned else "name the columns: {'t': ..., 'q1': ..., 'tau1': ...}",
        )
    count = (shape[1] - 1) // 2
    names = ["t", *(f"{what}{k}" for what in ("q", "tau") for k in range(1, count + 1))]
    return _table([(name, matrix[:, k], "") for k, name in enumerate(names)])


def _from_pandas(frame: Any) -> RawTable:
    """Return the columns of a DataFrame; an index that is no plain row number is a column too."""
    import pandas as pd

    columns = []
    index = frame.index.to_series()
    if not isinstance(frame.index, pd.RangeIndex) and (
        frame.index.name is not None or pd.api.types.is_float_dtype(index) or index.dtype.kind in "mM"
    ):
        columns.append((str(frame.index.name or "time"), _array(index), ""))
    for i, name in enumerate(frame.columns):
        text = ".".join(str(part) for part in name if str(part)) if isinstance(name, tuple) else str(name)
        units = frame.attrs.get("units", {})
        unit = units.get(name, "") if isinstance(units, Mapping) else ""
        columns.append((text, _array(frame.iloc[:, i]), str(unit)))
    return _table(columns)


def _array(series: Any) -> np.ndarray:
    """Return the cells of a Series: numbers as such, dates and durations in ns, anything else as it is or None."""
    from pandas.api import types

    if types.is_numeric_dtype(series) and not types.is_bool_dtype(series) and not types.is_complex_dtype(series):
        return np.asarray(series.to_numpy(dtype=float, na_value=np.nan))
    if series.dtype.kind in "mM":
        return np.asarray(series.to_numpy(dtype=f"{series.dtype.kind}8[ns]"))
    return np.asarray(series.astype(object).where(series.notna(), None).to_numpy())


def _cells(series: Any) -> Any:
    """Return a polars or PyArrow column as an array or a list."""
    try:
        return series.to_numpy()
    except (TypeError, ValueError, RuntimeError):
        return series.to_list() if hasattr(series, "to_list") else series.to_pylist()


def _from_xarray(source: Any) -> RawTable:
    """Return the variables of a Dataset along its time; a second dimension becomes columns of their own."""
    data = source.to_dataset(name=source.name or "value") if hasattr(source, "to_dataset") else source
    arrays = {str(name): np.asarray(item.values) for name, item in {**data.coords, **data.data_vars}.items()}
    units = {str(name): str(item.attrs.get("units", "")) for name, item in data.variables.items()}
    length = max((array.shape[0] for array in arrays.values() if array.ndim), default=0)
    columns: list[tuple[str, Any, str]] = []
    for name, array in arrays.items():
        if array.ndim == 1 and array.shape[0] == length:
            columns.append((name, array, units.get(name, "")))
        elif array.ndim == 2:
            dims = data[name].dims
            along = next((k for k in (0, 1) if array.shape[k] == length), 0)
            other = dims[1 - along]
            labels = [str(x) for x in data[other].values] if other in data.coords else None
            tall = array if along == 0 else array.T
            for k in range(tall.shape[1]):
                columns.append((f"{name}.{labels[k] if labels else k + 1}", tall[:, k], units.get(name, "")))
    return _table(columns)


def _table(columns: list[tuple[str, Any, str]]) -> RawTable:
    found = [column for name, cells, unit in columns for column in _columns(name, cells, unit)]
    rows = found[0].values.shape[0] if found else 0
    return RawTable(tuple(found), np.arange(1, rows + 1))


def _columns(name: str, cells: Any, unit: str) -> Iterator[RawColumn]:
    """Yield the column of some cells, or, where each is a list of as many numbers, one for each of its elements."""
    some = cells if isinstance(cells, np.ndarray) else list(cells)
    if len(some) and isinstance(some[0], (list, tuple, np.ndarray)):
        try:
            table = np.array(list(some), dtype=float)
        except (TypeError, ValueError):
            table = np.empty(0)  # lists of different lengths, or of no numbers
        if table.ndim == 2:
            yield from of_lists(*split_unit(name), table.T)
            return
    yield named_column(name, cells, unit)
