"""Check that the clock ticks evenly. Uneven stamps are fine as long as they are true; they are used as logged."""

from __future__ import annotations

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.channels import place
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording

NOTED: Threshold = 0.05
"""variation of the time step that is noted: rounded stamps"""
HEAVY: Threshold = 0.30
"""variation that is warned of: stamps of arrival make accelerations of their own"""


def check(recording: Recording) -> list[Finding]:
    """Note steps that vary by more than 5 % (5th to 95th percentile about the median), warn above 30 %."""
    steps = np.diff(recording.t[recording.valid])
    if steps.size < 10:
        return []
    low, middle, high = np.percentile(steps, [5, 50, 95])
    spread = float((high - low) / (2 * middle))
    if spread < NOTED:
        return []
    what = f"the time step varies by ±{spread:.0%} about {middle * 1e3:.3g} ms; the stamps are used as logged"
    if spread < HEAVY:
        return [Finding("jitter", "info", what, place(recording, "t"), spread, NOTED, "nothing")]
    remedy = "log the instant of the measurement, not of the arrival at the computer"
    consequence = "if the stamps are those of arrival, velocities and accelerations carry their error"
    return [Finding("jitter", "warning", what, place(recording, "t"), spread, HEAVY, remedy, consequence, "possible")]
