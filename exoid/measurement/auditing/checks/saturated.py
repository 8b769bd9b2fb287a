"""A channel that runs into its end of scale."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import NDArray

from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.channels import FORCE, Channel, channels, place, runs, step_of
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording
from exoid.symbolic.motion import Float

PILE: Threshold = 8.0
"""rows at the extreme value over rows at the levels next to it: a smooth turning point on a grid (below 4) passes for
an end of scale
"""
RESTING: Threshold = 0.03
"""last step before an angle stays, over its usual step: a joint that came to rest by itself passes for a saturated
angle
"""


def check(recording: Recording) -> list[Finding]:
    """Warn where a channel stays exactly at its largest or smallest value, an angle for three rows or more."""
    return [found for _, _, found in saturated_stretches(recording)]


def saturated_stretches(recording: Recording) -> Iterator[tuple[Channel, NDArray[np.int64], Finding]]:
    """Yield channel, indices of the recording where it lies at its end of scale, and the finding on it."""
    remedy = "use a wider sensor range or a gentler motion"
    consequence = "the true values are larger: inertias and friction come out too small"
    for channel in channels(recording, "q", "tau", FORCE):
        values, angle = channel.values, channel.name.startswith("q")
        least = max(6, 0.002 * values.size)
        if not values.size or max(np.sum(values == end) for end in (values.min(), values.max())) < least:
            continue
        levels, counts = np.unique(values, return_counts=True)
        if levels.size < 12:
            continue
        for level, count, near in ((levels[-1], counts[-1], counts[-7:-1]), (levels[0], counts[0], counts[1:7])):
            first, last = runs(values == level)
            long = last - first >= 2
            if not angle and count >= 3 * PILE * near.mean():
                # Noise carries a torque in and out of its end of scale; an angle read on a grid turns round there.
                long[:] = True
            if np.sum((last - first + 1)[long]) < least or count < PILE * near.mean():
                continue
            if (channel.outside and level == 0.0) or (angle and _comes_to_rest(values, first[long])):
                continue
            rows = np.concatenate([channel.at[a : b + 1] for a, b in zip(first[long], last[long], strict=True)])
            size = f"exactly {level:.4g} {channel.unit} in {rows.size} rows"
            what, where = f"the {channel.label} stays at {size} (end of scale?)", place(recording, channel.name, rows)
            share = rows.size / len(recording)
            found = Finding("saturated", "warning", what, where, share, 0.002, remedy, consequence, "likely")
            yield channel, rows, found


def _comes_to_rest(values: Float, first: NDArray[np.int64]) -> bool:
    """True if the angle slows down before it stays, as a joint does that rests; an end of scale cuts it off."""
    steps = np.abs(np.diff(values))
    moving = steps[steps > 0]
    entering = steps[first[first > 0] - 1]
    slow = max(RESTING * float(np.median(moving)), 1.5 * step_of(values))
    return not entering.size or bool(np.median(entering) < slow)
