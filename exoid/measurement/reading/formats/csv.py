"""Text tables: CSV, TSV and what instruments call so.

The delimiter, decimal comma, encoding, comment lines, preamble and unit row are found from the first lines
(`sniff.py`). A tidy body goes straight through the fast C parser; any other is tidied line by line first,
keeping track of the lines, so that a message can name the line an editor shows.
"""

from __future__ import annotations

import io
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import zip_longest
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.errors import RecordingError
from exoid.ground.inputs import open_input
from exoid.measurement.finding import Finding, row_ranges
from exoid.measurement.reading.limits import Budget
from exoid.measurement.reading.made_times import with_time
from exoid.measurement.reading.raw import RawColumn, RawTable, column_from_cells
from exoid.measurement.reading.sniff import COMMENTS, POINTS, Layout, decode, sniff, split_line
from exoid.symbolic.motion import Float

SUFFIXES = (".csv", ".tsv", ".txt", ".dat", ".log", ".asc")
SIGNATURES: tuple[bytes, ...] = ()
APART = "\u2009"
"""Stands for a delimiter inside quotes: a thin space, which also parts thousands."""
SHORT = 10_000_000
"""Characters up to which NumPy reads a table of numbers in less time than pandas, where there is one, is imported."""
HEAD = 1_000_000
"""Bytes in which the header of a long text ends."""
CHUNK = 500_000
"""Rows of a long text that are parsed at once."""
UNTIDY = ('"', "\x00", "\n\n", "\n ", "\n\t", *(f"\n{mark}" for mark in COMMENTS))


def read(path: Path, skip: int = 0) -> RawTable:
    """Return the columns of the text table at `path`; raises RecordingError for an empty or a binary file.

    `skip` bytes at the beginning are not part of the table; its lines are counted all the same.
    """
    budget = Budget(str(path))
    # The bytes, their text, and the numbers in it, which are there at the same time.
    budget.take(2 * path.stat().st_size, "the text")
    data = path.read_bytes()
    above = data[:skip].count(b"\n")
    return _table(data[skip:], above, path, budget)


def is_large(path: Path, most: int) -> bool:
    """True if the text has more than `most` bytes."""
    return path.stat().st_size > most


def pieces(path: Path, size: int) -> Iterator[tuple[float, RawTable]]:
    """Yield (share that is read, table) of pieces of about `size` bytes, each read as a table under the same header.

    Only for UTF-8, ASCII and Latin text with line feeds; RecordingError for any other.
    """
    total = path.stat().st_size
    with open_input(path) as stream:
        first = stream.read(HEAD)
        text, _ = decode(first, where=str(path))
        if b"\x00" in first or b"\n" not in first:
            raise RecordingError("a text so long must be UTF-8 with line feeds", where=str(path), remedy="convert it")
        above = sniff(text, where=str(path)).first_line - 1
        stream.seek(0)
        header = b"".join(stream.readline(HEAD) for _ in range(above))
        row = 0
        while body := stream.read(size):
            body += stream.readline(HEAD)
            table = _table(header + body, 0, path, Budget(str(path)))
            yield min(1.0, stream.tell() / total), replace(table, row=table.row + row)
            row += body.count(b"\n")


def _table(data: bytes, above: int, path: Path, budget: Budget) -> RawTable:
    """Return the columns of a text; `above` lines of the file stand before it."""
    tidy = _long(data, above, path, budget)
    if tidy is not None:
        return tidy
    text, notes = decode(data, where=str(path))
    del data
    layout = sniff(text, where=str(path))
    layout = replace(layout, first_line=layout.first_line + above)
    notes += layout.notes
    head, body = text[: layout.body_start], text[layout.body_start :]
    del text
    lines = body.count("\n")
    row = np.arange(layout.first_line, layout.first_line + lines)
    commas = layout.delimiter == "," == layout.decimal
    budget.count(len(layout.names))
    budget.take(8 * lines * len(layout.names), "the table")
    expected = lines * (len(layout.names) - 1)
    ragged = layout.delimiter != " " and body.count(layout.delimiter) != expected
    cells = None
    if not (commas or ragged or any(mark in body for mark in UNTIDY)):
        cells = _parse(body, layout)
    if cells is None:
        body, row, more = _tidied(body, layout, path)
        notes += more
        layout = replace(layout, decimal=".") if commas else layout
        cells = _parse(body, layout)
    if cells is None or len(cells[0]) != row.size:
        remedy = "open it in an editor: every line needs the same number of cells as the header"
        raise RecordingError("the rows cannot be cut into columns", where=str(path), remedy=remedy)
    columns = tuple(
        column_from_cells(name, cells[i], unit)
        for i, (name, unit) in enumerate(zip(layout.names, layout.units, strict=True))
    )
    return with_time(RawTable(columns, row, notes), head, str(path))


def _long(data: bytes, above: int, path: Path, budget: Budget) -> RawTable | None:
    """Return the columns of a long text of tidy numbers, which is not copied for that; None for any other."""
    if len(data) < SHORT or not data.isascii() or not data.endswith(b"\n") or b"\r" in data or b"\x1a" in data:
        return None
    text, notes = decode(data[: data.rfind(b"\n", 0, HEAD) + 1], where=str(path))
    layout = sniff(text, where=str(path))
    start, width = layout.body_start, len(layout.names)
    # One character is found faster than two, and most of those that end a mark do not occur at all.
    marks = [mark.encode() for mark in UNTIDY if data.find(mark[-1].encode(), start) >= 0]
    lines = data.count(b"\n", start)
    separated = layout.delimiter == " " or data.count(layout.delimiter.encode(), start) == lines * (width - 1)
    if layout.decimal != "." or not separated or any(data.find(mark, start) >= 0 for mark in marks):
        return None
    budget.count(width)
    budget.take(8 * lines * width, "the table")
    stream = io.BytesIO(data)
    stream.seek(start)
    try:
        table = _quickly(stream, layout, lines)
        if table is None:
            delimiter = None if layout.delimiter == " " else layout.delimiter
            table = np.ascontiguousarray(np.loadtxt(stream, delimiter=delimiter, comments=None, ndmin=2).T)
    except (ValueError, OverflowError):
        return None
    if table.shape != (width, lines):
        return None
    columns = tuple(RawColumn(*named) for named in zip(layout.names, table, layout.units, strict=True))
    row = np.arange(layout.first_line + above, layout.first_line + above + lines)
    return with_time(RawTable(columns, row, notes + layout.notes), text[:start], str(path))


def _parse(body: str, layout: Layout) -> Sequence[Any] | None:
    """Return the cells of each column; None when some row has more cells than the header."""
    numbers = _numbers(body, layout)
    if numbers is not None:
        return numbers
    width = len(layout.names)
    delimiter = None if layout.delimiter == " " else layout.delimiter
    rows = [line.split(delimiter) for line in body.removesuffix("\n").split("\n")]
    if any(len(row) > width for row in rows):
        return None
    columns = zip_longest(*rows, fillvalue="")
    if layout.decimal == ",":
        return [[_with_point(cell) for cell in column] for column in columns]
    found = list(columns)
    return found + [[""] * len(rows)] * (width - len(found))


def _numbers(body: str, layout: Layout) -> Sequence[Any] | None:
    """Return the columns of a table that holds a plain number in every cell; None for any other."""
    text = body if layout.decimal == "." else body.replace(".", "?").replace(",", ".")
    try:
        if len(body) > SHORT:
            table = _quickly(io.BytesIO(text.encode(errors="replace")), layout, body.count("\n"))
            if table is not None:
                return list(table)
        table = np.loadtxt(
            io.StringIO(text),
            delimiter=None if layout.delimiter == " " else layout.delimiter,
            comments=None,
            ndmin=2,
        )
    except (ValueError, OverflowError):
        return None
    return list(np.ascontiguousarray(table.T)) if table.shape[1] == len(layout.names) else None


def _quickly(stream: io.BytesIO, layout: Layout, lines: int) -> Float | None:
    """Return the numbers (C, N) of the rest of a long text, which pandas reads four times as fast as NumPy; None where
    it is not installed.

    ValueError where a cell is no number; an empty one is NaN.
    """
    try:
        import pandas as pd
    except ImportError:
        return None
    # What is written must read back as the same numbers; from version 3 on pandas does so unasked.
    exact: dict[str, Any] = {} if int(pd.__version__.split(".")[0]) >= 3 else {"float_precision": "round_trip"}
    frames = pd.read_csv(
        stream,
        sep=r"\s+" if layout.delimiter == " " else layout.delimiter,
        header=None,
        dtype=float,
        quoting=3,
        chunksize=CHUNK,  # the parser needs several times what it parses at once
        **exact,
        skip_blank_lines=False,
    )
    table, done = np.empty((len(layout.names), lines)), 0
    for frame in frames:
        table[:, done : done + len(frame)] = frame.to_numpy().T
        done += len(frame)
    if done != lines:
        raise ValueError(f"{done} rows in {lines} lines")
    return table


def _with_point(cell: str) -> str:
    return (cell.strip().replace(".", "") if POINTS.fullmatch(cell.strip()) else cell).replace(",", ".")


def _tidied(body: str, layout: Layout, path: Path) -> tuple[str, NDArray[np.int64], tuple[Finding, ...]]:
    """Return the body without blank lines, comments and quotes, its line numbers, and what was ragged.

    A row with too many cells has lost its places: nothing in it can be attributed to a column, so all its
    cells are emptied. A row with too few keeps those it has.
    """
    width, delimiter = len(layout.names), layout.delimiter
    empty = "nan" + f"{delimiter}nan" * (width - 1)
    lines: list[str] = []
    row: list[int] = []
    ragged: list[int] = []
    for number, line in enumerate(body.split("\n"), start=layout.first_line):
        if not line.strip() or line.lstrip().startswith(COMMENTS):
            continue
        cells = split_line(line.replace("\x00", "?"), delimiter)
        while len(cells) > width and not cells[-1]:
            cells.pop()
        if len(cells) != width:
            ragged.append(number)
        if delimiter == "," == layout.decimal:
            cells = [cell.replace(",", ".") for cell in cells]
        tidy = delimiter.join(cell.replace(delimiter, APART) if cell else "nan" for cell in cells)
        lines.append(tidy if len(cells) <= width else empty)
        row.append(number)
    places = row_ranges(np.array(ragged))
    if len(ragged) > len(lines) // 2:
        raise RecordingError(
            f"{len(ragged)} of {len(lines)} rows do not have the {width} cells of the header",
            where=f"{path}, {places}",
            remedy="is the delimiter also the decimal comma? Export with a decimal point or with semicolons",
        )
    notes: tuple[Finding, ...] = ()
    if ragged:
        what = f"{len(ragged)} rows do not have {width} cells like the header; they are masked"
        remedy = "nothing, if the rows are few; otherwise look at the logger"
        notes = (Finding("cells", "repaired", what, f"{path}, {places}", float(len(ragged)), 0.0, remedy),)
    return "\n".join(lines) + "\n", np.array(row, dtype=np.int64), notes
