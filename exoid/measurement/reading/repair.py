"""From columns to a recording: what can be mended without guessing is mended and reported, the rest refused.

Order matters: cells first, then the clock, then angles; each step sees only rows the steps before left valid.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.errors import RecordingError
from exoid.measurement.finding import row_ranges
from exoid.measurement.reading import angles, clock
from exoid.measurement.reading.columns import Assigned, spare_columns
from exoid.measurement.reading.draft import Draft
from exoid.measurement.reading.limits import credible
from exoid.measurement.reading.names import kind_of, recognise
from exoid.measurement.reading.outside import CONTACT, force_columns
from exoid.measurement.reading.raw import RawTable
from exoid.measurement.reading.registers import in_si
from exoid.measurement.reading.units import is_product
from exoid.measurement.recording import Recording, Source, base_columns
from exoid.symbolic.joints import LEG, Joint
from exoid.symbolic.motion import Float
from exoid.symbolic.units import SI_UNIT

CLOSEST = 1e-8
"""s between rows; nothing that moves is sampled at 100 MHz, so the stamps have lost their meaning."""
LEAST_USABLE = 0.1
"""Share of the cells of an angle or a torque below which it is taken for the wrong column."""
UNUSED = "none: the rows do not enter the fit"
ENOUGH = "at least 10 s of motion at 100 Hz is a good start; below 1 s or 50 usable rows nothing can be identified"


NO_FAULTS: Mapping[str, RecordingError] = MappingProxyType({})


def on_one_clock(
    table: RawTable,
    assigned: Mapping[str, Assigned],
    source: Source,
    name: str,
    joints: tuple[Joint, ...] = LEG,
    faults: Mapping[str, RecordingError] = NO_FAULTS,
) -> Draft:
    """Return the columns of `joints` in SI units over a time that runs forwards; RecordingError when too little can be
    used. `faults` are {canonical name: error} of spare columns that are left out, which is noted.
    """
    draft = _mask_cells(_start(table, assigned, source, name, joints, faults), assigned)
    return _clock_unit(_order_time(draft))


def as_recording(draft: Draft, source: Source, name: str) -> Recording:
    """Return the recording, with angles whose jumps and spikes are mended."""
    draft = _angles(draft)
    columns, joints = draft.columns, draft.joints
    pairs: dict[str, Any] = {
        field: np.column_stack([columns[f"{key}{k + 1}"] for k in range(len(joints))])
        for field, key in (("q", "q"), ("tau", "tau"), ("dq", "dq"), ("ddq", "ddq"))
        if f"{key}1" in columns
    }
    angle_valid, torque_valid = (
        np.column_stack([draft.good(f"{key}{k + 1}") for k in range(len(joints))]) for key in ("q", "tau")
    )
    return Recording(
        name, columns["t"], **pairs, valid=draft.valid, source=source, findings=draft.findings, row=draft.row,
        joints=joints, base=_base(columns, joints), angle_valid=angle_valid, torque_valid=torque_valid,
        forces={name: columns[name] for name in force_columns(joints) if name in columns},
        contact=columns.get(CONTACT),
    )  # fmt: skip


def _base(columns: Mapping[str, Float], joints: tuple[Joint, ...]) -> Float | None:
    """Return the motion of the base (N, 3), in space (N, 6), with zero for an acceleration the file does not have; None
    without its angles.
    """
    names = base_columns(joints)
    angles = [name for name, unit in names.items() if unit == "rad"]
    if not columns.keys() >= {*angles}:
        return None
    still = np.zeros_like(columns[angles[0]])
    return np.column_stack([columns.get(name, still) for name in names])


def _start(
    table: RawTable,
    assigned: Mapping[str, Assigned],
    source: Source,
    name: str,
    joints: tuple[Joint, ...],
    faults: Mapping[str, RecordingError],
) -> Draft:
    """Convert units, leave out what not every joint has, say what was taken for what."""
    columns, registers = in_si(assigned, source.path or name, joints)
    told = frozenset(name for name, item in assigned.items() if item.told)
    valid, file = np.ones(table.row.shape[0], dtype=bool), source.path or name
    draft = Draft(columns, valid, table.row, told, file, table.notes, joints)
    for error in faults.values():
        draft = draft.noted("columns", "warning", f"left out, and not needed: {error.what} ({error.remedy})")
    draft = replace(draft, findings=(*draft.findings, *registers))
    epoch = None if "t" in told or "t" not in columns else clock.epoch_unit(columns["t"])
    if epoch:
        first = columns["t"][np.flatnonzero(np.isfinite(columns["t"]))[0]]
        columns = {**columns, "t": (columns["t"] - first) * epoch[1]}
        draft = replace(draft, told=told | {"t"})
        draft = draft.noted("time", "info", f"the time counts {epoch[0]} since 1970; it is read from the first row on")
    renamed = [f"{item.column.name} as {name}" for name, item in assigned.items() if item.column.name != name]
    if renamed:
        draft = draft.noted("columns", "info", f"columns were read {', '.join(renamed)}")
    converted = [_conversion(n, item, joints) for n, item in assigned.items() if item.factor != 1.0]
    if converted:
        draft = draft.noted("units", "info", f"converted to SI: {', '.join(converted)}")
    draft, columns = _outside(draft, columns, table, {*assigned, *faults}, assigned)
    for key in ("dq", "ddq"):
        pair = [n for k in range(len(joints)) if (n := f"{key}{k + 1}") in columns]
        empty = [n for n in pair if np.isfinite(columns[n]).mean() < 0.5]
        if 0 < len(pair) < len(joints) or empty:
            lacking = "its partner is missing" if len(joints) == 2 else "the other joints have none"
            reason = f"{', '.join(empty)} is mostly not numbers" if empty else lacking
            draft = draft.noted("columns", "info", f"{' and '.join(pair)} left out: {reason}")
            columns = {n: v for n, v in columns.items() if n not in pair}
    lacking_angle = [name for name, unit in base_columns(joints).items() if unit == "rad" and name not in columns]
    alone = [name for name in base_columns(joints) if name in columns and lacking_angle]
    if alone:
        missing = " and ".join(lacking_angle)
        draft = draft.noted("columns", "info", f"{' and '.join(alone)} left out: there is no {missing}")
        columns = {n: v for n, v in columns.items() if n not in alone}
    return replace(draft, columns=columns)


def _outside(
    draft: Draft, columns: Mapping[str, Float], table: RawTable, decided: set[str], assigned: Mapping[str, Assigned]
) -> tuple[Draft, dict[str, Float]]:
    """Leave out forces that are mostly not numbers, and say of which columns nobody knows what they are; `decided` are
    the canonical names that have their column, or a fault of it.
    """
    known = sorted(spare_columns(draft.joints))
    empty = [name for name in known if name in columns and np.isfinite(columns[name]).mean() < 0.5]
    if empty:
        draft = draft.noted("columns", "info", f"{' and '.join(empty)} left out: mostly not numbers")
    taken = {id(item.column) for item in assigned.values()}
    meant = [(column.name, recognise(column.name, draft.joints)) for column in table.columns if id(column) not in taken]
    for name in known:
        rivals = [column for column, found in meant if found and found.name == name]
        if rivals and name not in decided:
            what = f"{' and '.join(rivals)} can each be {name}: none of them is used"
            draft = draft.noted("columns", "warning", what, remedy=f"say which: --map {name}={rivals[0]}")
    return draft, {name: values for name, values in columns.items() if name not in empty}


def _conversion(name: str, item: Assigned, joints: tuple[Joint, ...]) -> str:
    """Return "tau1 from Nm/A*0.1*50 (5 N·m per unit)"; the number only where a product was given."""
    if not is_product(item.unit):
        return f"{name} from {item.unit}"
    return f"{name} from {item.unit} ({item.factor:.4g} {SI_UNIT[kind_of(name, joints)]} for 1)"


def _mask_cells(draft: Draft, assigned: Mapping[str, Assigned]) -> Draft:
    """Mask empty, textual, infinite or absurd cells; refuse a column that says next to nothing, or other things.

    A missing angle or torque is masked alone, any other cell with its row.
    """
    columns = dict(draft.columns)
    reported: dict[bytes, list[str]] = {}
    told = draft
    for name, values in draft.columns.items():
        bad = ~credible(values, time=name == "t")
        if bad.any():
            reported.setdefault(np.packbits(bad).tobytes(), []).append(name)
            columns[name] = np.where(bad, np.nan, values)
            draft = draft.without(name, bad)
        wrong = int(np.count_nonzero(bad & ~np.isnan(values))) + assigned[name].column.text_count
        few = np.count_nonzero(~bad) < max(10.0, LEAST_USABLE * bad.size) if name in draft.own else bad.mean() > 0.5
        if few or wrong > 0.5 * bad.size:
            what, shown, rows = _bad_cells(told, [name], assigned)
            remedy = f"is this the right column? --map {name}=COLUMN names another"
            where = f"{draft.file}, column {shown}, {row_ranges(np.sort(draft.row[rows]))}"
            raise RecordingError(what, where=where, remedy=remedy)
    for names in reported.values():
        what, shown, bad = _bad_cells(told, names, assigned)
        alone = draft.own.issuperset(names)
        remedy = "nothing, if the rows are few; otherwise look at the logger"
        if alone and bad.mean() > 0.5:
            remedy = f"is this the right column? --map {names[0]}=COLUMN names another"
        said = "these cells are masked" if alone else "these rows are masked"
        used = "none: the cells do not enter the fit" if alone else UNUSED
        draft = draft.mended("cells", f"{what}; {said}", bad, remedy, shown, consequence=used)
    if draft.valid.sum() < 10:
        raise RecordingError(f"only {int(draft.valid.sum())} usable rows", where=draft.file, remedy=ENOUGH)
    return replace(draft, columns=columns)


def _bad_cells(
    draft: Draft, names: list[str], assigned: Mapping[str, Assigned]
) -> tuple[str, str, NDArray[np.bool_]]:
    """Return the fault of the columns `names`, which are bad in the same rows, their names in the file, and the bad
    rows (N,).
    """
    values = np.column_stack([draft.columns[name] for name in names])
    endless = ~credible(values) & ~np.isnan(values)
    bad = ~credible(values[:, 0], time=names == ["t"])
    text = sum(assigned[name].column.text_count for name in names)
    missing = int(np.isnan(values).sum()) - text
    counts = (
        (text, "text"),
        (int((endless & bad[:, None]).sum()), "infinite or absurd"),
        (missing, "empty or NaN"),
    )
    kinds = ", ".join(f"{count} {label}" for count, label in counts if count > 0)
    texts = [item for name in names for item in assigned[name].column.texts.items()][:1]
    example = "".join(f", for example {cell!r} in row {draft.row[index]}" for index, cell in texts)
    label = ", ".join(names)
    what = f"{int(bad.sum())} of {bad.size} cells of {label} are not usable numbers ({kinds}{example})"
    shown = ", ".join(repr(assigned[name].column.name) for name in names)
    return what, shown, bad


def _order_time(draft: Draft) -> Draft:
    """Bring the rows into strictly increasing time."""
    t = draft.columns["t"]
    found = clock.put_in_order(t, np.isfinite(t))
    count = t.shape[0]
    if found.kind == "constant":
        raise RecordingError(
            "the time is the same in every row",
            where=f"{draft.file}, column t",
            remedy="is this the time column? --map t=COLUMN",
        )
    if found.kind == "restart":
        back = np.flatnonzero(np.diff(t) < 0)
        raise RecordingError(
            "the clock starts again within the file: it holds more than one recording",
            where=f"{draft.file}, {row_ranges(draft.row[back + 1])}",
            remedy="cut it into one file per recording and give them all",
        )
    fresh = found.bad & np.isfinite(t[found.order])
    moved = draft.row[found.order] != draft.row
    draft = draft.rows(found.order)
    draft = replace(draft, valid=draft.valid & ~found.bad)
    if found.kind in ("sorted", "reversed"):
        if found.kind == "reversed":
            what = "time runs backwards through the file; the rows were turned round, and with them every velocity"
            remedy = "nothing, if the file was written last row first; if its rows are in the order in which they "
            remedy += "were measured and the clock counts down, give a time that counts up"
            consequence = "in the other case every velocity, and with it friction, has the wrong sign"
            said: dict[str, Any] = {"remedy": remedy, "consequence": consequence, "confidence": "likely"}
            draft = draft.noted("time", "warning", what, value=float(moved.sum()), limit=0.0, **said)
        else:
            what = f"{int(moved.sum())} rows stood out of order; they were sorted by time"
            draft = draft.noted("time", "repaired", what, value=float(moved.sum()), limit=0.0, remedy="nothing")
    if found.kind == "ticks":
        return _ticks(draft)
    if fresh.any():
        what = f"time repeats or goes back in {int(fresh.sum())} of {count} rows; they are masked"
        draft = draft.mended("time", what, fresh, "nothing, if the rows are few", consequence=UNUSED)
    stamps = clock.fill_stamps(_since_start(draft.columns["t"]), found.bad)
    even = None if found.bad.any() else clock.even_behind(stamps)
    if even is None:
        return _stamped(draft, stamps)
    return _evenly(draft, "the clock was written with too few digits", even)


def _ticks(draft: Draft) -> Draft:
    """Several rows share each stamp: drop exact repeats, space what differs evenly between the ticks."""
    keep = draft.valid | np.isfinite(draft.columns["t"])
    cells = np.column_stack(list(draft.columns.values()))
    same = np.r_[False, np.all(cells[1:] == cells[:-1], axis=1)]
    if same.mean() > 0.2:
        what = f"{int(same.sum())} rows repeat the row before in every cell; they are left out"
        draft = draft.mended("time", what, same, "log each sample once")
        keep &= ~same
    draft = draft.rows(keep)
    t = _since_start(draft.columns["t"])
    repeats = float(np.mean(np.diff(t) == 0))
    if not repeats > 0:
        return _stamped(draft, t)
    what = f"{repeats:.0%} of the rows carry the time of the row before: the clock was written with too few digits"
    found = clock.even_behind(t)
    if found is not None:
        return _evenly(draft, what, found)
    spread = clock.spread_ticks(t)
    tick = float(np.median(np.diff(np.unique(t)))) * _clock_scale(draft, spread)[1]
    if tick > clock.COARSE:
        raise RecordingError(
            f"{what}: its ticks are {tick:.3g} s apart, and no evenly spaced samples agree with them",
            where=f"{draft.file}, column t",
            remedy="log the time with microseconds, or name another column that has them: --map t=COLUMN",
        )
    draft = draft.noted(
        "time", "warning", f"{what}; these rows were spaced evenly between its ticks", value=repeats, limit=0.0,
        remedy="log the time with microseconds",
        consequence="velocities and accelerations get the error of the spacing", confidence="likely",
    )  # fmt: skip
    return _stamped(draft, spread)


def _evenly(draft: Draft, what: str, even: Float) -> Draft:
    """Return the draft with its samples evenly spaced, which the stamps agree with."""
    step = float(even[-1] - even[0]) / (even.size - 1) * _clock_scale(draft, even)[1]
    what += f"; all of them agree with samples spaced evenly at {1.0 / step:.4g} Hz, and so they are taken"
    consequence = "if the samples were not evenly spaced, velocities and accelerations are wrong"
    said: dict[str, Any] = {"remedy": "log the time with microseconds", "consequence": consequence}
    return _stamped(draft.noted("time", "warning", what, value=step, confidence="likely", **said), even)


def _clock_scale(draft: Draft, t: Float) -> tuple[str, float]:
    """Return the unit of the clock that reads `t` (N,), and how many s it is."""
    if "t" in draft.told:
        return "s", 1.0
    names = [f"q{k + 1}" for k in range(len(draft.joints))]
    known = np.logical_and.reduce([draft.good(name) for name in names])
    return clock.clock_unit(t[known], np.column_stack([draft.columns[name] for name in names])[known])


def _since_start(t: Float) -> Float:
    """Return `t` as logged, counted from the first stamp when it is a date (seconds since 1970 lose
    digits)."""
    first = float(t[np.flatnonzero(np.isfinite(t))[0]])
    return t - first if abs(first) > 1e6 else t


def _stamped(draft: Draft, t: Float) -> Draft:
    steps = np.diff(t)
    if np.any(steps <= 0) or np.median(steps) < CLOSEST:
        what = "time stamps are too close together to be distinguished"
        remedy = "log the time in seconds with at least six decimals"
        raise RecordingError(what, where=f"{draft.file}, column t", remedy=remedy)
    return replace(draft, columns={**draft.columns, "t": t})


def _clock_unit(draft: Draft) -> Draft:
    """Convert a clock that can only be in ms or µs, unless somebody said its unit."""
    draft = replace(
        draft, columns={n: angles.fill(v, draft.good(n)) if n != "t" else v for n, v in draft.columns.items()}
    )
    if "t" in draft.told or draft.valid.sum() < 10:
        return draft
    t = draft.columns["t"]
    unit, scale = _clock_scale(draft, t)
    step = float(np.median(np.diff(t)))
    if unit == "index":
        what = "the time column counts 0, 1, 2, ...: milliseconds at 1 kHz or row numbers?"
        remedy = "say how often it was sampled: --rate 100 for a row every 10 ms, or what one count is: --units t=ms"
        return draft.noted("time", "refused", what, "column t", value=step, limit=0.5, remedy=remedy)
    if unit == "s":
        return draft
    what = f"the median time step is {step:.4g}, impossible in seconds for these angles: the clock was read in {unit} "
    what += f"({1 / (step * scale):.4g} Hz)"
    remedy = f"if that is wrong, say so with --units t=s; header 't [{unit}]' avoids the question"
    said: dict[str, Any] = {"value": step, "limit": 0.5, "remedy": remedy, "confidence": "likely"}
    draft = draft.noted("time", "repaired", what, "column t", **said)
    return _stamped(draft, t * scale)


def _angles(draft: Draft) -> Draft:
    """Unwrap jumps of a full turn and mask single-sample spikes of the encoders."""
    for k, joint in enumerate(draft.joints):
        name = f"q{k + 1}"
        values, wraps = angles.unwrapped(draft.columns[name], draft.good(name))
        if not joint.turns:
            values = draft.columns[name]
        elif wraps.any():
            what = f"{name} jumps by a full turn {int(wraps.sum())} times; it was unwrapped"
            draft = draft.mended("wraps", what, wraps, "nothing", name)
        spikes = angles.angle_spikes(values, draft.good(name))
        if spikes.any():
            what = f"{name} has {int(spikes.sum())} spikes of one or two samples; they are masked"
            remedy = "look at the encoder cable"
            draft = draft.mended("spikes", what, spikes, remedy, name, consequence=UNUSED, confidence="likely")
            draft = draft.without(name, spikes)
            values = angles.fill(values, draft.good(name))
        draft = replace(draft, columns={**draft.columns, name: values})
    return draft
