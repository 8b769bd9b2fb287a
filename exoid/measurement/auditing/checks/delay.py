"""A hint that the torque comes later (or earlier) than the angles."""

from __future__ import annotations

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.ground.ties import index_of_least
from exoid.measurement.auditing.channels import place
from exoid.measurement.auditing.power_left import left_if_late, smoothed_groups, sums_as_they_stand
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import is_leg

TRIED = np.arange(-120, 121, 5) * 1e-3
"""s; positive: the torque column is late."""
GAIN: Threshold = 0.15
"""part of the torque's power that another timing explains: a missing effect looks late"""
FITS: Threshold = 0.2
"""share of power left, beyond which the rough leg cannot tell: other errors are larger"""


def check(recording: Recording) -> list[Finding]:
    """Note a shift of 5 ms or more under which a rough pendulum leaves at least 15 % less of the torque: only a hint,
    since an effect the model lacks can look like a delay, and the catalogue's `time_delay` is tested on unseen motion.
    """
    sets = smoothed_groups([recording]) if is_leg(recording.joints) else []
    if not sets or not sums_as_they_stand(sets)[0].power.all():
        return []
    now = float(left_if_late(sets, [0.0])[0])
    if now > FITS or now == 0.0:
        return []
    left = left_if_late(sets, TRIED.tolist(), (1.0 - GAIN) * now)
    best = index_of_least(left, 1.0)
    delay, gain = float(TRIED[best]), 1.0 - float(left[best]) / now
    if gain < GAIN or best in (0, TRIED.size - 1):
        return []
    what = f"the torques fit better when read {abs(delay) * 1e3:.0f} ms {'earlier' if delay > 0 else 'later'}"
    what += f" ({gain:.0%} less is left)"
    remedy = "if the logger delays a channel, shift it; `time_delay` in the catalogue tests it properly"
    consequence = "a delay looks like viscous friction"
    return [Finding("delay", "info", what, place(recording), delay, None, remedy, consequence, "possible")]
