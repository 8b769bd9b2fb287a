"""TDMS files of LabVIEW through npTDMS, which is an optional extra: channels as columns, named by group and channel.

A channel without a time beside it carries start and increment of its waveform, from which the time is made.
"""

from __future__ import annotations

import io
from pathlib import Path
from typing import Any

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.ground.extras import needing
from exoid.measurement.finding import Finding
from exoid.measurement.reading.limits import TEXT, Budget, Within, damaged
from exoid.measurement.reading.names import recognise
from exoid.measurement.reading.raw import RawTable, table_from_arrays

SUFFIXES = (".tdms",)
SIGNATURES = (b"TDSm",)
SCALED = 2
"""Arrays that a channel is at one time: as it lies in the file, and scaled."""


def read(path: Path) -> RawTable:
    """Return the channels of the file as columns; raises RecordingError when it is damaged or npTDMS is missing."""
    instead = ", or save the recording as CSV"
    with needing("tdms", "TDMS files", "npTDMS", where=path, instead=instead, error=RecordingError):
        import nptdms
        import nptdms.log
    arrays: dict[str, Any] = {}
    units: dict[str, str] = {}
    steps: list[float] = []
    # What the package says of a file (it is cut off, for example) goes into the findings instead of to the screen.
    said, console = io.StringIO(), nptdms.log.log_manager.console_handler
    before = console.setStream(said)
    try:
        # The package raises whatever the bytes of a damaged file happen to hit.
        with damaged("TDMS file", path, (Exception,)), Within(path) as stream, nptdms.TdmsFile.open(stream) as file:
            budget = Budget(str(path))
            channels = [(group, channel) for group in file.groups() for channel in group.channels()]
            for _, channel in channels:
                budget.count()
                kind = np.dtype(channel.dtype)
                each = TEXT if kind.hasobject else SCALED * max(8, kind.itemsize)
                budget.take(each * len(channel), f"channel {str(channel.name)[:40]}")
            for group, channel in channels:
                name = f"{group.name}.{channel.name}" if len(file.groups()) > 1 else str(channel.name)
                arrays[name] = channel[:]
                units[name] = str(channel.properties.get("unit_string", ""))
                steps.append(float(channel.properties.get("wf_increment", 0.0) or 0.0))
    finally:
        console.setStream(before)
    texts = [text[:150] for text in said.getvalue().splitlines() if text.isprintable() and "reader WARNING" in text]
    notes = tuple(Finding("format", "warning", f"npTDMS says: {text}", str(path)) for text in texts[:3])
    timed = any((found := recognise(name)) and found.name == "t" for name in arrays)
    if arrays and not timed and len(set(steps)) == 1 and steps[0] > 0:
        longest = max(np.size(array) for array in arrays.values())
        arrays, units = {"time": np.arange(longest) * steps[0], **arrays}, {"time": "s", **units}
        notes += (Finding("format", "info", f"the time was made from the increment {steps[0]:g} s", str(path)),)
    return table_from_arrays(arrays, where=str(path), units=units, notes=notes)
