"""A channel that stops changing while the leg goes on."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from ground.thresholds import Threshold
from measurement.auditing.channels import Channel, channels, place, runs
from measurement.finding import Finding
from measurement.recording import Recording

LEAST_ROWS = Threshold(10, "rows of one value: a slow turning point on a coarse grid passes for a frozen channel")
LEAST_SECONDS = Threshold(0.1, "s of one value: the same at a high rate")


def check(recording: Recording) -> list[Finding]:
    """Warn of stretches of one and the same value that the channel leaves with a jump, or that noise
    excludes."""
    return [frozen_finding(recording, channel, rows) for channel, rows, _ in frozen_stretches(recording)]


def frozen_stretches(recording: Recording) -> Iterator[tuple[Channel, NDArray[np.int64], bool]]:
    """Yield channel, indices of the recording where it is frozen, and whether that is certain."""
    for channel in channels(recording, "q", "tau"):
        likely, certain = _frozen(channel, recording)
        for rows, sure in ((certain, True), (likely, False)):
            if rows:
                yield channel, np.concatenate(rows), sure


def frozen_finding(recording: Recording, channel: Channel, rows: NDArray[np.int64]) -> Finding:
    """Return what there is to say about `rows` in which a channel is frozen."""
    what = f"the {channel.label} is frozen in {rows.size} rows while the leg moves"
    where, share = place(recording, channel.name, rows), rows.size / len(recording)
    remedy = "look at the cable or bus; empty these cells in a copy of the file and they are masked"
    consequence = "the rows pull every parameter of this joint"
    return Finding("frozen", "warning", what, where, share, 0.0, remedy, consequence, "likely")


def _frozen(channel: Channel, recording: Recording) -> tuple[list[NDArray[np.int64]], list[NDArray[np.int64]]]:
    """Return the indices of the recording in frozen stretches of one channel: those likely, those certain.

    Certain is an angle that jumps at the end, as no joint can, and a noisy torque that stays while the leg moves.
    """
    values, at = channel.values, channel.at
    step = np.diff(values)
    likely: list[NDArray[np.int64]] = []
    certain: list[NDArray[np.int64]] = []
    if step.size < 20 or np.ptp(values) == 0.0:
        return likely, certain
    first, last = runs(step == 0)
    long = last - first >= LEAST_ROWS
    if not long.any():
        return likely, certain
    usual = float(np.median(np.abs(step[step != 0])))
    torque = channel.name.startswith("tau")
    # Single repeats are usual where the steps of the sensor are coarser than its noise; long ones then say nothing.
    repeats = float(np.sum((last - first + 1)[~long])) / max(1.0, step.size - float(np.sum((last - first + 1)[long])))
    if torque and repeats > 0.1:
        return likely, certain
    for start, stop in zip(first[long], last[long], strict=True):
        begin, end = at[start], at[stop + 1]
        if recording.t[end] - recording.t[begin] < LEAST_SECONDS or values[start] in (values.max(), values.min()):
            continue  # a value held at its extreme is saturation or a stop
        jump = abs(step[stop + 1]) if stop + 1 < step.size else 0.0
        travel = np.ptp(recording.q[begin : end + 1], axis=0).max() if torque else 0.0
        rows = np.arange(begin, end + 1)
        if travel > 0.03 or (jump > 8 * usual and not torque):
            certain.append(rows)
        elif jump > 8 * usual:
            likely.append(rows)
    return likely, certain
