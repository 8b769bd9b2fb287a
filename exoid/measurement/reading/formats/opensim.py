"""OpenSim storage files (.mot, .sto): a header that ends in `endheader`, then a table parted by tabs or blanks.

`inDegrees=yes` makes degrees of the coordinates; moments and forces are in SI.
"""

from __future__ import annotations

import re
from dataclasses import replace
from pathlib import Path

from exoid.ground.errors import RecordingError
from exoid.ground.inputs import open_input
from exoid.measurement.reading.formats import csv
from exoid.measurement.reading.names import quantity_of, recognise
from exoid.measurement.reading.raw import RawColumn, RawTable

SUFFIXES = (".mot", ".sto")
SIGNATURES: tuple[bytes, ...] = ()
LONGEST_HEADER = 65_536
DEGREES = {"q": "deg", "dq": "deg/s", "ddq": "deg/s²"}


def read(path: Path) -> RawTable:
    """Return the columns of the file; raises RecordingError where its header does not end or no table follows."""
    with open_input(path) as stream:
        head = stream.read(LONGEST_HEADER).decode("latin-1")
    end = re.search(r"^\s*endheader[^\n]*\n", head, re.IGNORECASE | re.MULTILINE)
    if end is None:
        what = "the header does not end in 'endheader'"
        raise RecordingError(what, where=str(path), remedy="export it from OpenSim again")
    table = csv.read(path, skip=end.end())
    degrees = re.search(r"^\s*inDegrees\s*=\s*yes", head[: end.start()], re.IGNORECASE | re.MULTILINE)
    return replace(table, columns=tuple(_with_unit(column, degrees is not None) for column in table.columns))


def _with_unit(column: RawColumn, degrees: bool) -> RawColumn:
    found = recognise(column.name)
    unit = DEGREES.get(quantity_of(found.name), "") if found and degrees and not column.unit else ""
    return replace(column, unit=unit) if unit else column
