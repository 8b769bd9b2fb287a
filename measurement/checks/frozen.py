"""A channel that stops changing while the leg goes on."""

from __future__ import annotations

import numpy as np

from measurement.channels import Channel, channels, place, runs
from measurement.finding import Finding
from measurement.recording import Recording

LEAST_ROWS, LEAST_SECONDS = 10, 0.1


def check(recording: Recording) -> list[Finding]:
    """Warn of stretches of one and the same value that the channel leaves with a jump, or that noise
    excludes."""
    found = []
    for channel in channels(recording, "q", "tau"):
        at = _frozen(channel, recording)
        if at.size:
            what = f"the {channel.label} is frozen in {at.size} rows while the leg moves"
            found.append(
                Finding(
                    "frozen",
                    "warning",
                    what,
                    place(recording, channel.name, at),
                    at.size / len(recording),
                    0.0,
                    "look at the cable or bus; empty these cells in a copy of the file and they are masked",
                    consequence="the rows pull every parameter of this joint",
                    confidence="likely",
                )
            )
    return found


def _frozen(channel: Channel, recording: Recording) -> np.ndarray:
    """Return the indices of the recording in frozen stretches of one channel."""
    values, at = channel.values, channel.at
    step = np.diff(values)
    if step.size < 20 or np.ptp(values) == 0.0:
        return np.array([], dtype=int)
    moving = np.abs(step[step != 0])
    usual = float(np.median(moving))
    noisy = channel.name.startswith("tau") and np.mean(step == 0) < 0.3
    out = []
    for first, last in zip(*runs(step == 0), strict=True):
        start, stop = at[first], at[last + 1]
        lasting = last - first >= LEAST_ROWS and recording.t[stop] - recording.t[start] >= LEAST_SECONDS
        if not lasting or values[first] in (values.max(), values.min()):
            continue  # a value held at its extreme is saturation or a stop
        jump = abs(step[last + 1]) if last + 1 < step.size else 0.0
        travel = np.ptp(recording.q[start : stop + 1], axis=0).max() if noisy else 0.0
        if jump > 8 * usual or travel > 0.03:
            out.append(np.arange(start, stop + 1))
    return np.concatenate(out) if out else np.array([], dtype=int)
