"""Samples that are missing."""

from __future__ import annotations

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.channels import place
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording

WIDE: Threshold = 2.5
"""median steps: jitter would be counted as gaps"""
MISSING: Threshold = 0.01
"""share of samples, below which short gaps are not warned of: a lost packet"""
LONG: Threshold = 0.1
"""s: a joint can have started and stopped again in a gap that is not warned of"""


def check(recording: Recording) -> list[Finding]:
    """Count holes between usable rows of more than 2.5 steps; warn when one lasts over 0.1 s or 1 % is missing."""
    at = np.flatnonzero(recording.valid)
    if at.size < 10:
        return []
    steps = np.diff(recording.t[at])
    usual = float(np.median(steps))
    wide = steps > WIDE * usual
    if not wide.any():
        return []
    missing, longest = float(np.sum(steps[wide] / usual - 1.0)), float(steps[wide].max())
    share = missing / (missing + at.size)
    calm = longest < LONG and share < MISSING
    what = f"{int(wide.sum())} gaps with about {missing:.0f} samples missing ({share:.1%}), the longest {longest:.3g} s"
    severity, where = "info" if calm else "warning", place(recording, "t", at[1:][wide])
    remedy = "nothing, if they are few" if calm else "look at the logger; derivatives are not taken across long gaps"
    return [Finding("gaps", severity, what, where, longest, LONG, remedy, "rows next to a gap are less certain")]
