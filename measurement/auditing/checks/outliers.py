"""Torques that stand far off their neighbours."""

from __future__ import annotations

import numpy as np

from ground.thresholds import Threshold
from measurement.auditing.channels import channels, place, step_of
from measurement.finding import Finding
from measurement.reading.angles import running_median, sampled
from measurement.recording import Recording
from symbolic.motion import Float

FAR = Threshold(6.0, "robust deviations off the running median: noise would be counted")
NOTED = Threshold(0.005, "share of such torques that is noted: a spike or two are no finding")
HEAVY = Threshold(0.12, "share that is warned of: beyond 14 % even the Huber loss is pulled")
CARRIED = Threshold(
    0.35, "part of the slow torque in such samples: chatter that moves a machine is taken for a sensor's"
)
AVERAGED = 0.2
"""s over which the torque is averaged for that."""


def check(recording: Recording) -> list[Finding]:
    """Count torques more than 6 robust deviations off the running median of 11.

    Warns where they are over 12 %, and where much of the torque is in them: they are bridged as spikes of a sensor.
    """
    found = []
    for channel in channels(recording, "tau"):
        if channel.values.size < 50:
            continue
        middle = running_median(channel.values, 11)
        off = np.abs(channel.values - middle)
        # rows equal to the median (a saturated or coarse channel) say nothing about its noise
        noise = off[off > 0]
        spread = max(1.4826 * float(np.median(sampled(noise))) if noise.size else 0.0, step_of(channel.some))
        far = off > FAR * spread
        share = float(far.mean())
        if spread == 0.0 or share < NOTED:
            continue
        far_off = f"{FAR * spread:.3g} {channel.unit}"
        what = f"{share:.1%} of the {channel.label}s stand more than {far_off} off their neighbours"
        count = max(1, round(AVERAGED * recording.rate))
        slow, bursts = (float(_averaged(x, count).std()) for x in (channel.values, far * (channel.values - middle)))
        severity, value, limit = "info", share, NOTED
        remedy, consequence = "nothing: the Huber loss limits their pull", "small with the Huber loss"
        if slow > spread and bursts > CARRIED * slow:
            severity, value, limit = "warning", bursts / slow, CARRIED
            what += f", and {value:.0%} of the slow torque lies in them"
            remedy = "log the torque as the drive filters it, or faster than the controller changes it"
            consequence = "bridged as a sensor's spikes, they leave inertias too small where the drive does chatter"
        elif share > HEAVY:
            severity, limit = "warning", HEAVY
            remedy = "look at the torque sensor and the controller's differentiator"
            consequence = "beyond 14 % even the Huber loss is pulled"
        where = place(recording, channel.name, channel.at[far])
        found.append(Finding("outliers", severity, what, where, value, limit, remedy, consequence=consequence))
    return found


def _averaged(values: Float, count: int) -> Float:
    """Return the means of all `count` neighbours; of all values where there are fewer."""
    sums, count = np.cumsum(np.concatenate([[0.0], values])), min(count, values.size)
    return np.asarray((sums[count:] - sums[:-count]) / count)
