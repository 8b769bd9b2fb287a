"""A channel that stops changing while the leg goes on."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from exoid.ground.thresholds import threshold
from exoid.measurement.auditing.channels import FORCE, Channel, channels, place, runs
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import machine_word

LEAST_ROWS = threshold(
    __name__, "LEAST_ROWS", 10,
    "rows of one value: a slow turning point on a coarse grid passes for a frozen channel",
)  # fmt: skip
LEAST_SECONDS = threshold(__name__, "LEAST_SECONDS", 0.1, "s of one value: the same at a high rate")
DEAD = threshold(
    __name__, "DEAD", 2.0,
    "times the change of speed that 99 % of the motion keeps to, with which a joint stops or starts: one that "
    "comes to rest would be called frozen",
)  # fmt: skip
EDGE = 0.03
"""s before and after a stretch over which the speed of an angle is taken."""
LONG = threshold(
    __name__, "LONG", 2.0,
    "s in which no angle changes while torques do: dry friction that turns round holds a leg so long",
)  # fmt: skip
GOES_ON = threshold(
    __name__, "GOES_ON", 0.5,
    "spread of every torque there, of that in motion: a leg that is held, and leant on",
)  # fmt: skip
SMOOTHED = 0.1
"""s over which torques are averaged for that: noise goes on as well."""


def check(recording: Recording) -> list[Finding]:
    """Warn of stretches of one and the same value that the channel leaves with a jump, or that noise
    excludes."""
    return [frozen_finding(recording, channel, rows) for channel, rows, _ in frozen_stretches(recording)]


def frozen_stretches(recording: Recording) -> Iterator[tuple[Channel, NDArray[np.int64], bool]]:
    """Yield channel, indices of the recording where it is frozen, and whether that is certain."""
    driven = _still_while_driven(recording)
    for channel in channels(recording, "q", "tau", FORCE):
        torque = not channel.name.startswith("q")
        likely, certain = (_frozen_torque if torque else _frozen_angle)(channel, recording)
        known = np.concatenate(certain) if certain else driven[:0]
        if known.size:
            yield channel, known, True
        rest = np.concatenate([*likely, *([] if torque else [driven])]) if likely or not torque else driven[:0]
        rest = np.setdiff1d(rest, known)
        if rest.size:
            yield channel, rest, False


def frozen_finding(recording: Recording, channel: Channel, rows: NDArray[np.int64]) -> Finding:
    """Return the finding about `rows` in which a channel is frozen."""
    what = f"the {channel.label} is frozen in {rows.size} rows while the {machine_word(recording.joints)} moves"
    where, share = place(recording, channel.name, rows), rows.size / len(recording)
    remedy = "look at the cable or bus; empty these cells in a copy of the file and they are masked"
    consequence = "the rows pull every parameter of this joint"
    return Finding("frozen", "warning", what, where, share, 0.0, remedy, consequence, "likely")


Rows = list[NDArray[np.int64]]


def _stretches(channel: Channel, recording: Recording) -> list[tuple[int, int]]:
    """Return first and last of the values of each long stretch of one value.

    One that is held at its extreme is saturation or a stop.
    """
    values, at = channel.values, channel.at
    step = np.diff(values)
    if step.size < 20 or np.ptp(values) == 0.0:
        return []
    first, last = runs(step == 0)
    found = [(int(a), int(b) + 1) for a, b in zip(first, last, strict=True) if b - a >= LEAST_ROWS]
    ends = (values.max(), values.min())
    return [
        (a, b)
        for a, b in found
        if recording.t[at[b]] - recording.t[at[a]] >= LEAST_SECONDS and values[a] not in ends
        and not (channel.outside and values[a] == 0.0)  # a plate that nobody stands on
    ]


def _frozen_torque(channel: Channel, recording: Recording) -> tuple[Rows, Rows]:
    """Return the indices of the recording in frozen stretches of a torque: those likely, those certain.

    Certain is a noisy torque that stays while the leg moves; likely one that leaves the stretch with a jump.
    """
    values, at = channel.values, channel.at
    step = np.diff(values)
    long = _stretches(channel, recording)
    likely: Rows = []
    certain: Rows = []
    first_of, last_of = runs(step == 0)
    size = last_of - first_of + 1
    short = size[size <= LEAST_ROWS].sum()
    # Single repeats are usual where the steps of the sensor are coarser than its noise; long ones then say nothing.
    if not long or short > 0.1 * max(1, step.size - size.sum() + short):
        return likely, certain
    usual = float(np.median(np.abs(step[step != 0])))
    for first, last in long:
        rows = np.arange(at[first], at[last] + 1)
        if np.ptp(recording.q[rows], axis=0).max() > 0.03:
            certain.append(rows)
        elif last < step.size and abs(step[last]) > 8 * usual:
            likely.append(rows)
    return likely, certain


def _frozen_angle(channel: Channel, recording: Recording) -> tuple[Rows, Rows]:
    """Return the indices of the recording in frozen stretches of an angle: those likely, those certain.

    No joint jumps, nor stops and starts within a sample: certain is one that jumps at the end, or both stops and starts
    so; likely one that does either, where the recording begins or ends with the stretch, say.
    """
    values, at = channel.values, channel.at
    step = np.diff(values)
    long = _stretches(channel, recording)
    likely: Rows = []
    certain: Rows = []
    width = max(2, round(EDGE * recording.rate))
    bend = np.abs(values[2 * width :] - 2.0 * values[width:-width] + values[: -2 * width])
    # Without the ends of one stretch: where many end so, that is how the machine moves, from one dwell to the next.
    bend = np.sort(bend[bend > 0.0])[: -4 * width]
    if not long or bend.size < 20:
        return likely, certain
    most = DEAD * float(np.quantile(bend, 0.99))
    usual = float(np.median(np.abs(step[step != 0])))
    for first, last in long:
        stops = first >= width and abs(values[first] - values[first - width]) > most
        starts = last + width < values.size and abs(values[last + width] - values[last]) > most
        jumps = last < step.size and abs(step[last]) > 8 * usual
        if jumps or stops or starts:
            (certain if jumps or (stops and starts) else likely).append(np.arange(at[first], at[last] + 1))
    return likely, certain


def _still_while_driven(recording: Recording) -> NDArray[np.int64]:
    """Return the indices of the recording where for long no angle changes and every torque goes on as in motion."""
    at = np.flatnonzero(recording.valid)
    first, last = runs(np.all(np.diff(recording.q[at], axis=0) == 0.0, axis=1))
    t = recording.t[at]
    stretches = [(a, b + 1) for a, b in zip(first, last, strict=True) if t[b + 1] - t[a] >= LONG]
    if not stretches:
        return at[:0]
    count = max(1, round(SMOOTHED * recording.rate))
    means = recording.tau[at[: len(at) // count * count]].reshape(-1, count, recording.tau.shape[1]).mean(axis=1)
    held = np.zeros(len(means), dtype=bool)
    for a, b in stretches:
        held[-(-a // count) : b // count] = True
    if held.all():
        return at[:0]
    least = GOES_ON * means[~held].std(axis=0)
    parts = [means[-(-a // count) : b // count] for a, b in stretches]
    goes_on = [len(part) > 0 and bool(np.all(part.std(axis=0) > least)) for part in parts]
    found = [np.arange(at[a], at[b] + 1) for (a, b), driven in zip(stretches, goes_on, strict=True) if driven]
    return np.concatenate(found) if found else at[:0]
