"""Text tables: CSV, TSV and what instruments call so.

The delimiter, decimal comma, encoding, comment lines, preamble and unit row are found from the first lines
(`sniff.py`). A tidy body goes through the fast C parser; anything else through a careful reader that keeps
track of every line, so that a message can name the line an editor shows.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from measurement.finding import Finding, row_ranges
from measurement.raw import RawColumn, RawTable, column_from_cells
from measurement.sniff import Layout, decode, sniff, split_line
from symbolic.errors import RecordingError

SUFFIXES = (".csv", ".tsv", ".txt", ".dat", ".log", ".asc")
SIGNATURES: tuple[bytes, ...] = ()


def read(path: Path) -> RawTable:
    """Return the columns of the text table at `path`; raises RecordingError for an empty or a binary file."""
    text, notes = decode(path.read_bytes(), where=str(path))
    layout = sniff(text, where=str(path))
    notes += layout.notes
    body = text[layout.body_start :]
    tidy = (
        '"' not in body
        and "\n\n" not in body
        and not any(mark in body for mark in ("\n#", "\n%", "\n//", "\n "))
    )
    table = _fast(body, layout, path) if tidy else None
    if table is None:
        table = _careful(body, layout, path)
    return RawTable(table.columns, table.row, notes + table.notes)


def _columns(frame: Any, layout: Layout) -> tuple[RawColumn, ...]:
    return tuple(
        column_from_cells(name, frame.iloc[:, i], unit)
        for i, (name, unit) in enumerate(zip(layout.names, layout.units, strict=True))
    )


def _fast(body: str, layout: Layout, path: Path) -> RawTable | None:
    """Parse with pandas' C engine; None when the body is ragged and needs the careful reader."""
    import pandas as pd

    try:
        frame = pd.read_csv(
            io.StringIO(body),
            sep=r"\s+" if layout.delimiter == " " else layout.delimiter,
            decimal=layout.decimal,
            header=None,
            names=range(len(layout.names)),
            index_col=False,
            usecols=range(len(layout.names)),
            engine="c",
            quoting=3,
            low_memory=False,
            float_precision="round_trip",
            skip_blank_lines=False,
            on_bad_lines="error",
        )
    except (pd.errors.ParserError, pd.errors.EmptyDataError, ValueError, OverflowError):
        return None
    for column in frame.select_dtypes(include=["object", "string"]):
        if layout.decimal == ",":
            frame[column] = frame[column].str.replace(",", ".", regex=False)
    row = np.arange(layout.first_line, layout.first_line + len(frame))
    return RawTable(_columns(frame, layout), row)


def _careful(body: str, layout: Layout, path: Path) -> RawTable:
    """Parse line by line: blank and comment lines are passed over, short and long rows are masked and counted."""
    import pandas as pd

    width = len(layout.names)
    cells: list[list[str | None]] = []
    row: list[int] = []
    ragged: list[int] = []
    for number, line in enumerate(body.split("\n"), start=layout.first_line):
        if not line.strip() or line.lstrip().startswith(("#", "%", "//")):
            continue
        fields: list[str | None] = list(split_line(line, layout.delimiter))
        while len(fields) > width and not fields[-1]:
            fields.pop()
        if len(fields) != width:
            ragged.append(number)
            # A row with too many cells has lost its places: nothing in it can be attributed to a column.
            fields = [None] * width if len(fields) > width else fields + [None] * (width - len(fields))
        cells.append(fields)
        row.append(number)
    if not cells:
        raise RecordingError("the file has a header but no rows", where=str(path), remedy="record again")
    frame = pd.DataFrame(cells, dtype=object)
    if layout.decimal == ",":
        frame = frame.apply(lambda column: column.str.replace(",", ".", regex=False))
    notes: tuple[Finding, ...] = ()
    if ragged:
        if len(ragged) > len(cells) // 2:
            raise RecordingError(
                f"{len(ragged)} of {len(cells)} rows do not have the {width} cells of the header",
                where=f"{path}, {row_ranges(np.array(ragged))}",
                remedy="is the delimiter also used as decimal comma? Export with a decimal point or with semicolons",
            )
        what = f"{len(ragged)} rows do not have {width} cells like the header; they are masked"
        where = f"{path.name}, {row_ranges(np.array(ragged))}"
        notes = (
            Finding("cells", "repaired", what, where, len(ragged), 0, "nothing, if the rows are few", True),
        )
    return RawTable(_columns(frame, layout), np.array(row), notes)
