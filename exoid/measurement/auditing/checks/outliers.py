"""Torques that stand far off their neighbours."""

from __future__ import annotations

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.channels import channels, place
from exoid.measurement.finding import Finding
from exoid.measurement.reading.angles import running_median, sampled
from exoid.measurement.recording import Recording
from exoid.measurement.signals.spikes import CARRIED, DENSE, averaged, carried

NOTED: Threshold = 0.02
"""share of such torques that is noted: a few that reversing friction makes are no finding"""


def check(recording: Recording) -> list[Finding]:
    """Count the torques that are far off, most of which preparation hides as spikes; warn where they are over 12 %, and
    where much of the torque is in them: dense ones are then the chatter of a drive, and stay.
    """
    found = []
    for j, channel in enumerate(channels(recording, "tau")):
        if channel.values.size < 50:
            continue
        far = recording.far_off[channel.at, j]
        share = float(far.mean())
        if share < NOTED:
            continue
        off = channel.values - running_median(channel.values, 11)
        noise = np.abs(off[~far & (off != 0.0)])
        spread = 1.4826 * float(np.median(sampled(noise))) if noise.size else 0.0
        what = f"{share:.1%} of the {channel.label}s stand far off their neighbours on either side"
        severity, value, limit = "info", share, NOTED
        remedy, consequence = "nothing: they are hidden from every fit", "none: they do not enter a fit"
        held, _ = carried(recording.tau[:, j], recording.far_off[:, j], recording.rate)
        if held > CARRIED and averaged(channel.values, recording.rate).std() > spread:
            severity, value, limit = "warning", held, CARRIED
            what += f", and {value:.0%} of the slow torque lies in them"
            remedy = "log the torque as the drive filters it, or faster than the controller changes it"
            consequence = "kept as a drive's chatter: its samples are too few to tell the torque well"
            if recording.spikes[:, j].any():
                consequence = "hidden as a sensor's spikes, they leave little to fit where the drive does chatter"
        elif share > DENSE:
            severity, limit = "warning", DENSE
            remedy = "look at the torque sensor and the controller's differentiator"
            consequence = "little is left to fit, and what is not found pulls even the Huber loss"
        where = place(recording, channel.name, channel.at[far])
        found.append(Finding("outliers", severity, what, where, value, limit, remedy, consequence=consequence))
    return found
