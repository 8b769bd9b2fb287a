"""Read a recording: find the format, name the columns, mend what can be mended safely, audit, or refuse.

`_finished` goes the way of every file: names, clock, repair, and then what the samples as a whole say of the channels.

The file itself is only ever opened for reading.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from types import ModuleType
from typing import Any, TypedDict, Unpack

from exoid.ground.errors import RecordingError, StandingError, refused
from exoid.ground.files import sha256
from exoid.ground.inputs import open_input
from exoid.ground.progress import Progress
from exoid.ground.text import printable
from exoid.measurement.auditing.audit import audit
from exoid.measurement.auditing.degrees import read_degrees
from exoid.measurement.auditing.unusable import mask_unusable, without_rounding
from exoid.measurement.finding import Finding
from exoid.measurement.reading.among import read_among
from exoid.measurement.reading.columns import assign_usable, inferred, legs
from exoid.measurement.reading.conventions import read_as
from exoid.measurement.reading.frames import is_table, table_from
from exoid.measurement.reading.join import joined_pieces
from exoid.measurement.reading.large import in_stretches
from exoid.measurement.reading.logged import logged_columns
from exoid.measurement.reading.long_table import widened
from exoid.measurement.reading.made_times import join_split
from exoid.measurement.reading.mapping import FILE, StatedMapping, remembered
from exoid.measurement.reading.raw import RawTable
from exoid.measurement.reading.repair import as_recording, on_one_clock
from exoid.measurement.reading.sources import digest, find_formats, folder_of, opened
from exoid.measurement.recording import Recording, Source
from exoid.measurement.selection import selected
from exoid.symbolic.joints import LEG, Joint

Joined = str | Path | tuple[str | Path, float | None]
Machine = tuple[Joint, ...] | None
LARGE, PIECES, SMALL = 400_000_000, 16, 1_000_000
"""Bytes of text that are still read as a whole; into how many pieces so many are cut where they are not; and the least
that is worth a look."""
LEAST_RATE, MOST_RATE = 0.1, 1e6
"""Hz that may be said of a recording."""
LEGS = ("left", "right", "ipsi", "contra", "both")


class HowRead(TypedDict, total=False):
    """Options of reading recordings beside their columns and units, as `read_recording` explains it."""

    leg: str | None
    convention: str | Iterable[str]
    join: str | Path | Sequence[Joined]
    only: str
    passive: str | Sequence[str]
    rate: float


def read_recording(
    source: Any,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    *,
    name: str = "",
    joints: Sequence[Joint] | None = None,
    **more: Unpack[HowRead],
) -> Recording:
    """Return the recording `source`, in SI units, audited.

    `source` is a path (also `archive.zip/run1.csv`) or a table in memory: a pandas or polars DataFrame, an array (N, 1
    + 2 J) with the columns t, q1, ..., tau1, ..., a structured one, an xarray Dataset, a mapping {name: array}.
    `columns` maps canonical names to columns of the file ({"q1": "HipEnc"}), `units` gives the unit of a quantity or
    column ({"q": "deg", "tau1": "Nm/A*0.1*50"}), `leg` ("left" or "right") says which one where both are in it,
    `convention` how angles and torques are counted ("flexion-positive", "absolute-shank,hip-from-upright";
    `exoid.measurement.reading.conventions`). What is not given is taken from `exoid.toml` beside the file, if that
    knows its columns. Rows with a cell that is not a number are masked in `valid`, never dropped. `join` are further
    files of the same trial with clocks of their own, or pairs (file, what its clock reads more in s); see
    `exoid.measurement.reading.join`. `only` ("contact == 0") says of which rows the torques are explained; unless it is
    given, those of stance are left out where a column says when the foot is on the ground and none what the ground does
    (`exoid.measurement.selection`). `passive` are joints that had no drive: their torque is zero and needs no
    column. `rate` in Hz says how often a recording without a clock was sampled, evenly.
    `columns` may name a product, {"tau1": "duty*volts"}, whose unit `units` gives. `joints` are those of the
    machine (`model.joints`); None means the leg's, or as many as the file has q1, q2, ... and tau1, tau2, .... Raises
    RecordingError for anything that cannot be used, with the place and the remedy.
    """
    told = how_read(columns, units, **more)
    if told.leg not in ("", *LEGS):
        raise RecordingError(f"leg is {told.leg[:20]!r}", where="leg", remedy=f"one of {', '.join(LEGS)}")
    machine = None if joints is None else tuple(joints)
    table, origin, name, told = _whole(source, told, name, machine)
    if told.leg == "both":
        what = "both legs are two recordings"
        raise RecordingError(what, where=origin.path or name, remedy="read_recordings([...], leg='both')")
    return _finished(table, origin, name, told, machine)


def read_recordings(
    sources: Any,
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    *,
    joints: Sequence[Joint] | None = None,
    most_bytes: int = LARGE,
    progress: Progress | None = None,
    **more: Unpack[HowRead],
) -> tuple[Recording, ...]:
    """Return the recordings in `sources`: one or several files, folders, patterns ("runs/*.csv"), ZIP archives, and
    tables in memory.

    What stands in a folder, a pattern or an archive beside recordings is left out, and the first recording's findings
    say how much of what. `leg` "both" gives two recordings of every file with both legs. A text or Parquet file of more
    than `most_bytes` is read piece by piece, in bounded memory, and becomes several recordings, stretches spread over
    it (`exoid.measurement.reading.large`); `progress(share, text)` is called meanwhile. Otherwise as `read_recording`,
    whose `leg`, `convention`, `join`, `only`, `passive` and `rate` it takes too.
    """
    told = how_read(columns, units, **more)
    single = isinstance(sources, (str, Path)) or is_table(sources) or not isinstance(sources, Iterable)
    parts = [sources] if single else list(sources)
    wrong = next((part for part in parts if not (isinstance(part, (str, Path)) or is_table(part))), None)
    if wrong is not None:
        remedy = "give paths, folders, patterns, ZIP archives or tables"
        raise RecordingError(f"a {type(wrong).__name__} is not read as a recording", remedy=remedy)
    tables = sum(map(is_table, parts))
    if not tables:
        return read_among(parts, lambda path: read_as_told(path, told, joints, progress, most_bytes))
    machine = None if joints is None else tuple(joints)
    found: list[Recording] = []
    for place, part in enumerate(parts, start=1):
        if is_table(part):
            found += _of_every_leg(part, told, machine, f"table {place}" if tables > 1 else "")
        else:
            found += read_among([part], lambda path: read_as_told(path, told, joints, progress, most_bytes))
    return tuple(found)


def how_read(
    columns: Mapping[str, str] | None = None,
    units: Mapping[str, str] | None = None,
    leg: str | None = None,
    convention: str | Iterable[str] = (),
    join: str | Path | Sequence[Joined] = (),
    only: str = "",
    passive: str | Sequence[str] = (),
    rate: float = 0.0,
) -> StatedMapping:
    """Return the statements about how to read; CallError for what cannot be said."""
    called = convention if isinstance(convention, str) else ",".join(convention)
    files = [join] if isinstance(join, (str, Path)) else join
    pairs = (other if isinstance(other, tuple) else (other, None) for other in files)
    others = tuple((str(file), lag) for file, lag in pairs)
    idle = (passive,) if isinstance(passive, str) else tuple(passive)
    if not (rate == 0.0 or LEAST_RATE <= rate <= MOST_RATE):
        what = f"a rate of {rate:g} Hz is that of no recording"
        raise RecordingError(what, where="rate", remedy=f"give it in Hz, from {LEAST_RATE:g} to {MOST_RATE:g}")
    return StatedMapping(dict(columns or {}), dict(units or {}), leg or "", called, others, idle, only=only, rate=rate)


def read_as_told(
    path: str | Path,
    told: StatedMapping,
    joints: Sequence[Joint] | None = None,
    progress: Progress | None = None,
    most_bytes: int = LARGE,
) -> tuple[Recording, ...]:
    """Return the recordings in one file as `read_recordings` does, with the masses that are `told` of."""
    machine = None if joints is None else tuple(joints)
    found = () if told.join else _in_pieces(Path(path), told, machine, progress, most_bytes)
    found = found or _of_every_leg(path, told, machine)
    for load in told.payloads:
        found = tuple(item.with_payload(load.mass, load.along, load.link) for item in found)
    return found


def _of_every_leg(source: Any, told: StatedMapping, machine: Machine, name: str = "") -> tuple[Recording, ...]:
    """Return the recording in a file or a table, or those of both legs where that is told."""
    table, origin, name, told = _whole(source, told, name, machine)
    if told.leg != "both":
        return (_finished(table, origin, name, told, machine),)
    if set(told.columns) - {"t"}:
        what = "--map names the columns of one leg"
        raise RecordingError(what, where=origin.path or name, remedy="read --leg left and --leg right one by one")
    sides = legs(table, machine or LEG)
    if not sides:
        what = "no leg has all its angles and torques in this file"
        raise RecordingError(what, where=origin.path or name, remedy="read one leg, with --map")
    return tuple(_finished(table, origin, f"{name} ({side})", replace(told, leg=side), machine) for side in sides)


def _in_pieces(
    path: Path, told: StatedMapping, machine: Machine, progress: Progress | None, most: int
) -> tuple[Recording, ...]:
    """Return the stretches of a file that is too long for memory; nothing where it is not, or cannot be cut."""
    with opened(path) as real:
        chosen = None if real.is_dir() or real.stat().st_size < SMALL else _format_of(real)
        if chosen is None or not hasattr(chosen, "pieces") or not chosen.is_large(real, most):
            return ()
        if told.leg == "both":
            what = "a file so long is read for one leg at a time"
            raise RecordingError(what, where=str(path), remedy="--leg left or --leg right")
        origin, home = Source(str(path), digest(real)), folder_of(path)
        said: list[Finding] = []
        kept: StatedMapping | None = None

        def finish(table: RawTable) -> Recording:
            nonlocal kept
            table = join_split(widened(table))
            if kept is None:
                found = remembered(home, table.names)
                kept = told.over(found) if found else told
                if found:
                    said.append(_note(home, found, path))
            return _finished(table, origin, printable(path.stem), kept, machine)

        size = max(SMALL, most // PIECES)
        name = printable(path.stem)
        out = in_stretches(chosen.pieces(real, size), finish, name=name, where=str(path), progress=progress)
        return (out[0].with_findings((*said, *out[0].findings)), *out[1:])


def _note(home: Path, kept: StatedMapping, path: Path) -> Finding:
    return Finding(
        "mapping", "info", f"columns as kept in {home / FILE}: {kept}", str(path),
        remedy="--map, --units and --leg come before it",
    )  # fmt: skip


def _whole(
    source: Any, told: StatedMapping, name: str, machine: Machine
) -> tuple[RawTable, Source, str, StatedMapping]:
    """Return the result of `_loaded`, with the files that are joined to it."""
    table, origin, name, told = _loaded(source, told, name, machine)
    if not told.join:
        return table, origin, name, told
    if told.leg == "both":
        what = "files are joined for one leg at a time"
        raise RecordingError(what, where=origin.path or name, remedy="--leg left or --leg right")
    pieces: list[tuple[RawTable, str, float | None, StatedMapping]] = [(table, origin.path or name, None, told)]
    sums = [origin.sha256]
    for file, lag in told.join:
        more, place, label, kept = _loaded(file, told, "")
        pieces.append((more, place.path or label, lag, kept))
        sums.append(place.sha256)
    joined = joined_pieces(pieces, machine or LEG)
    # Two recordings of the same files share their samples; with other files joined, they are another recording.
    return (
        joined, Source(origin.path, sha256("".join(sums))), name,
        replace(told, columns={}, units={}, leg="", rate=0.0),
    )  # fmt: skip


def _loaded(
    source: Any, told: StatedMapping, name: str, machine: Machine = None
) -> tuple[RawTable, Source, str, StatedMapping]:
    """Return the table of `source`, where it came from, its name, and all that is said of its columns."""
    if not isinstance(source, (str, Path)):
        count = None if machine is None else len(machine)
        return join_split(widened(table_from(source, name or "table", count))), Source(), name or "table", told
    path = Path(source)
    with opened(path) as real:
        origin = Source(str(path), digest(real))
        table = join_split(widened(read_table(real, str(path))))
    home = folder_of(path)
    kept = remembered(home, table.names)
    if kept:
        table = replace(table, notes=(*table.notes, _note(home, kept, path)))
    return table, origin, name or printable(path.stem), told.over(kept) if kept else told


def _finished(table: RawTable, origin: Source, name: str, told: StatedMapping, machine: Machine) -> Recording:
    """Return the audited recording in `table`; RecordingError for what refuses it."""
    joints = machine or (LEG if told.columns else inferred(table))
    where = origin.path or name
    assigned, faults = assign_usable(table, told, where=where, joints=joints, modelled=machine is not None)
    draft = read_degrees(on_one_clock(table, assigned, origin, name, joints, faults), assigned)
    recording = as_recording(draft, origin, name).with_passive(*told.passive)
    used = {id(part) for item in assigned.values() for part in (item.column, *item.column.factors)}
    recording = replace(recording, logged=logged_columns(table, recording, used))
    recording = read_as(mask_unusable(without_rounding(recording)), told.convention)
    recording = selected(recording, table, told.only)
    recording = recording.with_findings(audit(recording))
    refuse(recording.findings)
    return recording


def open_table(path: str | Path) -> RawTable:
    """Return the columns of a file as they stand in it; RecordingError where it cannot be read."""
    with opened(Path(path)) as real:
        return join_split(widened(read_table(real, str(path))))


def refuse(findings: tuple[Finding, ...]) -> None:
    """Raise RecordingError for the first finding of severity "refused", naming how many others there are."""
    refused = [finding for finding in findings if finding.severity == "refused"]
    if refused:
        more = (
            f" (and {len(refused) - 1} further reasons: {'; '.join(f.what for f in refused[1:])})"
            if refused[1:]
            else ""
        )
        still = refused[0].check == "motion" and (refused[0].limit or 0.0) > 0.0  # the angles stand, not only torques
        error = StandingError if still else RecordingError
        raise error(refused[0].what + more, where=refused[0].where, remedy=refused[0].remedy)


def read_table(path: Path, where: str = "") -> RawTable:
    """Return the columns of the file: by its signature where it has one, else by its suffix.

    `where` is what messages call it, when it is only a copy.
    """
    try:
        return _read_table(path)
    except RecordingError as error:
        if not where or where == str(path):
            raise
        raise error.about(where, path) from error


def _format_of(path: Path) -> ModuleType:
    """Return the module that reads the file; RecordingError where there is none."""
    head, suffix = b"", path.suffix.lower()
    if path.is_dir():
        suffix = ".mcap"  # nothing but a folder that ROS 2 wrote comes so far
    else:
        with open_input(path, remember=False) as stream:
            head = stream.read(1024)
    by_content = [m for m in find_formats() if any(head.startswith(s) for s in m.SIGNATURES)]
    by_suffix = [m for m in find_formats() if suffix in m.SUFFIXES]
    chosen = by_content or by_suffix
    if len(by_content) > 1:
        chosen = [m for m in by_content if m in by_suffix] or by_content
    if not chosen:
        known = ", ".join(suffix for module in find_formats() for suffix in module.SUFFIXES)
        what = f"files of type {path.suffix or '(no suffix)'} are not read"
        raise RecordingError(what, where=str(path), remedy=f"known: {known}")
    return chosen[0]


def _read_table(path: Path) -> RawTable:
    check, cut = "check that it is complete and that you may read it", "cut it into shorter recordings"
    with (
        refused(RecordingError, "the file does not fit into memory", path, cut, (MemoryError,)),
        refused(RecordingError, "the file cannot be read ({})", path, check),
    ):
        table: RawTable = _format_of(path).read(path)
        return table
