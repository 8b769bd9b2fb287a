"""Torques that stand far off their neighbours."""

from __future__ import annotations

import numpy as np

from ground.thresholds import Threshold
from measurement.auditing.channels import channels, place, step_of
from measurement.finding import Finding
from measurement.reading.angles import running_median, sampled
from measurement.recording import Recording

FAR = Threshold(6.0, "robust deviations off the running median: noise would be counted")
NOTED = Threshold(0.005, "share of such torques that is noted: a spike or two are no finding")
HEAVY = Threshold(0.12, "share that is warned of: beyond 14 % even the Huber loss is pulled")


def check(recording: Recording) -> list[Finding]:
    """Count torques more than 6 robust deviations off the running median of 11; warn when over 12 % are."""
    found = []
    for channel in channels(recording, "tau"):
        if channel.values.size < 50:
            continue
        off = np.abs(channel.values - running_median(channel.values, 11))
        # rows equal to the median (a saturated or coarse channel) say nothing about its noise
        noise = off[off > 0]
        spread = max(1.4826 * float(np.median(sampled(noise))) if noise.size else 0.0, step_of(channel.some))
        far = off > FAR * spread
        share = float(far.mean())
        if spread == 0.0 or share < NOTED:
            continue
        heavy = share > HEAVY
        far_off = f"{FAR * spread:.3g} {channel.unit}"
        what = f"{share:.1%} of the {channel.label}s stand more than {far_off} off their neighbours"
        found.append(
            Finding(
                "outliers",
                "warning" if heavy else "info",
                what,
                place(recording, channel.name, channel.at[far]),
                share,
                HEAVY if heavy else NOTED,
                "look at the torque sensor and the controller's differentiator"
                if heavy
                else "nothing: the Huber loss limits their pull",
                consequence="beyond 14 % even the Huber loss is pulled" if heavy else "small with the Huber loss",
            )
        )
    return found
