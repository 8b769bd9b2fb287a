"""Recordings too long for memory: audited piece by piece, and represented by stretches spread over them.

A day at 1 kHz is 8 GB of text. It is read in pieces of some minutes, each of which passes the same audit as a recording
of its own; what the audit says is added up. Of every twelfth of the file the piece with most motion is kept, at most
`STRETCH` s of it: half an hour in all, as recordings of their own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import fields, replace
from typing import Any

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.ground.progress import Progress
from exoid.measurement.finding import SEVERITIES, Finding
from exoid.measurement.reading.raw import RawTable
from exoid.measurement.recording import Recording

STRETCHES, STRETCH = 12, 150.0
"""How many recordings a long file becomes, and how many s each of them at most."""


def in_stretches(
    pieces: Iterable[tuple[float, RawTable]],
    finish: Callable[[RawTable], Recording],
    *,
    name: str,
    where: str,
    progress: Progress | None = None,
) -> tuple[Recording, ...]:
    """Return the stretches that stand for a recording in `pieces` (share of the file that is read, table).

    `finish` makes an audited recording of one piece. The first stretch carries what the audits of all pieces found.
    RecordingError when no piece can be used, with the reason of the first.
    """
    best: dict[int, tuple[float, Recording]] = {}
    kinds: dict[tuple[str, str], list[Finding]] = {}
    refused = []
    count, rows, last = 0, 0, -np.inf
    backwards = 0
    for share, table in pieces:
        count += 1
        rows += table.row.size
        if progress is not None:
            progress(share, f"auditing {name}: {rows / 1e6:.1f} million rows")
        try:
            recording = finish(table)
        except RecordingError as error:
            # Its traceback would keep the piece in memory.
            error.__cause__ = error.__context__ = None
            refused.append(error.with_traceback(None))
            continue
        for key, finding in {(element.check, element.severity): element for element in recording.findings}.items():
            kinds.setdefault(key, []).append(finding)
        start = float(recording.t[0])
        backwards += start < last and start != 0.0
        last = float(recording.t[-1])
        place = min(STRETCHES - 1, int(share * STRETCHES - 1e-9))
        cut = _liveliest(recording)
        content = _motion(cut)
        if place not in best or content > best[place][0]:
            best[place] = (content, cut)
    if not best:
        raise refused[0] if refused else RecordingError("the file holds no rows", where=where, remedy="record again")
    kept = [recording for _, (_, recording) in sorted(best.items())]
    minutes = sum(entry.duration for entry in kept) / 60
    what = f"{rows} rows in {count} pieces were audited; {len(kept)} stretches of them, {minutes:.0f} min in all, "
    what += "stand for it: of each part of the file that with most motion"
    said = [Finding("large", "repaired", what, where, remedy="cut out what matters most, if that is not it")]
    if refused:
        what = f"{len(refused)} of {count} pieces cannot be used, for example: {refused[0].what}"
        said.append(Finding("large", "warning", what, refused[0].where, remedy=refused[0].remedy))
    if backwards:
        what = f"time goes back between {backwards} pieces: the file holds more than one recording"
        said.append(Finding("large", "warning", what, where, remedy="cut it into one file per recording"))
    out = [replace(item, name=_named(name, item), findings=()) for item in kept]
    out[0] = out[0].with_findings((*said, *_together(kinds, count)))
    return tuple(out)


def _together(kinds: Mapping[tuple[str, str], Sequence[Finding]], pieces: int) -> list[Finding]:
    """Return one finding per kind (check, severity), worst first, which says in how many of the pieces it stands."""
    worst = sorted((key for key in kinds if key[1] != "info"), key=lambda key: SEVERITIES.index(key[1]))
    counts = ((kinds[key][0], f" (and the like in {len(kinds[key])} of {pieces} pieces)") for key in worst)
    return [replace(first, what=first.what + more) for first, more in counts]


def _named(name: str, one: Recording) -> str:
    return f"{name} from row {int(one.row[0])}"


def _liveliest(recording: Recording) -> Recording:
    """Return the part of `recording`, at most STRETCH s long, in which the angles move most."""
    if recording.duration <= STRETCH:
        return recording
    starts = recording.t[0] + np.arange(0.0, recording.duration - STRETCH, STRETCH / 2)
    parts = [_between(recording, start, start + STRETCH) for start in starts]
    return max(parts, key=_motion)


def _between(one: Recording, start: float, stop: float) -> Recording:
    """Return the rows from `start` to `stop` s, as copies: a view would keep the whole piece in memory."""
    first, last = np.searchsorted(one.t, [start, stop])
    own = {field.name: getattr(one, field.name) for field in fields(one)}
    cut: dict[str, Any] = {name: x[first:last].copy() for name, x in own.items() if isinstance(x, np.ndarray)}
    return replace(one, **cut)


def _motion(one: Recording) -> float:
    """Return the spread of the angles in the rows that can be used, in rad, summed over the joints."""
    whole = one.complete
    if not whole.any():
        return 0.0
    spread: Sequence[float] = one.q[whole].std(axis=0)
    return float(np.sum(spread) * whole.mean())
