"""One trial in several files with clocks of their own: motion capture here, torque there.

The clock of the file with the angles counts. What stands in another file comes onto it at the lag that was given, or
that the two clocks share, or that physics says (`lag.py`); rows that the other file does not cover are masked.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.measurement.finding import Finding
from exoid.measurement.reading import clock
from exoid.measurement.reading.columns import OF_JOINTS, assign, canonical_columns
from exoid.measurement.reading.lag import Lag, lag_between
from exoid.measurement.reading.mapping import StatedMapping
from exoid.measurement.reading.names import kind_of
from exoid.measurement.reading.raw import RawColumn, RawTable
from exoid.measurement.reading.registers import in_si
from exoid.measurement.reading.resample import onto
from exoid.symbolic.joints import LEG, Joint
from exoid.symbolic.motion import Float
from exoid.symbolic.units import SI_UNIT

ABSOLUTE_MOST = 2.0
"""s: how far physics looks around clocks that both count from 1970."""


@dataclass(frozen=True, eq=False)
class JoinedFile:
    """One of the files: its columns {canonical: (N,)} in SI, its clock in s, whether that counts from 1970."""

    where: str
    t: Float
    columns: Mapping[str, Float]
    absolute: bool
    table: RawTable


def joined_pieces(
    tables: Sequence[tuple[RawTable, str, float | None, StatedMapping]], joints: tuple[Joint, ...] = LEG
) -> RawTable:
    """Return one table, with canonical names in SI, of (table, path, lag in s or None, what is told).

    The first is the recording, the others are joined to it.

    A lag is what the other clock reads more than that of the recording at the same instant. RecordingError where the
    files do not complete each other, or nothing says how their clocks belong together.
    """
    pieces = [_piece(table, where, told, joints) for table, where, _, told in tables]
    angles = [f"q{k + 1}" for k in range(len(joints))]
    base = next((piece for piece in pieces if {*angles} <= set(piece.columns)), None)
    if base is None:
        remedy = f"name the columns with --map {','.join(f'{name}=COLUMN' for name in angles)}"
        raise RecordingError("none of the files has the angles of all joints", where=pieces[0].where, remedy=remedy)
    given = {id(piece): lag for piece, (_, _, lag, _) in zip(pieces, tables, strict=True)}
    columns = dict(base.columns)
    notes = [note for piece in pieces for note in piece.table.notes]
    for piece in pieces:
        if piece is base:
            continue
        # A lag that was given is that of a joined file behind the recording, which need not have the angles.
        told = given[id(piece)] if base is pieces[0] else _opposite(given[id(base)]) if piece is pieces[0] else None
        lag, note = _lag(base, piece, told, len(joints))
        notes.append(note)
        for name, values in piece.columns.items():
            if name not in columns:
                columns[name] = onto(base.t + lag, piece.t, values)
    covered = [np.isfinite(values) for name, values in columns.items() if name not in base.columns]
    if covered and not np.any(np.all(covered, axis=0)):
        what = "the files do not overlap in time"
        raise RecordingError(what, where=base.where, remedy="are these files of the same trial?")
    first = base.t[0]
    made = [RawColumn("t", base.t - first, "s")]
    made += [
        RawColumn(name, columns[name], SI_UNIT[kind_of(name, joints)])
        for name in canonical_columns(joints)
        if name in columns
    ]
    return RawTable(tuple(made), base.table.row, tuple(notes))


def _opposite(lag: float | None) -> float | None:
    return None if lag is None else -lag


def _piece(table: RawTable, where: str, told: StatedMapping, joints: tuple[Joint, ...]) -> JoinedFile:
    """Return the columns of one file that are recognised or mapped, in SI, with its clock."""
    known = (*OF_JOINTS, *canonical_columns(joints))
    mapping = {name: column for name, column in told.columns.items() if column.partition("#")[0] in table.names}
    units = {name: unit for name, unit in told.units.items() if name in known or name in table.names}
    found = assign(table, replace(told, columns=mapping, units=units), where=where, joints=joints, partial=True)
    if "t" not in found or len(found) < 2:
        lacks = "no time" if "t" not in found else "neither angles nor torques"
        what = f"{lacks} was found in the file"
        raise RecordingError(what, where=where, remedy="say which column it is: --map t=COLUMN, q1=COLUMN, ...")
    columns, mended, _ = in_si(found, where, joints)
    table = replace(table, notes=(*table.notes, *(Finding("registers", "repaired", what, where) for what in mended)))
    t = columns.pop("t")
    epoch = None if found["t"].told else clock.epoch_unit(t)
    if epoch:
        t = t * epoch[1]
    elif not found["t"].told:
        t = t * _unit(t, columns, where)
    return JoinedFile(where, t, columns, epoch is not None, table)


def _unit(t: Float, columns: Mapping[str, Float], where: str) -> float:
    """Return the factor to seconds of a clock without a unit."""
    signals = np.column_stack(list(columns.values()))
    good = np.isfinite(t) & np.isfinite(signals).all(axis=1)
    if good.sum() < 10 or not np.any(np.diff(t[good]) > 0):
        raise RecordingError("the clock does not run", where=where, remedy="is this the time? --map t=COLUMN")
    unit, scale = clock.clock_unit(t[good], signals[good])
    if unit == "index":
        what = "the time column counts 0, 1, 2, ..."
        raise RecordingError(what, where=where, remedy="say what one count is: --units 't=10 ms'")
    return scale


def _lag(base: JoinedFile, piece: JoinedFile, told: float | None, count: int) -> tuple[float, Finding]:
    """Return the lag in s of the clock of `piece` behind that of `base`, and what to say about it."""
    numbers = range(1, count + 1)
    names = [name for key in ("tau", "q") for k in numbers if (name := f"{key}{k}") in piece.columns]
    shared = base.absolute and piece.absolute
    start = 0.0 if shared else float(np.nanmin(piece.t) - np.nanmin(base.t))
    found = Lag(0.0, -np.inf, np.inf, 1.0, "the file holds neither torques nor angles")
    if names:
        signals = np.column_stack([piece.columns[name] for name in names])
        angles = np.column_stack([base.columns[f"q{k}"] for k in numbers])
        origin = np.nanmin(base.t)
        # Far apart by their start: searched around it, so that any two clocks can be compared.
        far = start if abs(start) > 30.0 else 0.0
        found = lag_between(base.t - origin, angles, piece.t - origin - far, signals, ABSOLUTE_MOST if shared else 60.0)
        found = Lag(found.value + far, found.low + far, found.high + far, found.left, found.why)
    seen = f"{found.value:.4f} s (95 %: {found.low:.4f} to {found.high:.4f})"
    where = piece.where
    if told is not None:
        apart = not found.why and not found.low <= told <= found.high
        more = f"; physics says {seen}" if not found.why else ""
        return told, Finding(
            "join", "warning" if apart else "repaired", f"joined to {base.where} at the given lag of {told:g} s{more}",
            where, told, remedy="give the lag that physics says, or none" if apart else "nothing",
        )  # fmt: skip
    if shared:
        apart = not found.why and not found.low <= 0.0 <= found.high
        more = f"; physics says a lag of {seen}" if not found.why else f"; physics cannot check it: {found.why}"
        return 0.0, Finding(
            "join", "warning" if apart else "repaired", f"joined to {base.where} on the time since 1970{more}",
            where, found.value,
            remedy=f"do the clocks differ? --join {where}@{found.value:.4f}" if apart else "nothing",
        )  # fmt: skip
    if found.why:
        raise RecordingError(
            f"nothing says how its clock and that of {base.where} belong together: {found.why}",
            where=where,
            remedy=f"--join {where}@LAG, the seconds its clock reads more at the same instant (0: they share a clock)",
        )
    value = 0.0 if found.low <= 0.0 <= found.high else found.value
    what = "on their common time, the lag by physics being" if value == 0.0 else "at the lag that physics says,"
    return value, Finding(
        "join", "repaired", f"joined to {base.where} {what} {seen}; {found.left:.1%} are left unexplained at it",
        where, found.value, remedy=f"if it is known better: --join {where}@LAG", confidence="likely",
    )  # fmt: skip
