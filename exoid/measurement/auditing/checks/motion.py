"""Check that the joints move, and that the torques change."""

from __future__ import annotations

import numpy as np

from exoid.ground.thresholds import threshold
from exoid.measurement.auditing.channels import NOTHING, channels, place, torque_spans
from exoid.measurement.finding import Finding
from exoid.measurement.reading.mapping import listed
from exoid.measurement.recording import Recording

STILL = threshold(
    __name__, "STILL", 0.01,
    "rad, 2nd to 98th percentile, below which a joint stands: a brake's play taken for motion",
)  # fmt: skip
LITTLE = threshold(
    __name__, "LITTLE", 0.15,
    "the same, below which it hardly moves: its inertia and friction cannot be seen",
)  # fmt: skip
NONE = threshold(
    __name__, "NONE", 1e-9,
    "N·m (N) over which a torque changes: rounding, which no drive and no sensor has, is fitted",
)  # fmt: skip


def check(recording: Recording) -> list[Finding]:
    """Refuse when no joint moves or no torque changes; warn when one joint stands or one torque is
    constant."""
    if recording.valid.sum() < 10:
        return []
    angles = list(channels(recording, "q"))
    reach = [float(np.ptp(np.percentile(channel.some, [2, 98]))) for channel in angles]
    turned = [moved / channel.joint.reach for channel, moved in zip(angles, reach, strict=True)]
    where = place(recording)
    found = []
    if max(turned) < STILL:
        far = [f"{moved:.2g} {channel.unit}" for channel, moved in zip(angles, reach, strict=True)]
        what = f"no motion: the angles move by {listed(far)}"
        remedy = "record a motion of every joint through a good part of its range"
        return [Finding("motion", "refused", what, where, max(turned), STILL, remedy)]
    for channel, moved, size in zip(angles, reach, turned, strict=True):
        if size < LITTLE:
            still = size < STILL
            state = "stands still" if still else "hardly moves"
            what = f"the {channel.joint.name} {state} ({moved:.2g} {channel.unit})"
            consequence = "this recording alone cannot distinguish friction from inertia at this joint"
            remedy = "add a recording in which every joint moves"
            found.append(_warning(what, place(recording, channel.name), size, LITTLE, remedy, consequence))
    constant = [channel for channel in channels(recording, "tau") if np.ptp(channel.values) <= NONE]
    if len(constant) == len(angles):
        held = [f"{channel.values[0] + 0.0:.4g} {channel.unit}" for channel in constant]
        what = f"no torque changes ({listed(held)})"
        remedy = f"are these the torque columns? --map {','.join(f'{channel.name}=COLUMN' for channel in constant)}"
        if not any(np.any(np.abs(channel.values) > NONE) for channel in constant):
            remedy = (
                "a free swing tells only ratios of parameters (inertia to weight, friction to inertia), not how large "
                f"they are: record motion in which at least one joint is driven; if one was, {remedy}"
            )
        return [*found, Finding("motion", "refused", what, where, 0.0, 0.0, remedy)]
    size_of = {channel.joint.name: size for channel, size in zip(angles, turned, strict=True)}
    found += _next_to_nothing(recording, size_of)
    for channel in constant:
        if channel.joint.name in recording.passive:
            continue
        still = size_of[channel.joint.name] < STILL
        kind = "locked joint" if still else "passive joint, that is one without a drive"
        what = f"the {channel.label} is {channel.values[0] + 0.0:.4g} {channel.unit} throughout, as of a {kind}"
        consequence = "right for a joint without a drive; otherwise this joint's parameters mean nothing"
        remedy = f"if the joint has a drive, check the sensor and --map {channel.name}=COLUMN"
        found.append(_warning(what, place(recording, channel.name), 0.0, 0.0, remedy, consequence))
    return found


def _warning(what: str, where: str, value: float, limit: float, remedy: str, consequence: str) -> Finding:
    return Finding("motion", "warning", what, where, value, limit, remedy, consequence)


def _next_to_nothing(recording: Recording, reach: dict[str, float]) -> list[Finding]:
    """Note a joint that moves while its torque reads next to nothing: it may have no drive."""
    spans = torque_spans(recording)
    found = []
    for channel, span in zip(channels(recording, "tau"), spans, strict=True):
        joint = channel.joint.name
        if joint in recording.passive or np.ptp(channel.values) <= NONE:
            continue
        if span >= NOTHING * max(spans) or reach[joint] < LITTLE:
            continue
        what = f"the {channel.label} reads next to nothing ({span:.2g} {channel.unit}, the largest {max(spans):.2g})"
        name = recording.source.path or recording.name
        remedy = f"if the {joint} had no drive in this recording: --passive {name}={joint}"
        consequence = "the torque of a passive joint is zero for certain; measured, it is noise"
        where = place(recording, channel.name)
        found.append(Finding("motion", "info", what, where, span, NOTHING, remedy, consequence, "possible"))
    return found
