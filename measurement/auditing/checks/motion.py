"""Whether the joints move, and whether the torques do."""

from __future__ import annotations

import numpy as np

from measurement.auditing.channels import channels, place
from measurement.finding import Finding
from measurement.recording import Recording

STILL, LITTLE = 0.01, 0.15
"""Range of motion in rad (2nd to 98th percentile): below the first a joint stands, below the second it hardly
moves."""


def check(recording: Recording) -> list[Finding]:
    """Refuse when no joint moves or no torque changes; warn when one joint stands or one torque is
    constant."""
    if recording.valid.sum() < 10:
        return []
    angles = list(channels(recording, "q"))
    reach = [float(np.ptp(np.percentile(channel.values, [2, 98]))) for channel in angles]
    where = place(recording)
    found = []
    if max(reach) < STILL:
        what = f"no motion: the angles move by {reach[0]:.2g} and {reach[1]:.2g} rad"
        remedy = "record a motion of both joints through a good part of their range"
        return [Finding("motion", "refused", what, where, max(reach), STILL, remedy)]
    for channel, moved in zip(angles, reach, strict=True):
        if moved < LITTLE:
            still = moved < STILL
            joint = channel.label.split()[0]
            what = f"the {joint} {'stands still' if still else 'hardly moves'} ({moved:.2g} rad)"
            consequence = "this recording alone cannot distinguish friction from inertia at this joint"
            remedy = "add a recording in which both joints move"
            found.append(
                Finding(
                    "motion",
                    "warning",
                    what,
                    place(recording, channel.name),
                    moved,
                    LITTLE,
                    remedy,
                    False,
                    consequence,
                )
            )
    constant = [channel for channel in channels(recording, "tau") if np.ptp(channel.values) == 0.0]
    if len(constant) == 2:
        first, second = (channel.values[0] + 0.0 for channel in constant)
        what = f"both torques are constant ({first:.4g} and {second:.4g} N·m)"
        remedy = "are these the torque columns? --map tau1=COLUMN,tau2=COLUMN"
        return [*found, Finding("motion", "refused", what, where, 0.0, 0.0, remedy)]
    for channel in constant:
        what = f"the {channel.label} is {channel.values[0] + 0.0:.4g} N·m throughout"
        consequence = "right for a joint without a drive; otherwise this joint's parameters mean nothing"
        remedy = f"if the joint has a drive, check the sensor and --map {channel.name}=COLUMN"
        found.append(
            Finding(
                "motion",
                "warning",
                what,
                place(recording, channel.name),
                0.0,
                0.0,
                remedy,
                False,
                consequence,
            )
        )
    return found
