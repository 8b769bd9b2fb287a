"""HDF5: datasets in any depth of groups, compound tables, unit attributes; also MATLAB 7.3, which is HDF5.

Links to other files are not followed.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ground.errors import RecordingError
from measurement.reading.raw import RawTable, label_matrices, table_from_arrays

SUFFIXES = (".h5", ".hdf5", ".hdf", ".he5")
SIGNATURES = (b"\x89HDF\r\n\x1a\n",)
MOST_CELLS = 200_000_000
"""A dataset can claim any size without storing a byte; more cells than this do not fit into memory anyway."""


def read(path: Path) -> RawTable:
    """Return the columns of all groups, named by their path ("run1.hip.q1"); raises RecordingError if
    damaged."""
    import h5py

    arrays: dict[str, Any] = {}
    labels: dict[str, list[str]] = {}
    units: dict[str, str] = {}
    objects = False

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
            if item.size > MOST_CELLS:
                raise RecordingError(
                    f"dataset {name} has {item.size} cells, too many to read",
                    where=str(path),
                    remedy="cut it into shorter recordings",
                )
            arrays[key] = item[()]
            units[key] = _text(item.attrs.get("units", item.attrs.get("unit", "")))

    try:
        with h5py.File(path, "r") as file:
            file.visititems(visit)
    except (OSError, KeyError, RuntimeError, ValueError, TypeError) as error:
        raise RecordingError(
            f"the HDF5 file is damaged or incomplete ({error})",
            where=str(path),
            remedy="copy or save it again",
        ) from error
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
            "with the time as seconds(T.Time)",
        )


def _text(value: Any) -> str:
    value = np.ravel(value)[0] if np.size(value) else ""
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def _characters(item: Any) -> str:
    """Return the text of a MATLAB char dataset (codes in 16 bits), "" for anything else."""
    if getattr(item, "dtype", None) is None or item.dtype.kind not in "iu":
        return ""
    return "".join(chr(int(code)) for code in np.ravel(item[()])[:200] if 0 < int(code) < 0x110000)
