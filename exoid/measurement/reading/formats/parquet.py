"""Parquet tables through pyarrow, which is an optional extra because it is large."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.ground.extras import needing
from exoid.measurement.reading.limits import TEXT, Budget, damaged
from exoid.measurement.reading.raw import RawColumn, RawTable, column_from_cells, of_lists, split_unit

SUFFIXES = (".parquet", ".pq")
SIGNATURES = (b"PAR1",)
MOST_GROUP = 500_000_000
"""Bytes of a row group, which is unpacked as a whole."""
MOST_ELEMENTS = 64
"""Of a list, beyond which it is no row of joints but a picture or a spectrum."""
LONGEST_TEXTS = 10_000_000
"""Bytes of a group of rows of texts, beyond which a single cell of it could be too long."""


def read(path: Path) -> RawTable:
    """Return the columns of the table; raises RecordingError when it is damaged or pyarrow is not
    installed."""
    instead = ", or save the recording as CSV"
    with needing("parquet", "Parquet files", "pyarrow", where=path, instead=instead, error=RecordingError):
        import pyarrow
        import pyarrow.parquet
    causes = (pyarrow.ArrowException, OSError, ValueError, KeyError, TypeError)
    with damaged("Parquet file", path, causes), pyarrow.parquet.ParquetFile(path) as file:
        chosen = _affordable(file, str(path))
        table = file.read(columns=chosen)
        columns = _columns(table)
        there = {column.name for column in columns}
        names = [field.name for field in file.schema_arrow if not _is_plain(field.type)]
        others = tuple(name for name in names if f"{split_unit(name)[0]}_0" not in there)
    if not columns or not table.num_rows:
        raise RecordingError("the table has no rows", where=str(path), remedy="record again")
    return RawTable(columns, np.arange(1, table.num_rows + 1), others=others)


def is_large(path: Path, most: int) -> bool:
    """True if the numbers of the table take more than a third of `most` bytes; False where it cannot be told."""
    try:
        import pyarrow
        import pyarrow.parquet

        with pyarrow.parquet.ParquetFile(path) as file:
            return bool(file.metadata.num_rows * file.metadata.num_columns * 8 > most / 3)
    except (ImportError, OSError, ValueError):
        return False  # refused with its reason when it is read


def pieces(path: Path, size: int) -> Iterator[tuple[float, RawTable]]:
    """Yield (share that is read, table) of pieces whose numbers take about `size` bytes; texts are left out."""
    import pyarrow
    import pyarrow.parquet

    causes = (pyarrow.ArrowException, OSError, KeyError, TypeError)
    with damaged("Parquet file", path, causes), pyarrow.parquet.ParquetFile(path) as file:
        fields = [item for item in file.schema_arrow if pyarrow.types.is_primitive(item.type) or _is_list(item.type)]
        groups = [file.metadata.row_group(k) for k in range(file.metadata.num_row_groups)]
        if max((group.total_byte_size for group in groups), default=0) > MOST_GROUP or len(fields) > 1000:
            what = "a row group of the file is too large"
            raise RecordingError(what, where=str(path), remedy="write it with row_group_size=1000000")
        rows = max(1000, size // (16 * max(1, len(fields))))  # as many as of a text of this size
        done = 0
        # A few groups of rows at a time: what is iterated over in one go stays in memory until its end.
        for some in _together([group.num_rows for group in groups], rows):
            total = sum(groups[k].num_rows for k in some)
            each = max(1, -(-total // max(1, total // rows)))
            for batch in file.iter_batches(each, row_groups=some, columns=[field.name for field in fields]):
                table = pyarrow.Table.from_batches([batch])
                columns = _columns(table)
                row = np.arange(done + 1, done + table.num_rows + 1)
                done += table.num_rows
                yield done / file.metadata.num_rows, RawTable(columns, row)


def _columns(table: Any) -> tuple[RawColumn, ...]:
    """Return the columns of an Arrow table, with the units that the file gives them; of one with lists of equal length,
    as data sets of robots have them, a column for each element. What is nested otherwise is none.
    """
    columns: list[RawColumn] = []
    for i, field in enumerate(table.schema):
        name, unit = split_unit(field.name)
        name, unit = "time" if _is_index_of_time(field) else name, _unit(field.metadata) or unit
        if _is_list(field.type):
            columns += of_lists(name, unit, _elements(table.column(i)))
        elif _is_plain(field.type):
            columns.append(column_from_cells(name, _cells(table.column(i)), unit))
    return tuple(columns)


def _is_plain(kind: Any) -> bool:
    import pyarrow

    return not pyarrow.types.is_nested(kind)


def _is_list(kind: Any) -> bool:
    """True if cells of this type are lists of numbers."""
    import pyarrow

    types = pyarrow.types
    listed = types.is_list(kind) or types.is_large_list(kind) or types.is_fixed_size_list(kind)
    return bool(listed and (types.is_integer(kind.value_type) or types.is_floating(kind.value_type)))


def _elements(column: Any) -> list[Any]:
    """Return the cells of each element of a column of lists, none where their lengths differ or are too many."""
    import pyarrow.compute as compute

    lengths = compute.unique(compute.drop_null(compute.list_value_length(column))).to_pylist()
    if len(lengths) != 1 or not 0 < lengths[0] <= MOST_ELEMENTS:
        return []
    return [_cells(compute.list_element(column, k)) for k in range(lengths[0])]


def _cells(column: Any) -> Any:
    """Return the cells of an Arrow column as an array or, where NumPy has no type for them, as a list."""
    import pyarrow

    if pyarrow.types.is_dictionary(column.type):
        column = column.cast(column.type.value_type)
    plain = pyarrow.types.is_boolean(column.type) or not pyarrow.types.is_primitive(column.type)
    return column.to_pylist() if plain else column.to_numpy()


def _together(counts: list[int], rows: int) -> Iterator[list[int]]:
    """Yield which groups, of so many rows each, are read together: as few in a row as have `rows` rows."""
    some: list[int] = []
    for k in range(len(counts)):
        some.append(k)
        if sum(counts[j] for j in some) >= rows:
            yield some
            some = []
    if some:
        yield some


def _affordable(file: Any, where: str) -> list[str]:
    """Return the columns that are read; RecordingError where they take too much: a cell repeated costs the file
    nothing, and memory eight bytes each time, or as many as its text is long.
    """
    import pyarrow

    types, budget, rows = pyarrow.types, Budget(where), file.metadata.num_rows
    budget.count(file.metadata.num_columns)
    fields = [field for field in file.schema_arrow if _is_plain(field.type)]
    lists = [field.name for field in file.schema_arrow if _is_list(field.type)]
    for field in fields:
        simple = types.is_primitive(field.type) or types.is_null(field.type)
        budget.take(rows * (8 if simple else TEXT), f"column {field.name[:60]}")
    for group in range(file.metadata.num_row_groups):
        columns = file.metadata.row_group(group)
        texts = {field.name for field in fields if not types.is_primitive(field.type)}
        for k in range(columns.num_columns):
            column = columns.column(k)
            if any(column.path_in_schema.startswith(f"{name}.") for name in lists):
                budget.take(8 * column.num_values, f"column {column.path_in_schema[:60]}")
            budget.take(column.total_uncompressed_size, f"column {column.path_in_schema[:60]}")
            if column.path_in_schema in texts and column.total_uncompressed_size > LONGEST_TEXTS:
                # Its longest cell may be as long as all of this, and stand in every row.
                budget.take(column.total_uncompressed_size * columns.num_rows, f"column {column.path_in_schema[:60]}")
    return [*(field.name for field in fields), *lists]


def _is_index_of_time(field: Any) -> bool:
    """True if this is the unnamed index of a pandas table with one time stamp per row."""
    return str(field.name).startswith("__index_level_") and str(field.type).startswith(("timestamp", "duration"))


def _unit(metadata: dict[bytes, bytes] | None) -> str:
    found = (metadata or {}).get(b"unit") or (metadata or {}).get(b"units") or b""
    return found.decode("utf-8", "replace")
