"""Samples that are missing."""

from __future__ import annotations

import numpy as np

from measurement.auditing.channels import place
from measurement.finding import Finding
from measurement.recording import Recording

WIDE = 2.5
"""In median steps: anything shorter is jitter."""
LONG = 0.1
"""In s: a joint can have started and stopped again in there."""


def check(recording: Recording) -> list[Finding]:
    """Count holes between usable rows of more than 2.5 steps; warn when one lasts over 0.1 s or 1 % is
    missing."""
    at = np.flatnonzero(recording.valid)
    if at.size < 10:
        return []
    steps = np.diff(recording.t[at])
    usual = float(np.median(steps))
    wide = steps > WIDE * usual
    if not wide.any():
        return []
    missing = float(np.sum(steps[wide] / usual - 1.0))
    longest = float(steps[wide].max())
    share = missing / (missing + at.size)
    calm = longest < LONG and share < 0.01
    what = f"{int(wide.sum())} gaps with about {missing:.0f} samples missing ({share:.1%}), the longest {longest:.3g} s"
    return [
        Finding(
            "gaps",
            "info" if calm else "warning",
            what,
            place(recording, "t", at[1:][wide]),
            longest,
            LONG,
            "nothing, if they are few" if calm else "look at the logger; derivatives are not taken across long gaps",
            consequence="rows next to a gap are less certain",
        )
    ]
