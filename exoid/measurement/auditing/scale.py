"""A plain factor between the torques of a leg (a torque constant, a gear, another unit) that no rigid leg agrees with.

The shank pulls on both joints, so a leg fixes the ratio of the two torques. The size of both is free for a leg of any
mass, within reason.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from exoid.ground.minimum import minimum
from exoid.ground.thresholds import Threshold
from exoid.ground.ties import index_of_least
from exoid.measurement.auditing.channels import place_of_all
from exoid.measurement.auditing.hypotheses import ConventionHypothesis
from exoid.measurement.auditing.power_left import motions_of, power_left
from exoid.measurement.finding import Finding
from exoid.measurement.reading.conventions import Map
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import is_leg

TRIED = np.logspace(-3, 3, 55)
"""Factors tried, of which the best is refined between its neighbours, to a thousandth."""
LEAST_GAIN: Threshold = 0.003
"""share of the torques' power left, from which a factor is looked for: friction left out"""
GOOD: Threshold = 0.12
"""share of power that the factor leaves at most: one that fits nothing would be named"""
TIMES: Threshold = 4.0
"""times less than without it: two scales that fit alike"""
PLAIN: Threshold = 5.0
"""factor, or one over it, that no effect of a drive is: a wrong gain would be called a gear"""


def check_scales(recordings: Sequence[Recording]) -> tuple[Finding, ...]:
    """Return a warning where `recordings` together want a plain factor between the torques: a gear, or another unit."""
    motions = motions_of(recordings) if is_leg(recordings[0].joints) else []
    if not motions:
        return ()

    def left(*factors: float) -> list[float]:
        maps = (Map(np.eye(2), np.zeros(2), np.diag([1.0, factor])) for factor in factors)
        return list(map(float, power_left(motions, [ConventionHypothesis((), to) for to in maps])))

    (now,) = left(1.0)
    if now < LEAST_GAIN:
        return ()
    tried = left(*TRIED)
    best = index_of_least(tried, 1.0)
    if best in (0, TRIED.size - 1) or max(TRIED[best], 1.0 / TRIED[best]) <= PLAIN:
        return ()
    low, high = np.log(TRIED[[best - 1, best + 1]]).tolist()
    change, least = minimum(lambda x: left(math.exp(x))[0], low, high, 1e-3)
    wanted = math.exp(change)
    if now < TIMES * least or least >= GOOD:
        return ()
    what = f"hip and knee torque do not belong to one leg: a rigid leg wants the knee torque multiplied by {wanted:.3g}"
    what += f", or the hip torque by {1 / wanted:.3g}; so it leaves {least / 2:.1%} of the torques' variance "
    what += f"unexplained, as they stand {now / 2:.0%}"
    remedy = f"check torque constant and gear: --units tau2=Nm*{wanted:.3g} or tau1=Nm*{1 / wanted:.3g}"
    where, consequence = place_of_all(recordings), "every parameter is wrong"
    return (Finding("scale", "warning", what, where, wanted, None, remedy, consequence, "likely"),)
