"""MATLAB files: version 4 to 7 through SciPy, 7.3 as the HDF5 it is; structs in any depth, matrices with
column names."""

from __future__ import annotations

import math
import struct
import warnings
import zlib
from pathlib import Path
from typing import Any

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.ground.extras import needing
from exoid.measurement.reading import mat_sizes
from exoid.measurement.reading.formats import hdf5
from exoid.measurement.reading.limits import Budget, damaged
from exoid.measurement.reading.raw import RawTable, label_matrices, table_from_arrays
from exoid.measurement.reading.stamps import since_first

SUFFIXES = (".mat",)
SIGNATURES = (b"MATLAB 5.0 MAT-file", b"MATLAB 7.3 MAT-file")
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
        table = _with_objects(path) if _is_safe_with_objects(path) else None
        return hdf5.read(path) if table is None else table
    import scipy.io

    with damaged("MATLAB file", path, (*DAMAGE, scipy.io.matlab.MatReadError), "save it again from MATLAB"):
        mat_sizes.check(path)
        # The header says where the objects lie: tables, timetables, time series.
        objects = 0 not in head[:4] and bool(head[mat_sizes.SUBSYSTEM_OFFSET].strip(b"\x00 "))
        if objects and (table := _with_objects(path)) is not None:
            return table
        content = scipy.io.loadmat(str(path), struct_as_record=True, squeeze_me=True, appendmat=False)
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


def _is_safe_with_objects(path: Path) -> bool:
    """True if a file of version 7.3 holds objects; RecordingError where they take too much or lie in other files."""
    instead = ", or save it in MATLAB with -v7"
    with needing("hdf5", "MATLAB files of version 7.3", "h5py", where=path, instead=instead, error=RecordingError):
        import h5py
    budget = Budget(str(path))

    def walk(group: Any) -> None:
        for key in group:
            budget.count()
            if not isinstance(group.get(key, getlink=True), h5py.HardLink):
                what = f"{key[:40]} is a link to elsewhere, which is not followed"
                raise RecordingError(what, where=str(path), remedy="save it again")
            item = group[key]
            if isinstance(item, h5py.Group):
                walk(item)
            elif isinstance(item, h5py.Dataset):
                hdf5.refuse_elsewhere(item, path)
                budget.take(hdf5.size_of(item), f"dataset {key[:40]}")
                if "MATLAB_empty" in item.attrs and item.size <= 32:  # the numbers are the shape of what is empty
                    budget.take(8 * math.prod(abs(int(entry)) for entry in np.ravel(item[()])), f"dataset {key[:40]}")

    try:
        with h5py.File(path, "r", locking=False) as file:
            if "#subsystem#" not in file:
                return False
            walk(file)
            return True
    except hdf5.DAMAGE:
        return False  # damaged: refused with its reason when it is read


def _with_objects(path: Path) -> RawTable | None:
    """Return the columns of a file with tables, timetables or time series; None where nothing in it can be read so."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # it sets an option that newer versions of pandas no longer need
            import matio
    except ImportError:
        return None
    arrays: dict[str, Any] = {}
    labels: dict[str, list[str]] = {}
    units: dict[str, str] = {}
    try:
        short = _announces_more_rows_than_it_holds(matio.load_from_mat(str(path), raw_data=True))
    except Exception:  # noqa: BLE001 - as below
        return None
    if short:
        what = "the MATLAB file is damaged: a timetable announces more rows than it holds"
        raise RecordingError(what, where=str(path), remedy="save the timetable again")
    try:
        content = matio.load_from_mat(str(path), add_table_attrs=True)
        for name, value in content.items():
            if not str(name).startswith("__"):
                _object(str(name), value, arrays, labels, units, depth=0)
        return table_from_arrays(label_matrices(arrays, labels), where=str(path), units=units)
    except Exception:  # noqa: BLE001 - a damaged file raises whatever its bytes happen to hit; SciPy's message is better
        return None


def _announces_more_rows_than_it_holds(value: Any, depth: int = 0) -> bool:
    """True if a timetable below `value`, unconverted, has fewer rows than stamps would be made for."""
    if depth > 20:
        return False
    if hasattr(value, "properties"):
        value = np.ravel(value)[0] if isinstance(value, np.ndarray) else value
        value = value.properties
    if isinstance(value, dict):
        return any(_announces_more_rows_than_it_holds(item, depth + 1) for item in value.values())
    if not isinstance(value, np.ndarray) or value.dtype.kind not in "OV":
        return False
    if value.dtype.names and {"numRows", "rowTimes", "data"} <= set(value.dtype.names):
        for table in np.ravel(value):
            longest = max((len(cell) for cell in np.ravel(table["data"]) if np.ndim(cell)), default=0)
            if not float(np.ravel(table["numRows"])[0]) <= longest:
                return True
    cells = [value[name] for name in value.dtype.names] if value.dtype.names else np.ravel(value)
    return any(_announces_more_rows_than_it_holds(cell, depth + 1) for cell in cells)


def _object(
    name: str, value: Any, arrays: dict[str, Any], labels: dict[str, list[str]], units: dict[str, str], depth: int
) -> None:
    """Put the columns of a table, of a time series, or of the fields of a struct into `arrays`."""
    if depth > 8:
        return
    if hasattr(value, "properties"):
        value = np.ravel(value)[0] if isinstance(value, np.ndarray) else value
        found = {str(key).strip("_").lower(): item for key, item in dict(value.properties).items()}
        data = found.get("data")
        time = _time_of(found, 0 if data is None else max(np.shape(data), default=0))
        if time is not None and data is not None:
            arrays[f"{name}.Time"], arrays[f"{name}.Data"] = time, np.squeeze(np.asarray(data))
        return
    if hasattr(value, "columns") and hasattr(value, "iloc"):
        if value.index.dtype.kind in "mM":
            arrays[f"{name}.Time"] = since_first(value.index.to_numpy())
            units[f"{name}.Time"] = "s"
        told = _texts(value.attrs)
        for k, column in enumerate(value.columns):
            cells = value.iloc[:, k]
            if isinstance(cells.dtype, np.dtype) and cells.dtype.kind in "iufb":
                arrays[f"{name}.{column}"] = cells.to_numpy(dtype=float)
            elif cells.dtype.kind in "mM":
                arrays[f"{name}.{column}"] = (cells - cells.iloc[0]).dt.total_seconds().to_numpy(dtype=float)
                units[f"{name}.{column}"] = "s"
            units.setdefault(f"{name}.{column}", told[k] if k < len(told) else "")
        return
    if isinstance(value, dict):
        for key, item in value.items():
            _object(f"{name}.{key}", item, arrays, labels, units, depth + 1)
        return
    array = np.asarray(value)
    if array.dtype == object and array.size == 1 and not array.dtype.names:
        _object(name, array.ravel()[0], arrays, labels, units, depth + 1)
        return
    if array.dtype.names and array.size == 1:
        for key in array.dtype.names:
            _object(f"{name}.{key}", array[key].ravel()[0], arrays, labels, units, depth + 1)
        return
    _flatten(name, np.squeeze(array), arrays, labels, depth)


def _time_of(found: dict[str, Any], samples: int) -> Any:
    """Return the stamps of a time series of so many samples: its own, or those its start and increment give; None where
    it has none.
    """
    time = found.get("time")
    if time is not None and np.size(time) > 1:
        return np.squeeze(np.asarray(time))
    info = found.get("timeinfo")
    info = np.ravel(info)[0] if isinstance(info, np.ndarray) else info
    if info is None or not hasattr(info, "properties"):
        return None
    inner = {str(key).strip("_").lower(): item for key, item in dict(info.properties).items()}
    if np.size(inner.get("time", ())) > 1:
        return np.squeeze(np.asarray(inner["time"]))
    try:
        start, step, count = (float(np.ravel(inner[key])[0]) for key in ("start", "increment", "length"))
    except (KeyError, IndexError, TypeError, ValueError):
        return None
    usable = all(np.isfinite([start, step, count])) and 1 < count <= samples
    return start + step * np.arange(int(count)) if usable else None


def _texts(attributes: Any) -> list[str]:
    """Return the units of the variables of a table, empty where it says none."""
    for key in ("VariableUnits", "varUnits"):
        found = attributes.get(key) if hasattr(attributes, "get") else None
        if found is not None and np.size(found):
            return [str(text) for text in np.ravel(np.asarray(found, dtype=object))]
    return []


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
