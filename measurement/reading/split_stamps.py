"""Stamps split in two columns, seconds and nanoseconds, as ROS writes them, joined into one time."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from exoid.measurement.finding import Finding
from exoid.measurement.reading.raw import RawColumn, RawTable
from exoid.measurement.reading.stamps import first_of

SPLIT = re.compile(r"(?P<stem>.*?)[._/]?(?P<part>n(?:ano)?secs?|secs?)", re.IGNORECASE)


def join_split(table: RawTable) -> RawTable:
    """Return `table` with a stamp in seconds and nanoseconds (ROS: header.stamp.secs, .nsecs) as one column.

    It is the instant of the measurement, so it is preferred to a column with the time of arrival.
    """
    halves: dict[str, dict[bool, RawColumn]] = {}
    for column in table.columns:
        found = SPLIT.fullmatch(column.name)
        if found:
            halves.setdefault(found["stem"], {})[found["part"].lower().startswith("n")] = column
    for stem, pair in halves.items():
        if len(pair) < 2 or not re.search(r"stamp|time|clock|^t?$", stem, re.IGNORECASE):
            continue
        whole, small = pair[False].values, pair[True].values
        if np.nanmax(np.abs(small), initial=0.0) > 1e9:
            continue
        stamp = RawColumn(stem or "stamp", (whole - first_of(whole)) + 1e-9 * small, "s", rank=-1)
        rest = tuple(c for c in table.columns if c is not pair[False] and c is not pair[True])
        what = f"{pair[False].name} and {pair[True].name} were joined into the time"
        return replace(table, columns=(stamp, *rest), notes=(*table.notes, Finding("columns", "info", what)))
    return table
