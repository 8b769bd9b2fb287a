"""The zeros of encoders: counts start anywhere, so that of angles that were counted no usual zero need fit.

Asked only of angles that are counts with a scale that was given; any other has its zero where somebody put it.
"""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product

import numpy as np

from exoid.ground.ties import index_of_least
from exoid.measurement.auditing.hypotheses import ConventionHypothesis, hypothesis
from exoid.measurement.auditing.power_left import power_left
from exoid.measurement.auditing.rough import Smooth
from exoid.measurement.reading.registers import COUNTED
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import is_spatial
from exoid.symbolic.motion import Float

COARSE = 30.0
"""Degrees between the zeros that are tried first: the weight of a link changes by half of itself."""
FINER = (7.0, 2.5, 0.8, 0.3, 0.1, 0.03)
"""Steps in degrees by which the best of them moves then."""
MOST_JOINTS = 2
"""Whose zeros are tried in every combination."""
MOST_STEPS = 20


def counted_joints(recordings: Sequence[Recording]) -> list[int]:
    """Return the joints whose angles are counts of an encoder in every recording, read without a convention."""
    if is_spatial(recordings[0].joints) or any(item.conventions for item in recordings):
        return []
    checks = [{finding.check for finding in recording.findings} for recording in recordings]
    return [
        k for k in range(len(recordings[0].joints)) if all(COUNTED.format(f"q{k + 1}") in there for there in checks)
    ][:MOST_JOINTS]


def best_zeros(sets: Sequence[Sequence[Smooth]], counted: Sequence[int]) -> tuple[ConventionHypothesis, float]:
    """Return the zeros of the `counted` joints that leave least of the torques' power, and what they leave."""
    joints = sets[0][0].joints

    def at(zeros: Float) -> ConventionHypothesis:
        return hypothesis([f"{joints[k].name}-zero={z:.2f}" for k, z in zip(counted, zeros, strict=True)], joints)

    def best(some: Sequence[Float]) -> tuple[Float, float]:
        left = power_left(sets, [at(zeros) for zeros in some])
        k = index_of_least(left, 1.0)
        return some[k], float(left[k])

    places = np.arange(-180.0, 180.0, COARSE)
    zeros, least = best([np.array(entry) for entry in product(places, repeat=len(counted))])
    moves = [np.array(item) for item in product((0.0, -1.0, 1.0), repeat=len(counted))]
    for step in FINER:
        for _ in range(MOST_STEPS):
            near, left = best([zeros + step * move for move in moves])
            if not left < least:
                break
            zeros, least = near, left
    return at((zeros + 180.0) % 360.0 - 180.0), least
