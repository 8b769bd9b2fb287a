"""MATLAB files: version 4 to 7 through SciPy, 7.3 as the HDF5 it is; structs in any depth, matrices with
column names."""

from __future__ import annotations

import struct
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from ground.errors import RecordingError
from measurement.reading.formats import hdf5
from measurement.reading.limits import Budget
from measurement.reading.raw import RawTable, label_matrices, table_from_arrays

SUFFIXES = (".mat",)
SIGNATURES = (b"MATLAB 5.0 MAT-file", b"MATLAB 7.3 MAT-file")
COMPRESSED = 15
"""The type of an element that is packed."""
LABELS = ("label", "Name", "name", "blockName")
"""Fields of a struct array that say which signal an element holds."""
DAMAGE = (
    ValueError,
    TypeError,
    KeyError,
    IndexError,
    EOFError,
    OverflowError,
    AttributeError,
    NotImplementedError,
    UnicodeDecodeError,
    zlib.error,
    struct.error,
)


def read(path: Path) -> RawTable:
    """Return the variables and struct fields of the file as columns; raises RecordingError when it is
    damaged."""
    with path.open("rb") as stream:
        head = stream.read(1024)
    if head.startswith(SIGNATURES[1]) or hdf5.SIGNATURES[0] in head:
        return hdf5.read(path)
    import scipy.io

    try:
        _refuse_bombs(path)
        content = scipy.io.loadmat(str(path), struct_as_record=True, squeeze_me=True, appendmat=False)
    except (*DAMAGE, scipy.io.matlab.MatReadError) as error:
        raise RecordingError(
            f"the MATLAB file is damaged or incomplete ({error})",
            where=str(path),
            remedy="save it again from MATLAB",
        ) from error
    arrays: dict[str, Any] = {}
    labels: dict[str, list[str]] = {}
    objects = False
    for name, value in content.items():
        if name.startswith("__"):
            continue
        if isinstance(value, scipy.io.matlab.MatlabOpaque):
            objects = True
        else:
            _flatten(str(name), value, arrays, labels, depth=0)
    if objects:
        hdf5.refuse_matlab_objects(path, arrays)
    return table_from_arrays(label_matrices(arrays, labels), where=str(path))


def _refuse_bombs(path: Path) -> None:
    """Refuse a file of version 5 to 7 whose variables unpack to too much; they are unpacked piece by piece to see."""
    budget = Budget(str(path))
    with path.open("rb") as stream:
        head = stream.read(128)
        if not head.startswith(SIGNATURES[0][:6]) or head[126:128] not in (b"IM", b"MI"):
            budget.take(path.stat().st_size)  # version 4 is not packed
            return
        order = "<" if head[126:128] == b"IM" else ">"
        while len(tag := stream.read(8)) == 8:
            kind, size = struct.unpack(f"{order}II", tag)
            budget.count()
            if kind != COMPRESSED:
                budget.take(size)
                stream.seek(size, 1)
                continue
            unpack = zlib.decompressobj()
            while size > 0 and (piece := stream.read(min(size, 1 << 16))):
                size -= len(piece)
                while piece and not unpack.eof:
                    budget.take(len(unpack.decompress(piece, 1 << 22)), "a packed variable")
                    piece = unpack.unconsumed_tail


def _flatten(name: str, value: Any, arrays: dict[str, Any], labels: dict[str, list[str]], depth: int) -> None:
    """Put the numeric arrays below `value` into `arrays` and its lists of texts into `labels`, by dotted
    name."""
    array = np.asarray(value)
    if depth > 20 or not array.size:
        return
    if array.dtype.names and array.ndim == 1 and 1 < array.size <= 64 and set(LABELS) & set(array.dtype.names):
        for i, element in enumerate(array):  # one struct per signal, as Simulink logs them
            label = next((str(element[key]) for key in LABELS if key in array.dtype.names and str(element[key])), i + 1)
            _flatten(f"{name}.{label}", element, arrays, labels, depth + 1)
        return
    if array.dtype.names:
        for key in array.dtype.names:
            field = array[key]
            if array.ndim == 1 and array.size > 1 and all(np.size(cell) == 1 for cell in field):
                if any(isinstance(cell, str) for cell in field):
                    continue
                arrays[f"{name}.{key}"] = np.array([np.ravel(cell)[0] for cell in field])  # one struct per sample
            elif array.size == 1:
                _flatten(f"{name}.{key}", np.ravel(field)[0], arrays, labels, depth + 1)
    elif array.dtype.kind == "U":
        labels[name] = [str(text).strip() for text in np.ravel(array)]
    elif array.dtype.kind == "O":
        cells = np.ravel(array)
        if all(isinstance(cell, str) for cell in cells):
            labels[name] = [cell.strip() for cell in cells]
        elif array.size <= 64:
            for i, cell in enumerate(cells):
                _flatten(f"{name}{i + 1}", cell, arrays, labels, depth + 1)
    elif array.dtype.kind in "iufb" and array.ndim:
        arrays[name] = array
