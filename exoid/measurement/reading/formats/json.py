"""JSON: a list of records, one record per line, or an object of columns; objects inside become groups of columns.

`{"t": 0.01, "q": [0.6, -0.9], "hip": {"torque": 3.1}}` has the columns t, q1, q2 and hip.torque. What pandas writes is
read too. A table may lie inside other objects, beside `"units": {"q1": "deg"}`.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.measurement.finding import Finding, row_ranges
from exoid.measurement.reading.limits import Budget, damaged
from exoid.measurement.reading.raw import RawTable, named_column, table_from_arrays

SUFFIXES = (".json", ".jsonl", ".ndjson")
SIGNATURES = (b'{"', b"[{")
SPACE = 12
"""Bytes that a byte of text takes at most while it is read: numbers become objects first."""
DEEPEST = 8
"""Objects inside objects."""
SEEN = 0.1
"""Share of the records that have a key at least, for it to be a column; else records of unlike keys would make a table
as large as the square of the file."""
WIDEST = 64
"""Numbers in a list that stands for columns."""
SHORTEST = 10
"""Samples, below which it is no recording but a list of settings."""
Record = dict[str, Any]


class _Found(NamedTuple):
    """A table in a value: `columns` {name: list}, or `records`, with the units that stand beside it."""

    columns: Record
    records: list[Record]
    units: Mapping[str, str]

    @property
    def size(self) -> int:
        longest = max((len(column) for column in self.columns.values()), default=0)
        return longest * len(self.columns) + sum(map(len, self.records))


def read(path: Path) -> RawTable:
    """Return the columns of the file; RecordingError where it is damaged or holds no table."""
    budget = Budget(str(path))
    budget.take(SPACE * path.stat().st_size, "the text")
    with damaged("JSON", path, (UnicodeDecodeError,), "save it as UTF-8"):
        text = path.read_bytes().decode("utf-8-sig")
    return _read(text, str(path), budget)


def holds_recording(content: bytes) -> bool:
    """True if the content of a file holds a table; settings and results, which lie beside it, are JSON as well.

    What is damaged counts, so that it is refused with its reason.
    """
    try:
        value, _, _ = _parsed(content.decode("utf-8-sig"), "")
    except (RecordingError, UnicodeDecodeError):
        return True
    return not _result(value) and next(_tables_in(value), None) is not None


def _read(text: str, where: str, budget: Budget) -> RawTable:
    value, lines, notes = _parsed(text, where)
    if schema := _result(value):
        what = f"this is a result of exoid ({schema[:40]}), not a recording"
        raise RecordingError(what, where=where, remedy="give the recording itself")
    found = max(_tables_in(value), key=lambda one: one.size, default=None)
    if found is None:
        raise RecordingError(
            f"the JSON holds no table of {SHORTEST} samples or more", where=where,
            remedy='write one record per line, {"t": 0.01, "q1": ...}, a list of them, or an object of columns '
            '{"t": [...], "q1": [...]}',
        )  # fmt: skip
    if found.records:
        return _of_records(found, lines, where, budget, notes)
    return table_from_arrays(found.columns, where=where, units=found.units, notes=notes)


def _result(value: Any) -> str:
    """Return the schema of a result that exoid wrote itself, "" for anything else."""
    schema = value.get("schema") if isinstance(value, dict) else None
    return schema if isinstance(schema, str) and schema.startswith("exoid.") else ""


def _parsed(text: str, where: str) -> tuple[Any, Sequence[int], tuple[Finding, ...]]:
    """Return the value of a text, or a list of those of its lines with their numbers, and what is to be said."""
    lines = [(number, line) for number, line in enumerate(text.split("\n"), start=1) if line.strip()]
    try:
        if len(lines) < 2 or not all(map(_is_whole, (line for _, line in lines[:2]))):
            return json.loads(text), (), ()
    except (ValueError, RecursionError) as error:
        raise _broken(error, where) from None
    values: list[Any] = []
    numbers: list[int] = []
    for number, line in lines:
        try:
            values.append(json.loads(line))
        except (ValueError, RecursionError) as error:
            if number != lines[-1][0]:
                raise _broken(error, f"{where}, line {number}") from None
            what = "the last line is cut off, as where a logger was stopped; it is left out"
            return values, numbers, (Finding("format", "repaired", what, f"{where}, line {number}", remedy="nothing"),)
        numbers.append(number)
    return values, numbers, ()


def _is_whole(line: str) -> bool:
    """True if a line is a JSON object or list by itself."""
    try:
        return line.lstrip()[:1] in ("{", "[") and isinstance(json.loads(line), (dict, list))
    except (ValueError, RecursionError):
        return False


def _broken(error: Exception, where: str) -> RecordingError:
    return RecordingError(f"this is not JSON ({str(error)[:120]})", where=where, remedy="write the file again")


def _tables_in(value: Any, units: Mapping[str, str] = MappingProxyType({}), depth: int = 0) -> Iterator[_Found]:
    """Yield every table in a value: the innermost first, whose names are the shortest."""
    if depth > DEEPEST:
        return
    if isinstance(value, list) and len(value) >= SHORTEST:
        if all(isinstance(item, dict) for item in value):
            yield _Found({}, [dict(_flat(element)) for element in value], units)
        elif all(isinstance(entry, list) for entry in value):
            headed = all(isinstance(name, str) for name in value[0])
            names = value[0] if headed else [str(k + 1) for k in range(len(value[0]))]
            yield _Found({}, [dict(zip(names, row, strict=False)) for row in value[headed:]], units)
    elif isinstance(value, dict):
        units = _texts(value.get("units", value.get("unit"))) or units
        named, rows = value.get("columns"), value.get("data")
        if isinstance(named, list) and isinstance(rows, list):  # as pandas splits a table
            yield from _tables_in([[str(name) for name in named], *rows], units, depth + 1)
            return
        if len(value) >= SHORTEST and all(key.isdecimal() for key in value):
            yield from _tables_in(list(value.values()), units, depth + 1)
            return
        for inner in value.values():
            yield from _tables_in(inner, units, depth + 1)
        columns = dict(_lists_in(value))
        if len(columns) > 1:
            yield _Found(columns, [], units)


def _texts(value: Any) -> dict[str, str]:
    """Return {name: text} of an object of texts, {} for anything else."""
    return {k: v for k, v in value.items() if isinstance(v, str)} if isinstance(value, dict) else {}


def _lists_in(value: Record, depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Yield (name, array) of the lists in an object, those of objects inside as "hip.angle"."""
    for name, item in value.items():
        if isinstance(item, dict) and len(item) >= SHORTEST and all(key.isdecimal() for key in item):
            item = list(item.values())  # {"0": 0.6, "1": 0.7, ...}, as pandas writes a column
        if isinstance(item, dict) and depth < DEEPEST:
            yield from ((f"{name}.{key}", cells) for key, cells in _lists_in(item, depth + 1))
        elif isinstance(item, list) and len(item) >= 2 and not any(isinstance(cell, dict) for cell in item):
            try:
                cells = np.array(item)
            except ValueError:  # lists of unlike lengths
                continue
            if cells.dtype.kind in "iufbOU":
                yield name, cells.astype(float) if cells.dtype.kind == "b" else cells


def _flat(record: Record, depth: int = 0) -> Iterator[tuple[str, Any]]:
    """Yield the cells of a record: {"q": [1, 2]} as q1 and q2, {"hip": {"angle": 1}} as hip.angle."""
    for name, item in record.items():
        if isinstance(item, dict) and depth < DEEPEST:
            yield from ((f"{name}.{key}", cell) for key, cell in _flat(item, depth + 1))
        elif isinstance(item, list) and len(item) <= WIDEST:
            yield from ((f"{name}{k}", cell) for k, cell in enumerate(item, start=1) if not isinstance(cell, list))
        elif not isinstance(item, (dict, list)):
            yield name, float(item) if isinstance(item, bool) else item


def _of_records(
    found: _Found, lines: Sequence[int], where: str, budget: Budget, notes: tuple[Finding, ...]
) -> RawTable:
    """Return the columns of records; those that have few of the usual keys, a header or an event, are left out."""
    records = found.records
    counts = Counter(key for row in records for key in row)
    names = [key for key, count in counts.items() if count >= SEEN * len(records)]
    budget.count(len(names))
    budget.take(8 * len(names) * len(records))
    usual = [key for key in names if counts[key] > 0.5 * len(records)]
    numbers = lines[-len(records) :] if lines else range(1, len(records) + 1)
    kept = [k for k, row in enumerate(records) if 2 * sum(key in row for key in usual) > len(usual)]
    other = np.array([numbers[k] for k in sorted(set(range(len(records))) - set(kept))])
    if other.size:
        what = f"{other.size} of {len(records)} records are no samples: they lack most of the keys of the others"
        notes = (*notes, Finding("format", "info", what, f"{where}, {row_ranges(other)}"))
    cells = ([records[k].get(name) for k in kept] for name in names)
    columns = (named_column(name, some, found.units.get(name, "")) for name, some in zip(names, cells, strict=True))
    return RawTable(tuple(columns), np.array([numbers[k] for k in kept], dtype=np.int64), notes)
