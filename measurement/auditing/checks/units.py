"""Sizes that no leg has in SI units."""

from __future__ import annotations

import numpy as np

from measurement.auditing.channels import channels, place
from measurement.finding import Finding
from measurement.recording import Recording

TURNS = 4 * np.pi
"""A link that swings right over reaches 2π and a little more (the real rig does); two turns it does not."""
STRONG = 1000.0
"""N·m, as a median: no drive of a leg gives so much."""


def check(recording: Recording) -> list[Finding]:
    """Warn of angles beyond two turns (degrees?) and of torques beyond 1000 N·m (mN·m?)."""
    found = []
    for channel in channels(recording, "q"):
        reach = float(np.percentile(np.abs(channel.values), 98)) if channel.values.size else 0.0
        if reach > TURNS:
            what = f"the {channel.label} reaches {reach:.4g} rad: it looks like degrees"
            found.append(_finding(recording, channel.name, what, reach, TURNS, "--units q=deg"))
    for channel in channels(recording, "tau"):
        usual = float(np.median(np.abs(channel.values))) if channel.values.size else 0.0
        if usual > STRONG:
            what = f"the {channel.label} is {usual:.4g} N·m in the median: it looks like mN·m"
            found.append(_finding(recording, channel.name, what, usual, STRONG, "--units tau=mNm"))
    return found


def _finding(recording: Recording, column: str, what: str, value: float, limit: float, option: str) -> Finding:
    return Finding(
        "units",
        "warning",
        what,
        place(recording, column),
        value,
        limit,
        f"say so with {option}, or write the unit into the header",
        consequence="every parameter is wrong",
        confidence="likely",
    )
