"""Read a recording: find the format, name the columns, mend what can be mended safely, audit, or refuse.

The file itself is only ever opened for reading.
"""

from __future__ import annotations

import hashlib
import importlib
import pkgutil
from collections.abc import Mapping
from functools import cache
from pathlib import Path
from types import ModuleType

from ground.errors import RecordingError
from ground.inputs import open_input
from measurement.auditing.audit import audit
from measurement.finding import Finding
from measurement.reading import formats
from measurement.reading.columns import assign
from measurement.reading.raw import RawTable
from measurement.reading.repair import repaired
from measurement.reading.split_stamps import join_split
from measurement.reading.unusable import mask_unusable
from measurement.recording import Recording, Source


@cache
def find_formats() -> tuple[ModuleType, ...]:
    """Return every module in `measurement/reading/formats/`."""
    names = sorted(module.name for module in pkgutil.iter_modules(formats.__path__))
    return tuple(importlib.import_module(f"{formats.__name__}.{name}") for name in names)


def read_recording(
    path: str | Path, columns: Mapping[str, str] | None = None, units: Mapping[str, str] | None = None
) -> Recording:
    """Return the recording in the file `path`, in SI units, audited.

    `columns` maps canonical names to columns of the file ({"q1": "HipEnc"}), `units` gives the unit of a
    quantity or column ({"q": "deg", "tau1": "mNm"}). Rows with a cell that is not a number are masked in
    `valid`, never dropped. Raises RecordingError for anything that cannot be used, with the place and the
    remedy.
    """
    path = Path(path)
    digest = _digest(path)
    table = join_split(read_table(path))
    assigned = assign(table, columns, units, where=str(path))
    recording = repaired(table, assigned, name=path.stem, source=Source(str(path), digest))
    recording = mask_unusable(recording)
    recording = recording.with_findings(audit(recording))
    refuse(recording.findings)
    return recording


def refuse(findings: tuple[Finding, ...]) -> None:
    """Raise RecordingError for the first finding of severity "refused", naming how many others there are."""
    refused = [finding for finding in findings if finding.severity == "refused"]
    if refused:
        more = (
            f" (and {len(refused) - 1} further reasons: {'; '.join(f.what for f in refused[1:])})"
            if refused[1:]
            else ""
        )
        raise RecordingError(refused[0].what + more, where=refused[0].where, remedy=refused[0].remedy)


def read_table(path: Path) -> RawTable:
    """Return the columns of the file: by its signature where it has one, else by its suffix."""
    try:
        with path.open("rb") as stream:
            head = stream.read(1024)
        by_content = [m for m in find_formats() if any(head.startswith(s) for s in m.SIGNATURES)]
        by_suffix = [m for m in find_formats() if path.suffix.lower() in m.SUFFIXES]
        chosen = by_content or by_suffix
        if len(by_content) > 1:
            chosen = [m for m in by_content if m in by_suffix] or by_content
        if not chosen:
            known = ", ".join(suffix for module in find_formats() for suffix in module.SUFFIXES)
            raise RecordingError(
                f"files of type {path.suffix or '(no suffix)'} are not read",
                where=str(path),
                remedy=f"known: {known}",
            )
        table: RawTable = chosen[0].read(path)
        return table
    except OSError as error:
        raise RecordingError(
            f"the file cannot be read ({error.strerror or error})",
            where=str(path),
            remedy="check that it is complete and that you may read it",
        ) from error
    except MemoryError as error:
        raise RecordingError(
            "the file does not fit into memory", where=str(path), remedy="cut it into shorter recordings"
        ) from error


def _digest(path: Path) -> str:
    """Return the SHA-256 of the file in hex; raises RecordingError when it is not a readable file."""
    try:
        folder, there, ordinary = path.is_dir(), path.exists(), path.is_file()
        if path.is_symlink() and not there:
            raise RecordingError(
                "this is a link that leads nowhere", where=str(path), remedy="give the path of the file itself"
            )
    except (OSError, ValueError, RuntimeError) as error:  # before Python 3.13 a loop of links is a RuntimeError
        raise RecordingError(
            "this is not a path of a file", where=str(path)[:200], remedy="check the spelling"
        ) from error
    if folder:
        raise RecordingError(
            "this is a folder, not a recording", where=str(path), remedy=f"name the files: {path}/*.csv"
        )
    if not there:
        raise RecordingError("there is no such file", where=str(path), remedy=_nearby(path))
    if not ordinary:
        raise RecordingError("this is not an ordinary file", where=str(path), remedy="give the path of a file on disk")
    digest = hashlib.sha256()
    try:
        with open_input(path) as stream:
            while block := stream.read(1 << 20):
                digest.update(block)
    except OSError as error:
        raise RecordingError(
            f"the file cannot be read ({error.strerror or error})",
            where=str(path),
            remedy="check that you may read it",
        ) from error
    return digest.hexdigest()


def _nearby(path: Path) -> str:
    """Return advice that names a file of a similar name in the same folder, if there is one."""
    import difflib

    if not path.parent.is_dir():
        return f"the folder {path.parent} does not exist either"
    close = difflib.get_close_matches(path.name, [entry.name for entry in path.parent.iterdir()], 1, cutoff=0.75)
    return f"did you mean {path.parent / close[0]}?" if close else "check the path"
