"""TDMS files of LabVIEW through npTDMS, which is an optional extra: channels as columns, named by group and channel.

A channel without a time beside it carries start and increment of its waveform, from which the time is made.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from ground.errors import RecordingError
from measurement.finding import Finding
from measurement.reading.names import recognise
from measurement.reading.raw import RawTable, table_from_arrays

SUFFIXES = (".tdms",)
SIGNATURES = (b"TDSm",)
MOST_BYTES = 2_000_000_000


def read(path: Path) -> RawTable:
    """Return the channels of the file as columns; raises RecordingError when it is damaged or npTDMS is missing."""
    try:
        import nptdms
    except ImportError as error:
        raise RecordingError(
            "TDMS files need the package npTDMS, which is not installed",
            where=str(path),
            remedy="pip install 'exoid[tdms]', or save the recording as CSV",
        ) from error
    if path.stat().st_size > MOST_BYTES:
        raise RecordingError("the file is too large", where=str(path), remedy="cut it into shorter recordings")
    arrays: dict[str, Any] = {}
    units: dict[str, str] = {}
    steps: list[float] = []
    try:
        with nptdms.TdmsFile.open(path) as file:
            if sum(len(channel) for group in file.groups() for channel in group.channels()) > MOST_BYTES // 8:
                raise RecordingError("the file claims too many samples", where=str(path), remedy="cut it")
            for group in file.groups():
                for channel in group.channels():
                    name = f"{group.name}.{channel.name}" if len(file.groups()) > 1 else str(channel.name)
                    arrays[name] = channel[:]
                    units[name] = str(channel.properties.get("unit_string", ""))
                    steps.append(float(channel.properties.get("wf_increment", 0.0) or 0.0))
    except RecordingError:
        raise
    except Exception as error:
        raise RecordingError(
            f"the TDMS file is damaged or incomplete ({error})", where=str(path), remedy="copy or save it again"
        ) from error
    notes: tuple[Finding, ...] = ()
    timed = any((found := recognise(name)) and found.name == "t" for name in arrays)
    if arrays and not timed and len(set(steps)) == 1 and steps[0] > 0:
        longest = max(np.size(array) for array in arrays.values())
        arrays, units = {"time": np.arange(longest) * steps[0], **arrays}, {"time": "s", **units}
        notes = (Finding("format", "info", f"the time was made from the increment {steps[0]:g} s", str(path)),)
    return table_from_arrays(arrays, where=str(path), units=units, notes=notes)
