"""Times made of other columns: of frames and the rate above the table, as motion capture exports them, and of seconds
and nanoseconds, as ROS writes them.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from exoid.measurement.finding import Finding
from exoid.measurement.reading.names import recognise
from exoid.measurement.reading.raw import RawColumn, RawTable
from exoid.measurement.reading.stamps import first_of

FRAMES = frozenset({"frame", "frames", "framenumber", "item", "sample", "samples", "samplenumber", "index"})
NAMED = re.compile(
    r"^\W*(?:camera\W?|capture\W?|data\W?|sampl(?:e|ing)\W?)?(?:frequency|(?:frame\W?)?rate)\W*?"
    r"(?:\W*\[?\(?hz\)?\]?)?[\s:=,;]+(\d+(?:\.\d+)?)\D*$",
    re.IGNORECASE | re.MULTILINE,
)
"""A line that says the rate: FREQUENCY 100, Sampling rate (Hz): 100."""
NUMBER_ALONE = re.compile(r"^[\s,;]*(\d+(?:\.\d+)?)[\s,;]*$", re.MULTILINE)
"""A line with nothing but a number: what stands below the kind of data in files of Vicon."""
SPLIT = re.compile(r"(?P<stem>.*?)[._/]?(?P<part>n(?:ano)?secs?|secs?)", re.IGNORECASE)


def with_time(table: RawTable, above: str, where: str) -> RawTable:
    """Return `table` with a time made of its frames and of the rate in `above`, the text before it.

    As it is where it has a time, no frames that count up, or no line that says the rate.
    """
    meant = [recognise(column.name) for column in table.columns]
    plain = {re.sub(r"[\W_]", "", column.name).lower(): column.values for column in reversed(table.columns)}
    frames = next((plain[name] for name in plain if name in FRAMES), None)
    said = NAMED.findall(above) or NUMBER_ALONE.findall(above)
    if frames is None or len(set(said)) != 1 or any(item and item.name == "t" for item in meant):
        return table
    rate = float(said[0])
    within = plain.get("subframe", np.zeros(frames.size))
    count = frames * (np.nanmax(within, initial=0.0) + 1.0) + within
    if not (rate > 0.0 and np.isfinite(count).all() and (np.diff(count) > 0.0).all()):
        return table
    what = f"the time was made of the frames and of the {rate:g} Hz above the table"
    note = Finding("format", "info", what, where, remedy="--map t=COLUMN, if there is a clock")
    columns = (RawColumn("time", count / rate, "s"), *table.columns)
    return replace(table, columns=columns, notes=(*table.notes, note))


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
