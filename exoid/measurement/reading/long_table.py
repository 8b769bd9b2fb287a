"""Tables with one value a row: Timestamp, Key, Value. Each key becomes a column, all on the clock of one that is an
angle, if its name says so.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from exoid.measurement.finding import Finding
from exoid.measurement.reading.names import quantity_of, recognise
from exoid.measurement.reading.raw import RawColumn, RawTable, split_unit
from exoid.measurement.reading.resample import onto
from exoid.symbolic.joints import UNNAMED, Joint

VALUES = frozenset({"value", "values", "val", "data", "reading", "wert", "valeur", "valor"})
MOST_KEYS = 1000
ONE = (Joint(UNNAMED, length=1.0),)
"""Of a machine with one joint, no name need say which joint it is."""


def widened(table: RawTable) -> RawTable:
    """Return `table` with a column for each of its keys, where it has one value a row; as it is where not."""
    keys = next((column for column in table.columns if column.labels), None)
    if keys is None:
        return table
    value = next((column for column in table.columns if column.name.strip().lower() in VALUES), None)
    clocks = [c for c in table.columns if (found := recognise(c.name)) and found.name == "t"]
    if value is None or not clocks or value is keys or clocks[0] is value:
        return table
    names, inverse = np.unique(np.array(keys.labels), return_inverse=True)
    if not 1 < names.size <= MOST_KEYS or any(_of_joints(column.name) for column in table.columns):
        return table
    rows = {str(name): np.flatnonzero(inverse == k) for k, name in enumerate(names)}
    numbers = {name: at for name, at in rows.items() if name and np.isfinite(value.values[at]).sum() > 1}
    if not numbers:
        return table
    t = clocks[0].values
    main = max(numbers, key=lambda name: (_of_joints(name) == "q", bool(_of_joints(name)), numbers[name].size))
    at = numbers[main]
    columns = [replace(clocks[0], values=t[at], texts={}, text_count=0)]
    for name, own in numbers.items():
        values = value.values[own] if name == main else onto(t[at], t[own], value.values[own])
        plain, unit = split_unit(name)
        columns.append(RawColumn(plain, values, unit))
    what = f"one value stands in each row: the {len(numbers)} keys of {keys.name} are columns, on the clock of {main}"
    notes = (*table.notes, Finding("format", "info", what))
    return RawTable(tuple(columns), table.row[at], notes, tuple(name for name in rows if name and name not in numbers))


def _of_joints(name: str) -> str:
    """Return the quantity of an angle or a torque that a name says, "" for any other."""
    found = recognise(name) or recognise(name, ONE)
    quantity = quantity_of(found.name) if found else ""
    return quantity if quantity in ("q", "tau") else ""
