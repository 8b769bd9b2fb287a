"""A channel that runs into its end of scale."""

from __future__ import annotations

import numpy as np

from measurement.channels import channels, place, runs
from measurement.finding import Finding
from measurement.recording import Recording

PILE = 8.0
"""Rows at the extreme value over rows at the levels next to it; a smooth turning point read on a grid stays
below 4."""


def check(recording: Recording) -> list[Finding]:
    """Warn where a channel stays exactly at its largest or smallest value in stretches of three rows or
    more."""
    found = []
    for channel in channels(recording, "q", "tau"):
        levels, counts = np.unique(channel.values, return_counts=True)
        if levels.size < 12:
            continue
        for level, count, near in (
            (levels[-1], counts[-1], counts[-7:-1]),
            (levels[0], counts[0], counts[1:7]),
        ):
            first, last = runs(channel.values == level)
            long = last - first >= 2
            held = int(np.sum((last - first + 1)[long]))
            if held < max(6, 0.002 * channel.values.size) or count < PILE * near.mean():
                continue
            rows = np.concatenate([channel.at[a : b + 1] for a, b in zip(first[long], last[long], strict=True)])
            value = f"{level:.4g} {channel.unit}"
            what = f"the {channel.label} stays at exactly {value} in {held} rows (end of scale?)"
            found.append(
                Finding(
                    "saturated",
                    "warning",
                    what,
                    place(recording, channel.name, rows),
                    held / len(recording),
                    0.002,
                    "use a wider sensor range or a gentler motion",
                    consequence="the true values are larger: inertias and friction come out too small",
                    confidence="likely",
                )
            )
    return found
