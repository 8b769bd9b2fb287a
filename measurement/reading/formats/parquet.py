"""Parquet tables through pyarrow, which is an optional extra because it is large."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ground.errors import RecordingError
from measurement.reading.limits import TEXT, Budget
from measurement.reading.raw import RawTable, column_from_cells, split_unit

SUFFIXES = (".parquet", ".pq")
SIGNATURES = (b"PAR1",)
LONGEST_TEXTS = 10_000_000
"""Bytes of a group of rows of texts, beyond which a single cell of it could be too long."""


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
            chosen = _affordable(file, str(path))
            table = file.read(columns=chosen)
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


def _affordable(file: Any, where: str) -> list[str]:
    """Return the columns that are read; RecordingError where they take too much: a cell repeated costs the file
    nothing, and memory eight bytes each time, or as many as its text is long.
    """
    import pyarrow

    types, budget, rows = pyarrow.types, Budget(where), file.metadata.num_rows
    budget.count(file.metadata.num_columns)
    fields = [field for field in file.schema_arrow if not types.is_nested(field.type)]
    for field in fields:
        simple = types.is_primitive(field.type) or types.is_null(field.type)
        budget.take(rows * (8 if simple else TEXT), f"column {field.name[:60]}")
    for group in range(file.metadata.num_row_groups):
        columns = file.metadata.row_group(group)
        texts = {field.name for field in fields if not types.is_primitive(field.type)}
        for k in range(columns.num_columns):
            column = columns.column(k)
            budget.take(column.total_uncompressed_size, f"column {column.path_in_schema[:60]}")
            if column.path_in_schema in texts and column.total_uncompressed_size > LONGEST_TEXTS:
                # Its longest cell may be as long as all of this, and stand in every row.
                budget.take(column.total_uncompressed_size * columns.num_rows, f"column {column.path_in_schema[:60]}")
    return [field.name for field in fields]


def _is_index_of_time(field: Any) -> bool:
    """Whether this is the unnamed index of a pandas table with one time stamp per row."""
    return str(field.name).startswith("__index_level_") and str(field.type).startswith(("timestamp", "duration"))


def _unit(metadata: dict[bytes, bytes] | None) -> str:
    found = (metadata or {}).get(b"unit") or (metadata or {}).get(b"units") or b""
    return found.decode("utf-8", "replace")
