"""Torques that stand far off their neighbours."""

from __future__ import annotations

import numpy as np

from exoid.ground.thresholds import threshold
from exoid.measurement.auditing.channels import channels, place
from exoid.measurement.finding import Finding
from exoid.measurement.reading.angles import running_median, sampled
from exoid.measurement.recording import Recording
from exoid.symbolic.motion import Float

NOTED = threshold(
    __name__, "NOTED", 0.02,
    "share of such torques that is noted: a few that reversing friction makes are no finding",
)  # fmt: skip
HEAVY = threshold(
    __name__, "HEAVY", 0.12,
    "share that is warned of: as many that are not found pull even the Huber loss",
)  # fmt: skip
CARRIED = threshold(
    __name__, "CARRIED", 0.35,
    "part of the slow torque in such samples: chatter that moves a machine is taken for a sensor's",
)  # fmt: skip
AVERAGED = 0.2
"""s over which the torque is averaged for that."""


def check(recording: Recording) -> list[Finding]:
    """Count the spikes of torques, which preparation hides.

    Warns where they are over 12 %, and where much of the torque is in them.
    """
    found = []
    for j, channel in enumerate(channels(recording, "tau")):
        if channel.values.size < 50:
            continue
        far = recording.spikes[channel.at, j]
        share = float(far.mean())
        if share < NOTED:
            continue
        off = channel.values - running_median(channel.values, 11)
        noise = np.abs(off[~far & (off != 0.0)])
        spread = 1.4826 * float(np.median(sampled(noise))) if noise.size else 0.0
        what = f"{share:.1%} of the {channel.label}s stand far off their neighbours on either side"
        count = max(1, round(AVERAGED * recording.rate))
        slow, bursts = (float(_averaged(x, count).std()) for x in (channel.values, far * off))
        severity, value, limit = "info", share, NOTED
        remedy, consequence = "nothing: they are hidden from every fit", "none: they do not enter a fit"
        if slow > spread and bursts > CARRIED * slow:
            severity, value, limit = "warning", bursts / slow, CARRIED
            what += f", and {value:.0%} of the slow torque lies in them"
            remedy = "log the torque as the drive filters it, or faster than the controller changes it"
            consequence = "hidden as a sensor's spikes, they leave little to fit where the drive does chatter"
        elif share > HEAVY:
            severity, limit = "warning", HEAVY
            remedy = "look at the torque sensor and the controller's differentiator"
            consequence = "little is left to fit, and what is not found pulls even the Huber loss"
        where = place(recording, channel.name, channel.at[far])
        found.append(Finding("outliers", severity, what, where, value, limit, remedy, consequence=consequence))
    return found


def _averaged(values: Float, count: int) -> Float:
    """Return the means of all `count` neighbours; of all values where there are fewer."""
    sums, count = np.cumsum(np.concatenate([[0.0], values])), min(count, values.size)
    return np.asarray((sums[count:] - sums[:-count]) / count)
