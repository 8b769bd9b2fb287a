"""NumPy archives: one array per column, or pairs such as `q` (N, 2); nothing in them is ever executed."""

from __future__ import annotations

import math
import zipfile
import zlib
from pathlib import Path
from tokenize import TokenError

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.limits import Budget, damaged
from exoid.measurement.reading.raw import RawTable, table_from_arrays

SUFFIXES = (".npz",)
SIGNATURES = (b"PK\x03\x04",)
DAMAGE = (
    ValueError, KeyError, EOFError, TypeError, SyntaxError, NotImplementedError, RecursionError, TokenError,
    RuntimeError, zipfile.BadZipFile, zlib.error,
)  # fmt: skip


def read(path: Path) -> RawTable:
    """Return the columns of the archive; raises RecordingError when it is damaged or holds pickled
    objects."""
    if path.suffix.lower() != ".npz":
        remedy = "in the spreadsheet, save as CSV; from NumPy, use the suffix .npz"
        raise RecordingError("this is a ZIP archive (a spreadsheet?), not a table", where=str(path), remedy=remedy)
    with damaged("NPZ archive", path, DAMAGE, "copy it, or save it with np.savez, again"):
        with zipfile.ZipFile(path) as archive:
            budget = Budget(str(path))
            budget.count(len(archive.infolist()))
            for entry in archive.infolist():
                budget.take(max(entry.file_size, _claimed(archive, entry, path)), f"the array {entry.filename}")
        with path.open("rb") as stream, np.load(stream, allow_pickle=False) as content:
            arrays = {name: content[name] for name in content.files}
    return table_from_arrays(arrays, where=str(path))


def _claimed(archive: zipfile.ZipFile, entry: zipfile.ZipInfo, path: Path) -> int:
    """Return the bytes that the array of an entry says it has, for which NumPy makes room before it reads any;
    RecordingError where it holds objects.
    """
    with archive.open(entry) as stream:
        try:
            version = np.lib.format.read_magic(stream)
            read = np.lib.format.read_array_header_1_0 if version == (1, 0) else np.lib.format.read_array_header_2_0
            shape, _, kind = read(stream)
        except (ValueError, SyntaxError, RecursionError, MemoryError, TokenError):
            return 0  # refused with its reason when it is loaded
    if kind.hasobject:
        what = "it holds Python objects, which are never loaded because they can run code"
        remedy = "save plain number arrays: np.savez(path, t=t, q=q, tau=tau)"
        raise RecordingError(what, where=str(path), remedy=remedy)
    return math.prod(shape) * kind.itemsize
