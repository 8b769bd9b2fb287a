"""Spreadsheets (Excel, OpenDocument) through python-calamine, which is an optional extra.

The first sheet that holds a table is read, as a text table would be: names, perhaps a row of units, rows of numbers.
Formulas count as the value that was stored with them; nothing is computed.
"""

from __future__ import annotations

import json
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.ground.extras import needing
from exoid.measurement.finding import Finding
from exoid.measurement.reading import limits, sheet_process
from exoid.measurement.reading.limits import TEXT, Budget
from exoid.measurement.reading.made_times import with_time
from exoid.measurement.reading.names import recognise
from exoid.measurement.reading.raw import RawTable, column_from_cells, split_unit
from exoid.measurement.reading.sniff import FLEXION, under_groups
from exoid.measurement.reading.units import is_unit

SUFFIXES = (".xlsx", ".xlsm", ".xlsb", ".xls", ".ods")
SIGNATURES = (b"PK\x03\x04", b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1")
MOST_ROWS = 1_100_000
PROGRAM = 500_000_000
"""Bytes of addresses that the process which reads it takes beside its cells."""
HEAD_ROWS = 100


def read(path: Path) -> RawTable:
    """Return the columns of the table; raises RecordingError when there is none or python-calamine is missing."""
    instead = ", or save the sheet as CSV"
    with needing("excel", "spreadsheets", "python-calamine", where=path, instead=instead, error=RecordingError):
        import python_calamine  # noqa: F401 - the process that reads needs it
    budget = Budget(str(path))
    budget.take(path.stat().st_size, "the spreadsheet")
    for others, name, rows in _sheets(path, budget):
        found = _table(rows, str(path))
        if found is not None:
            what = f"sheet {name!r} was read"
            note = Finding("format", "info", what + (f", {others} others were not" if others else ""), str(path))
            return replace(found, notes=(*found.notes, note)) if others else found
    remedy = "one row of column names and one row of numbers per sample"
    raise RecordingError("no sheet of the spreadsheet holds a table of numbers", where=str(path), remedy=remedy)


def _sheets(path: Path, budget: Budget) -> Iterator[tuple[int, str, list[list[Any]]]]:
    """Yield (number of other sheets, name, rows) of each sheet, as a process of its own reads them."""
    arguments = [str(path.absolute()), str(limits.MOST_BYTES + PROGRAM), str(MOST_ROWS)]
    reader = subprocess.Popen(
        [sys.executable, "-P", str(Path(sheet_process.__file__)), *arguments],
        stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, encoding="utf-8",
    )  # fmt: skip
    assert reader.stdout is not None and reader.stderr is not None
    try:
        name: str | None = None
        rows: list[list[Any]] = []
        sheets: int | None = None
        for line in reader.stdout:
            value = json.loads(line)
            if sheets is None:
                sheets = int(value)
            elif name is None:
                name = str(value)
            elif value is None:
                yield sheets - 1, name, rows
                name, rows = None, []
            else:
                budget.take(TEXT * (1 + len(value)), f"sheet {name[:40]}")
                rows.append(value)
        if reader.wait() != 0:
            said = reader.stderr.read().strip().splitlines() if reader.returncode == 1 else []
            raise RecordingError(
                f"the spreadsheet is damaged, or takes too much memory ({said[-1] if said else 'its reader gave up'})",
                where=str(path),
                remedy="save it again, or as CSV",
            )
    finally:
        reader.kill()
        reader.communicate()


def _table(rows: list[list[Any]], where: str) -> RawTable | None:
    """Return the table in the cells of a sheet, None where there is none."""
    first = next((i for i, row in enumerate(rows[:HEAD_ROWS]) if _is_data(row)), None)
    if first is None or len(rows) - first < 2:
        return None
    width = max(len(row) for row in rows[first : first + 50])
    head = [[str(cell).strip() for cell in row] for row in rows[:first]]
    units = [""] * width
    if len(head) > 1 and _share(head[-1], is_unit) > 0.6 and _share(head[-2], is_unit) < 0.5:
        units = [cell.strip("[]() ") for cell in head.pop()]
    named, axes = under_groups(head[-1], head[:-1]) if head else ([str(k + 1) for k in range(width)], False)
    if head and not any(recognise(cell) for cell in named):
        named = next((row for row in reversed(head) if any(recognise(cell) for cell in row)), named)
    columns = []
    for k in range(width):
        cells = [_cell(row[k]) if k < len(row) else None for row in rows[first:]]
        name, unit = split_unit(named[k] if k < len(named) else "")
        if name or any(cell is not None for cell in cells):
            columns.append(column_from_cells(name or str(k + 1), cells, units[k] if k < len(units) else unit))
            columns[-1] = replace(columns[-1], unit=columns[-1].unit or unit)
    notes = (Finding("format", "info", FLEXION, where, remedy="if it is not: --map q1=COLUMN"),) if axes else ()
    above = "\n".join("\t".join(row) for row in head)
    return with_time(RawTable(tuple(columns), np.arange(first + 1, len(rows) + 1), notes), above, where)


def _is_data(row: list[Any]) -> bool:
    filled = [cell for cell in row if cell != ""]
    kinds = (int, float, list)
    return len(filled) > 1 and sum(isinstance(c, kinds) and not isinstance(c, bool) for c in filled) > 0.6 * len(filled)


def _share(row: list[str], test: Any) -> float:
    filled = [cell for cell in row if cell]
    return sum(bool(test(cell.strip("[]() "))) for cell in filled) / len(filled) if filled else 0.0


def _cell(cell: Any) -> Any:
    """Return a cell as a number or a text, None where it is empty; a time of day is what a clock would show."""
    return cell[0] if isinstance(cell, list) else None if cell == "" else cell
