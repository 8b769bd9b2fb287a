"""Check that the joints move, and that the torques change."""

from __future__ import annotations

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.channels import NOTHING, channels, place, torque_spans
from exoid.measurement.finding import Finding
from exoid.measurement.reading.mapping import listed
from exoid.measurement.recording import Recording

STILL: Threshold = 0.01
"""rad, 2nd to 98th percentile, below which a joint stands: a brake's play taken for motion"""
LITTLE: Threshold = 0.15
"""the same, below which it hardly moves: its inertia and friction cannot be seen"""
NONE: Threshold = 1e-9
"""N·m (N) over which a torque changes: rounding, which no drive and no sensor has, is fitted"""


def check(recording: Recording) -> list[Finding]:
    """Refuse when no joint moves or no torque changes; warn when one joint stands or one torque is constant."""
    if recording.valid.sum() < 10:
        return []
    angles, torques = list(channels(recording, "q")), list(channels(recording, "tau"))
    reach = [channel.span(2) for channel in angles]
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
            state = "stands still" if size < STILL else "hardly moves"
            what = f"the {channel.joint.name} {state} ({moved:.2g} {channel.unit})"
            consequence = "this recording alone cannot distinguish friction from inertia at this joint"
            remedy = "add a recording in which every joint moves"
            at = place(recording, channel.name)
            found.append(Finding("motion", "warning", what, at, size, LITTLE, remedy, consequence))
    constant = [channel for channel in torques if np.ptp(channel.values) <= NONE]
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
    spans = torque_spans(recording)
    for channel, span, size in zip(torques, spans, turned, strict=True):
        joint, at = channel.joint.name, place(recording, channel.name)
        if joint in recording.passive:
            continue
        if channel in constant:
            kind = "locked joint" if size < STILL else "passive joint, that is one without a drive"
            what = f"the {channel.label} is {channel.values[0] + 0.0:.4g} {channel.unit} throughout, as of a {kind}"
            consequence = "right for a joint without a drive; otherwise this joint's parameters mean nothing"
            remedy = f"if the joint has a drive, check the sensor and --map {channel.name}=COLUMN"
            found.append(Finding("motion", "warning", what, at, 0.0, 0.0, remedy, consequence))
        elif span < NOTHING * max(spans) and size >= LITTLE:
            spread = f"{span:.2g} {channel.unit}, the largest {max(spans):.2g}"
            what = f"the {channel.label} reads next to nothing ({spread})"
            remedy = f"if the {joint} had no drive in this recording: --passive {where}={joint}"
            consequence = "the torque of a passive joint is zero for certain; measured, it is noise"
            found.append(Finding("motion", "info", what, at, span, NOTHING, remedy, consequence, "possible"))
    return found
