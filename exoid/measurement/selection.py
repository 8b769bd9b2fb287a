"""Rows of a recording that may be explained: `--only "contact == 0"`, and the swings where stance is not measured.

What is left out are the torques: angles go on through it, so that their derivatives are those of the whole motion.
"""

from __future__ import annotations

import operator
import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from exoid.ground.errors import RecordingError
from exoid.ground.suggest import did_you_mean
from exoid.measurement.auditing.checks.length import LEAST_ROWS
from exoid.measurement.finding import SELECTION, Finding
from exoid.measurement.reading.outside import CONTACT, GROUND
from exoid.measurement.reading.raw import RawTable
from exoid.measurement.recording import Recording
from exoid.measurement.signals.masks import widen
from exoid.measurement.stance import load_level
from exoid.symbolic.motion import Float

MARGIN = 0.04
"""s on either side of contact that belong to it: a switch closes at some load, and not at the first touch."""
WAYS: Mapping[str, Callable[[Float, float], NDArray[np.bool_]]] = {
    "==": operator.eq, "!=": operator.ne, "<=": operator.le, ">=": operator.ge, "<": operator.lt, ">": operator.gt,
}  # fmt: skip
_ONE = re.compile(r"\s*(?P<name>.+?)\s*(?P<way>==|!=|<=|>=|<|>)\s*(?P<value>[-+.\deE]+)\s*")
REMEDY = 'write a column, ==, !=, <, <=, > or >=, and a number; several joined by "and": "contact == 0 and t < 20"'


@dataclass(frozen=True)
class Condition:
    """The rows in which `column` compares (`way`, a key of WAYS) with `value`."""

    column: str
    way: str
    value: float


def conditions(text: str) -> tuple[Condition, ...]:
    """Return the conditions in `text`, "contact == 0 and t < 20", which must all hold; RecordingError for others."""
    found = []
    for part in re.split(r"\s+and\s+", text.strip()):
        match = _ONE.fullmatch(part)
        try:
            value = float(match["value"]) if match else np.nan
        except ValueError:
            value = np.nan
        if match is None or not np.isfinite(value):
            raise RecordingError(f"{part[:60]!r} is no condition on a column", where="--only", remedy=REMEDY)
        found.append(Condition(match["name"].strip("'\""), match["way"], value))
    return tuple(found)


def selected(recording: Recording, table: RawTable, only: str) -> Recording:
    """Return `recording` with the torques of the rows for which `only` holds; without a word, those of the swings where
    the foot's contact is known and the force of the ground is not.

    Columns are those of the file, `table`, by their names there, or the recording's by exoid's. RecordingError where
    there is no such column, or nothing is left.
    """
    if not only:
        return swings(recording)
    kept = np.ones(len(recording), dtype=bool)
    for condition in conditions(only):
        values = _column(recording, table, condition.column)
        kept &= np.isfinite(values) & WAYS[condition.way](values, condition.value)
    if (left := int((kept & recording.complete).sum())) < LEAST_ROWS:
        what = f"only {left} usable rows are left for which {only}: too few to identify anything"
        raise RecordingError(what, where=recording.source.path or recording.name, remedy="ask for other rows")
    share = f"{100 * kept.mean():.0f} % of the torques are used, those for which {only}"
    return _without(recording, ~kept, f"{share}; angles are used throughout", "ask otherwise with --only")


def _column(recording: Recording, table: RawTable, name: str) -> Float:
    """Return a column (N,) at the rows of `recording`; RecordingError where nothing is called so."""
    own = recording.columns()
    if name in own:
        return own[name]
    for column in table.columns:
        if column.name == name:
            order = np.argsort(table.row, kind="stable")
            place = order[np.clip(np.searchsorted(table.row[order], recording.row), 0, len(order) - 1)]
            return np.where(table.row[place] == recording.row, column.values[place], np.nan)
    known = [*table.names, *(each for each in own if each not in table.names)]
    what = f"there is no column {name!r}"
    remedy = did_you_mean(name, known) or f"its columns are {', '.join(known[:20])}"
    raise RecordingError(what, where=f"{recording.source.path or recording.name}, --only", remedy=remedy)


def swings(recording: Recording) -> Recording:
    """Return a recording without the torques of stance, where that is known and the ground's force is not."""
    contact = recording.contact
    if contact is None or any(name in recording.forces for name in GROUND):
        return recording
    where = recording.source.path or recording.name
    low, high, level = load_level(contact[recording.valid])
    stance = widen(contact > level, round(MARGIN * recording.rate))
    if not low < high or np.count_nonzero(recording.complete & ~stance) < LEAST_ROWS:
        what = f"{CONTACT} hardly changes: it does not say when the foot is in the air, and nothing is left out by it"
        found = Finding(SELECTION, "warning", what, where, remedy="look at the foot switch and its cable")
        return recording.with_findings((*recording.findings, found))
    what = (
        f"the force of the ground is not measured: the torques of stance ({CONTACT} above {level:.3g}, "
        f"{100 * stance.mean():.0f} % of the rows) are left out, angles are used throughout"
    )
    return _without(recording, stance, what, f'to use all rows: --only "{CONTACT} >= {min(low, 0.0):g}"')


def _without(recording: Recording, hidden: NDArray[np.bool_], what: str, remedy: str) -> Recording:
    """Return `recording` without the torques in the rows `hidden` (N,), and say so."""
    found = Finding(
        SELECTION, "repaired", what, recording.source.path or recording.name, float(hidden.mean()), None, remedy,
        consequence="what happens there is not seen",
    )  # fmt: skip
    torque = recording.torque_valid & ~hidden[:, None]
    return replace(recording, torque_valid=torque, findings=(*recording.findings, found))
