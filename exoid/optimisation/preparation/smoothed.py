"""Were angles or torques filtered before they were stored? Their noise says so: there is less than any sensor has.

An exact simulation has none either, and nobody can tell the two apart: both are said, and nothing is refused. But what
noise there is, is then not that of the sensors, and is no measure of an error.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.measurement.finding import EVERY, Finding
from exoid.measurement.signals.conditioning import UniformSignals, noise_density, quiet_noise
from exoid.symbolic.joints import Joint
from exoid.symbolic.motion import Float

ANGLES, TORQUES, FILTERED = "smooth_angles", "smooth_torques", "filtered_angles"
"""What the findings on them are called; the last is on angles beside torques that do hold a sensor's noise."""
ENCODER: Threshold = 4e-7
"""rad, noise of an angle, that of 22 bits at the joint: a good encoder would be doubted"""
NOISY: Threshold = 1e-3
"""noise of a torque, of its middle 80 %, that a sensor has: exact simulations would be doubted"""
SENSOR: Threshold = 1e-5
"""noise of a torque, of its middle 80 %, that of 17 bits: a good sensor would be doubted"""


def smoothed_findings(
    names: Sequence[str], even: Sequence[UniformSignals], joints: Sequence[Joint]
) -> tuple[Finding, ...]:
    """Findings of angles and torques of the recordings called `names` that hold no sensor's noise: of all recordings,
    so that a short one does not speak for the others.
    """
    reach = np.array([joint.reach for joint in joints])
    moves = np.min([np.ptp(signals.q, axis=0) for signals in even], axis=0) > 1e-3 * reach
    angles = np.max([np.sqrt(0.5 * entry.rate * noise_density(entry)) for entry in even], axis=0)
    pulls = np.min([signals.span for signals in even], axis=0) > 0.0
    bridged = [recording.torque_gap | recording.gap[:, None] for recording in even]
    each = [quiet_noise(item.tau, item.rate, 0.5 * item.rate, gap) for item, gap in zip(even, bridged, strict=True)]
    torques = np.max(each, axis=0)
    span = np.max([element.span for element in even], axis=0)
    where = names[0] if len(names) == 1 else EVERY
    of_angles = FILTERED if np.any(pulls & (torques > NOISY * span)) else ANGLES
    found = (
        _finding(of_angles, "angle", joints, moves & (angles < ENCODER * reach), angles, ENCODER, "q", where),
        _finding(TORQUES, "torque", joints, pulls & (torques < SENSOR * span), torques, SENSOR, "tau", where),
    )
    return tuple(finding for finding in found if finding is not None)


def _finding(
    check: str, what: str, joints: Sequence[Joint], smooth: Float, noise: Float, limit: float, key: str, where: str
) -> Finding | None:
    if not smooth.any():
        return None
    told = [(joint, size) for joint, size, recording in zip(joints, noise, smooth, strict=True) if recording]
    names = " and ".join(joint.name for joint, _ in told)
    most = max(size for _, size in told)
    text = f"the {what}s of {names} hold less noise ({most:.2g} {told[0][0].unit(key)} at most) than a sensor at the "
    text += "joint has: they were filtered before they were stored, or computed"
    remedy = "record them as the sensors give them, or filter angles and torques alike; to a simulation add what noise "
    remedy += "the sensors would have"
    consequence = "what the filter took away is missing, and numbers are off by more than their intervals say"
    sure = "likely" if check == FILTERED else "possible"
    return Finding(check, "warning", text, where, float(most), float(limit), remedy, consequence, sure)
