"""Tables with one value a row: Timestamp, Key, Value. Each key becomes a column, all on the clock of one that is an
angle, if its name says so.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exoid.ground.text import without_accents
from exoid.measurement.finding import Finding
from exoid.measurement.reading.names import quantity_of, recognise
from exoid.measurement.reading.raw import RawColumn, RawTable, split_unit
from exoid.measurement.reading.resample import onto
from exoid.symbolic.joints import UNNAMED, Joint

KEYS = frozenset(
    {
        "key", "keys", "name", "signal", "channel", "topic", "variable", "field", "_field", "entry", "metric", "tag",
        "series", "parameter", "kanal", "senal", "canal", "signalname", "channel_name", "sensor", "sensor_id", "id",
    }
)  # fmt: skip
"""What heads the column that says, in a table with one value a row, of what the value is."""
VALUES = frozenset(
    {"value", "values", "val", "_value", "data", "reading", "wert", "valeur", "valor", "measurement", "messwert",
     "float_value"}
)  # fmt: skip
UNITS = frozenset({"unit", "units", "einheit", "unite", "unidad", "unita"})
ALTERNATE = 0.3
"""Of the rows, in which the key is another than in the row before where no heading says that it is one: the state of a
machine seldom changes."""
ONE = (Joint(UNNAMED, length=1.0),)
"""Of a machine with one joint, no name need say which joint it is."""


def widened(table: RawTable) -> RawTable:
    """Return `table` with a column for each of its keys, where it has one value a row; as it is where not."""
    if not any(column.labels for column in table.columns) or any(_of_joints(c.name) for c in table.columns):
        return table
    clock = next((c for c in table.columns if (found := recognise(c.name)) and found.name == "t"), None)
    keys = _keys(table.columns)
    value = _value(table.columns, clock)
    if clock is None or keys is None or value is None:
        return table
    names, inverse = np.unique(np.array(keys.labels), return_inverse=True)
    rows = {str(name): np.flatnonzero(inverse == k) for k, name in enumerate(names)}
    numbers = {name: at for name, at in rows.items() if name and np.isfinite(value.values[at]).sum() > 1}
    if names.size < 2 or not numbers:
        return table
    t = clock.values
    main = max(numbers, key=lambda name: (_of_joints(name) == "q", bool(_of_joints(name)), numbers[name].size))
    at = numbers[main]
    units = next((c.labels for c in table.columns if c.labels and _plain(c.name) in UNITS), ())
    columns = [replace(clock, values=t[at], texts={}, text_count=0)]
    for name, own in numbers.items():
        values = value.values[own] if name == main else onto(t[at], t[own], value.values[own])
        plain, unit = split_unit(name)
        there = {units[int(k)] for k in own} if units else set()
        columns.append(RawColumn(plain, values, unit or (there.pop() if len(there) == 1 else "")))
    what = f"one value stands in each row: the {len(numbers)} keys of {keys.name} are columns, on the clock of {main}"
    notes = (*table.notes, Finding("format", "info", what))
    return RawTable(tuple(columns), table.row[at], notes, tuple(name for name in rows if name and name not in numbers))


def _keys(columns: Sequence[RawColumn]) -> RawColumn | None:
    """Return the column of the keys: the one that is called so, or the one whose words change from row to row."""
    words = [column for column in columns if column.labels and len(set(column.labels)) > 1]
    called = [column for column in words if _plain(column.name) in KEYS]
    rest = [column for column in words if _plain(column.name) not in UNITS and _changes(column) > ALTERNATE]
    return next(iter(called or rest), None)


def _changes(column: RawColumn) -> float:
    labels = np.array(column.labels)
    return float(np.mean(labels[1:] != labels[:-1]))


def _value(columns: Sequence[RawColumn], clock: RawColumn | None) -> RawColumn | None:
    """Return the column of the values: the one that is called so, or the only one of numbers beside the `clock`."""
    there = [c for c in columns if c is not clock and not c.labels and np.isfinite(c.values).mean() > 0.5]
    called = [column for column in there if _plain(column.name) in VALUES]
    return called[0] if called else there[0] if len(there) == 1 else None


def _plain(name: str) -> str:
    """Return a heading in small letters without accents."""
    return without_accents(name.strip().lower())


def _of_joints(name: str) -> str:
    """Return the quantity of an angle or a torque that a name says, "" for any other."""
    found = recognise(name) or recognise(name, ONE)
    quantity = quantity_of(found.name) if found else ""
    return quantity if quantity in ("q", "tau") else ""
