"""A force of the ground that is not zero while the foot is in the air."""

from __future__ import annotations

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.channels import FORCE, channels, place
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording

LOW: Threshold = 0.15
"""part of its range above its lowest value up to which the foot is in the air: stance would count"""
SWING: Threshold = 0.15
"""share of the samples that must be so low: a foot that never leaves the ground has no zero"""
OFF: Threshold = 0.03
"""part of its range by which the force may be off in the air: noise would be an offset"""


def check(recording: Recording) -> list[Finding]:
    """Warn where the vertical force of the ground has an offset: of a plate that was not tared."""
    found = []
    for channel in channels(recording, FORCE):
        if channel.name != "grf_z" or channel.values.size < 100:
            continue
        lowest, highest = np.quantile(channel.some, (0.005, 0.995))
        way = 1.0 if highest > -lowest else -1.0  # one that counts the other way round is told by the fit
        load, span = way * channel.values, float(highest - lowest)
        low = load[load < min(way * lowest, way * highest) + LOW * span]
        level = way * float(np.median(low)) if low.size else 0.0
        noise = float(np.median(np.abs(np.diff(channel.values)))) / 0.95
        if span > 0.0 and low.size > SWING * channel.values.size and abs(level) > max(OFF * span, 3.0 * noise):
            what = f"{channel.name} is {level:.3g} N while the foot is in the air: it was not tared"
            remedy = f"tare the plate; subtract {level:.3g} N in a copy of the file"
            consequence = "a force that is not there counts as load of every joint"
            where = place(recording, channel.name)
            found.append(Finding("tared", "warning", what, where, level, OFF * span, remedy, consequence, "likely"))
    return found
