"""Parquet tables through pyarrow, which is an optional extra because it is large."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ground.errors import RecordingError
from measurement.reading.raw import RawTable, column_from_cells, split_unit

SUFFIXES = (".parquet", ".pq")
SIGNATURES = (b"PAR1",)


def read(path: Path) -> RawTable:
    """Return the columns of the table; raises RecordingError when it is damaged or pyarrow is not
    installed."""
    try:
        import pyarrow
        import pyarrow.parquet
    except ImportError as error:
        raise RecordingError(
            "Parquet files need the package pyarrow, which is not installed",
            where=str(path),
            remedy="pip install 'exoid[parquet]', or save the recording as CSV",
        ) from error
    try:
        with pyarrow.parquet.ParquetFile(path) as file:
            table = file.read()
        columns = tuple(
            column_from_cells(
                "time" if _is_index_of_time(field) else split_unit(field.name)[0],
                table.column(i).to_pandas(),
                _unit(field.metadata) or split_unit(field.name)[1],
            )
            for i, field in enumerate(table.schema)
            if not pyarrow.types.is_nested(field.type)
        )
    except (pyarrow.ArrowException, OSError, ValueError, KeyError, TypeError) as error:
        raise RecordingError(
            f"the Parquet file is damaged or incomplete ({error})",
            where=str(path),
            remedy="copy or save it again",
        ) from error
    if not columns or not table.num_rows:
        raise RecordingError("the table has no rows", where=str(path), remedy="record again")
    return RawTable(columns, np.arange(1, table.num_rows + 1))


def _is_index_of_time(field: Any) -> bool:
    """Whether this is the unnamed index of a pandas table with one time stamp per row."""
    return str(field.name).startswith("__index_level_") and str(field.type).startswith(("timestamp", "duration"))


def _unit(metadata: dict[bytes, bytes] | None) -> str:
    found = (metadata or {}).get(b"unit") or (metadata or {}).get(b"units") or b""
    return found.decode("utf-8", "replace")
