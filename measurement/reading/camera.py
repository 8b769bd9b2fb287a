"""Time of recordings that count frames: what motion capture exports, with the rate in a line above the table."""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from exoid.measurement.finding import Finding
from exoid.measurement.reading.names import recognise
from exoid.measurement.reading.raw import RawColumn, RawTable

FRAMES = frozenset({"frame", "frames", "framenumber", "item", "sample", "samples", "samplenumber", "index"})
NAMED = re.compile(
    r"^\W*(?:camera\W?|capture\W?|data\W?|sampl(?:e|ing)\W?)?(?:frequency|(?:frame\W?)?rate)\W*?"
    r"(?:\W*\[?\(?hz\)?\]?)?[\s:=,;]+(\d+(?:\.\d+)?)\D*$",
    re.IGNORECASE | re.MULTILINE,
)
"""A line that says the rate: FREQUENCY 100, Sampling rate (Hz): 100."""
NUMBER_ALONE = re.compile(r"^[\s,;]*(\d+(?:\.\d+)?)[\s,;]*$", re.MULTILINE)
"""A line with nothing but a number: what stands below the kind of data in files of Vicon."""


def with_time(table: RawTable, above: str, where: str) -> RawTable:
    """Return `table` with a time made of its frames and of the rate in `above`, the text before it.

    As it is where it has a time, no frames that count up, or no line that says the rate.
    """
    meant = [recognise(column.name) for column in table.columns]
    plain = {re.sub(r"[\W_]", "", column.name).lower(): column.values for column in reversed(table.columns)}
    frames = next((plain[name] for name in plain if name in FRAMES), None)
    said = NAMED.findall(above) or NUMBER_ALONE.findall(above)
    if frames is None or len(set(said)) != 1 or any(one and one.name == "t" for one in meant):
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
