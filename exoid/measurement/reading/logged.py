"""Columns of a file that belong to no joint's motion and torque and may be why these differ: a motor's temperature.

What follows from the torque or counts the samples is left out: a battery's voltage sags because the motors pull, and
something that falls with the torque explains nothing of it.
"""

from __future__ import annotations

import re
from collections.abc import Collection

import numpy as np

from exoid.measurement.logged import Logged
from exoid.measurement.reading.names import FOREIGN, WORDS, recognise, words_in
from exoid.measurement.reading.raw import RawColumn, RawTable
from exoid.measurement.recording import Recording
from exoid.symbolic.motion import Float

PACE = 1.0
"""Seconds over which a column is averaged."""
KNOWN = 0.9
"""Part of its cells that must be numbers."""
STEADY = 0.9999
"""Correlation with time from which a column is a clock or a counter."""
FOLLOWING = frozenset(
    {
        "voltage", "volt", "volts", "mv", "vbat", "vbatt", "vbus", "vdc", "udc", "battery", "batterie", "bat",
        "batt", "akku", "bus", "dc", "supply", "spannung", "tension", "voltaje", "voltaggio", "power", "leistung",
        "puissance", "potencia", "soc", "charge", "ladung", "energy", "pwm", "duty", "load", "cycle", "ma",
    }
) | {*WORDS["i"], *WORDS["tau"]}  # fmt: skip
"""Words of what an electric drive does because of its torque."""
COUNTING = frozenset(
    {
        "index", "frame", "episode", "count", "counter", "sample", "samples", "id", "seq", "sequence", "trial", "run",
        "subject", "session", "row", "number", "nr", "no", "task", "step", "stride", "mode", "status", "flag", "error",
    }
) | {*WORDS["t"]} - {"temps"}  # fmt: skip
"""Words of what counts, or names the recording."""
WARM = frozenset(
    {"temperature", "temperatures", "temp", "temperatur", "temperatura", "celsius", "kelvin", "thermistor", "ntc"}
)
"""Words of what may rise steadily and counts nothing: a drive that warms up."""
ELECTRIC = re.compile(r"(m|k)?(V|A|W|Ah|Wh|VA|J)|%")
"""Units of the same."""


def logged_columns(table: RawTable, recording: Recording, used: Collection[int]) -> dict[str, Logged]:
    """Return {name: column} of what else the file says of the machine's state; `used` are the ids of its columns that
    are a part of the recording.
    """
    free = [column for column in table.columns if id(column) not in used and _may_be_why(column, recording)]
    if not free or not len(recording):
        return {}
    order = np.argsort(table.row, kind="stable")
    place = order[np.clip(np.searchsorted(table.row[order], recording.row), 0, len(order) - 1)]
    found = table.row[place] == recording.row
    starts = np.flatnonzero(np.diff(np.floor((recording.t - recording.t[0]) / PACE), prepend=-1.0))
    out = {}
    for column in free:
        logged = _averaged(column, np.where(found, column.values[place], np.nan), recording.t, starts)
        if logged is not None and column.name not in out:
            out[column.name] = logged
    return out


def _may_be_why(column: RawColumn, recording: Recording) -> bool:
    words = words_in(column.name)
    telling = {word for word in words if len(word) > 1 or len(words) == 1}  # motor_u_temperature is no voltage
    unit = column.unit.strip()
    return not (
        (FOLLOWING | COUNTING | FOREIGN) & telling
        or ELECTRIC.fullmatch(unit)
        or recognise(column.name, recording.joints)
        or (unit and recognise(f"{column.name} {unit}", recording.joints))
    )


def _averaged(column: RawColumn, values: Float, t: Float, starts: np.ndarray) -> Logged | None:
    known = np.isfinite(values)
    if known.mean() < KNOWN:
        return None
    count = np.add.reduceat(known, starts, dtype=float)
    there = count > 0.0
    plain = np.where(known, values, 0.0)
    means = (np.add.reduceat(plain, starts) / np.maximum(count, 1.0))[there]
    middle = (np.add.reduceat(np.where(known, t, 0.0), starts) / np.maximum(count, 1.0))[there]
    steady = len(means) > 2 and np.ptp(means) > 0.0 and abs(np.corrcoef(middle, means)[0, 1]) > STEADY
    if steady and not WARM & words_in(column.name):
        return None
    within = plain - np.where(known, np.interp(t, middle, means), 0.0)
    return Logged(middle, means, column.unit.strip(), float(np.sqrt(np.sum(within**2) / known.sum())))
