"""Recordings among other files: what stands in a folder, a pattern or an archive is read, and the rest left out, in one
line. What was named by itself is never left out.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path, PurePath

from exoid.ground.errors import NoChannelsError, RecordingError
from exoid.measurement.finding import Finding
from exoid.measurement.reading.sources import find_files
from exoid.measurement.recording import Recording

LEFT_OUT = "files"
"""What a finding is called that says which files were left out."""
MOST_NAMED = 4


@dataclass(frozen=True)
class FoundFiles:
    """The `paths` that may be recordings, those of them that were `named` by themselves, and the `others` beside them,
    {path: kind}.
    """

    paths: tuple[str, ...]
    named: frozenset[str]
    others: Mapping[str, str]


def files_among(given: Sequence[str | Path]) -> FoundFiles:
    """Return the files that `given` files, folders, patterns and archives mean; RecordingError as of `find_files`."""
    paths, others = find_files(given)
    return FoundFiles(tuple(paths), frozenset(map(str, given)), others)


def read_among(
    given: Sequence[str | Path] | FoundFiles, read: Callable[[str], tuple[Recording, ...]]
) -> tuple[Recording, ...]:
    """Return the recordings that `read` finds in the files that `given` mean; the first of them says what was left out.

    RecordingError where one that was named cannot be read, or one that is a recording, and where nothing is left.
    """
    files = given if isinstance(given, FoundFiles) else files_among(given)
    found: list[Recording] = []
    left = dict(files.others)
    errors: list[RecordingError] = []
    for path in files.paths:
        try:
            found += read(path)
        except RecordingError as error:
            if not error.kind or path in files.named:
                raise
            left[path] = error.kind
            errors.append(error)
    if errors and not found:
        # What could still be read with a word of the user comes before what cannot.
        raise min(errors, key=lambda error: not isinstance(error, NoChannelsError))
    if left and found:
        text = left_out_said(left, len(files.paths) + len(files.others))
        found[0] = found[0].with_findings((*found[0].findings, Finding(LEFT_OUT, "info", text)))
    return tuple(found)


def left_out_said(kinds: Mapping[str, str], total: int) -> str:
    """Return the line that says what was left out of so many files, {path: kind}; "" where nothing was."""
    if not kinds:
        return ""
    counted = ", ".join(f"{number} {kind}" for kind, number in sorted(Counter(kinds.values()).items()))
    return f"{len(kinds)} of {total} files left out: {counted} ({_names(kinds)})"


def _names(paths: Collection[str]) -> str:
    names = [PurePath(path).name for path in paths]
    more = f" and {len(names) - MOST_NAMED} more" if len(names) > MOST_NAMED else ""
    return ", ".join(names[:MOST_NAMED]) + more
