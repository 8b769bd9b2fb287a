"""HDF5: datasets in any depth of groups, compound tables, unit attributes; also MATLAB 7.3, which is HDF5.

Nothing is read that does not lie in the file itself: links to other files, virtual datasets and external storage are
not followed.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.ground.extras import needing
from exoid.measurement.reading.limits import TEXT, Budget, damaged
from exoid.measurement.reading.raw import RawTable, label_matrices, table_from_arrays

SUFFIXES = (".h5", ".hdf5", ".hdf", ".he5")
SIGNATURES = (b"\x89HDF\r\n\x1a\n",)
DAMAGE = (OSError, KeyError, RuntimeError, ValueError, TypeError)
"""What h5py raises for a damaged file."""
LONGEST_TEXT = 100_000
"""Characters of a text that is looked at."""


def read(path: Path) -> RawTable:
    """Return the columns of all groups, named by their path ("run1.hip.q1"); raises RecordingError if
    damaged."""
    instead = ", or save the recording as CSV"
    with needing("hdf5", "HDF5 files", "h5py", where=path, instead=instead, error=RecordingError):
        import h5py
    arrays: dict[str, Any] = {}
    labels: dict[str, list[str]] = {}
    units: dict[str, str] = {}
    objects = False
    budget = Budget(str(path))

    def ask(name: str, item: Any) -> None:
        budget.count()
        if name.startswith("#") or not isinstance(item, h5py.Dataset):
            return
        refuse_elsewhere(item, path)
        if item.dtype.kind in "iufbVOSU":
            budget.take(size_of(item) + (TEXT * item.size if item.dtype.kind in "OSU" else 0), f"dataset {name}")

    def visit(name: str, item: Any) -> None:
        nonlocal objects
        if name.startswith("#") or not isinstance(item, h5py.Dataset):
            return
        key = name.replace("/", ".")
        kind = _text(item.attrs.get("MATLAB_class", ""))
        objects = objects or "MATLAB_object_decode" in item.attrs
        if kind == "cell":
            labels[key] = [_characters(item.file[ref]) for ref in np.ravel(item[()]) if ref]
        elif kind == "char":
            labels[key] = [_characters(item)]
        elif item.dtype.kind in "OSU" and h5py.check_string_dtype(item.dtype) and item.ndim == 1:
            labels[key] = [str(text) for text in item.asstr(errors="replace")[()]]
        elif item.dtype.kind in "iufbV" and item.shape and "MATLAB_empty" not in item.attrs:
            arrays[key] = item[()]
            units[key] = _text(item.attrs.get("units", item.attrs.get("unit", "")))

    # No lock: the file may lie on a read-only medium, or be open elsewhere.
    with damaged("HDF5 file", path, DAMAGE), h5py.File(path, "r", locking=False) as file:
        file.visititems(ask)
        file.visititems(visit)
    if objects:
        refuse_matlab_objects(path, arrays)
    return table_from_arrays(label_matrices(arrays, labels), where=str(path), units=units)


def refuse_matlab_objects(path: Path, arrays: dict[str, Any]) -> None:
    """Raise RecordingError when a MATLAB file holds nothing readable beside table or timetable objects."""
    if not any(array.size > 10 and array.dtype.kind in "iuf" for array in arrays.values()):
        raise RecordingError(
            "the file holds a MATLAB table, timetable or other object, which only MATLAB can read",
            where=str(path),
            remedy="in MATLAB: s = table2struct(timetable2table(T), 'ToScalar', true); "
            "save('run.mat', '-struct', 's'), "
            "with the time as seconds(T.Time); or pip install 'exoid[matlab]' reads tables and time series as they are",
        )


def refuse_elsewhere(item: Any, path: Path) -> None:
    """Refuse a dataset whose numbers lie in other files: a recording must not make anything else be read."""
    if item.is_virtual or item.external:
        kind = "virtual" if item.is_virtual else "stored outside"
        what = f"dataset {item.name} is {kind}: its numbers lie in other files, which are not read"
        remedy = "save the numbers themselves, for example with h5repack or h5py: new['q1'] = old['q1'][()]"
        raise RecordingError(what, where=str(path), remedy=remedy)


def size_of(item: Any) -> int:
    """Return the bytes that reading a dataset takes: its cells, twice where they are converted, and a chunk."""
    chunk = int(np.prod(item.chunks, dtype=float)) if item.chunks else 0
    return int(max(item.size * max(item.dtype.itemsize, 8), chunk * item.dtype.itemsize))


def _text(value: Any) -> str:
    value = np.ravel(value)[0] if np.size(value) else ""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _characters(item: Any) -> str:
    """Return the text of a MATLAB char dataset (codes in 16 bits), "" for anything else."""
    if getattr(item, "dtype", None) is None or item.dtype.kind not in "iu" or item.size > LONGEST_TEXT:
        return ""
    if item.is_virtual or item.external:
        return ""
    return "".join(chr(int(code)) for code in np.ravel(item[()])[:200] if 0 < int(code) < 0x110000)
