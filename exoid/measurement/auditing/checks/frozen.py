"""A channel that stops changing while the leg goes on."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.channels import FORCE, Channel, channels, place, runs
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import machine_word
from exoid.symbolic.motion import Float

LEAST_ROWS: Threshold = 10
"""rows of one value: a slow turning point on a coarse grid passes for a frozen channel"""
LEAST_SECONDS: Threshold = 0.1
"""s of one value: the same at a high rate"""
DEAD: Threshold = 2.0
"""times the change of speed that 99 % of the motion keeps to, with which a joint stops or starts: one that comes to
rest would be called frozen
"""
EDGE = 0.03
"""s before and after a stretch over which the speed of an angle is taken."""


def check(recording: Recording) -> list[Finding]:
    """Warn of stretches of one and the same value that the channel leaves with a jump, or that noise excludes."""
    return [found for _, _, found, _ in frozen_stretches(recording)]


def frozen_stretches(recording: Recording) -> Iterator[tuple[Channel, NDArray[np.int64], Finding, bool]]:
    """Yield channel, indices of the recording where it is frozen, the finding on it, and whether it is certain."""
    remedy = "look at the cable or bus; empty these cells in a copy of the file and they are masked"
    consequence, machine = "the rows pull every parameter of this joint", machine_word(recording.joints)
    for channel in channels(recording, "q", "tau", FORCE):
        torque = not channel.name.startswith("q")
        parts: dict[bool, list[NDArray[np.int64]]] = {True: [], False: []}
        for first, last, certain in (_frozen_torque if torque else _frozen_angle)(channel, recording):
            parts[certain].append(np.arange(channel.at[first], channel.at[last] + 1))
        for certain, some in parts.items():
            if some:
                rows = np.concatenate(some)
                what = f"the {channel.label} is frozen in {rows.size} rows while the {machine} moves"
                where, share = place(recording, channel.name, rows), rows.size / len(recording)
                found = Finding("frozen", "warning", what, where, share, 0.0, remedy, consequence, "likely")
                yield channel, rows, found, certain


def _stretches(channel: Channel, recording: Recording) -> list[tuple[int, int]]:
    """First and last of the values of each long stretch of one value but an extreme: that is saturation, or a stop."""
    values, at = channel.values, channel.at
    if values.size < 21 or np.ptp(values) == 0.0:
        return []
    ends = (values.max(), values.min())
    return [
        (int(a), int(b) + 1)
        for a, b in zip(*runs(np.diff(values) == 0), strict=True)
        if b - a >= LEAST_ROWS and recording.t[at[b + 1]] - recording.t[at[a]] >= LEAST_SECONDS
        and values[a] not in ends and not (channel.outside and values[a] == 0.0)  # a plate that nobody stands on
    ]  # fmt: skip


def _jumps(step: Float, last: int) -> bool:
    """True if a channel leaves a stretch that ends with value `last` by far more than it usually changes."""
    return last < step.size and bool(abs(step[last]) > 8 * float(np.median(np.abs(step[step != 0]))))


def _frozen_torque(channel: Channel, recording: Recording) -> Iterator[tuple[int, int, bool]]:
    """Yield first and last value of each frozen stretch of a torque, and whether that is certain: a noisy torque that
    stays while the leg moves. Likely is one that leaves the stretch with a jump.
    """
    step = np.diff(channel.values)
    size = np.diff(runs(step == 0), axis=0)[0] + 1
    short = size[size <= LEAST_ROWS].sum()
    # Single repeats are usual where the steps of the sensor are coarser than its noise; long ones then say nothing.
    if short > 0.1 * max(1, step.size - size.sum() + short):
        return
    for first, last in _stretches(channel, recording):
        moves = np.ptp(recording.q[channel.at[first] : channel.at[last] + 1], axis=0).max() > 0.03
        if moves or _jumps(step, last):
            yield first, last, bool(moves)


def _frozen_angle(channel: Channel, recording: Recording) -> Iterator[tuple[int, int, bool]]:
    """Yield the same of an angle. No joint jumps, nor stops and starts within a sample: certain is one that jumps at
    the end, or both stops and starts so; likely one that does either, where the recording begins or ends so, say.
    """
    values, step = channel.values, np.diff(channel.values)
    width = max(2, round(EDGE * recording.rate))
    bend = np.abs(values[2 * width :] - 2.0 * values[width:-width] + values[: -2 * width])
    # Without the ends of one stretch: where many end so, that is how the machine moves, from one dwell to the next.
    bend = np.sort(bend[bend > 0.0])[: -4 * width]
    if bend.size < 20:
        return
    most = DEAD * float(np.quantile(bend, 0.99))
    for first, last in _stretches(channel, recording):
        stops = first >= width and abs(values[first] - values[first - width]) > most
        starts = last + width < values.size and abs(values[last + width] - values[last]) > most
        if (jumps := _jumps(step, last)) or stops or starts:
            yield first, last, bool(jumps or (stops and starts))
