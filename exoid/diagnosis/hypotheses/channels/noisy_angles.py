"""Noise of the encoders leaves no accelerations worth the name."""

from __future__ import annotations

import numpy as np

from exoid.diagnosis.evidence.channel_doubt import Doubt
from exoid.diagnosis.hypotheses.channels import BEFORE, Asked

WHEN, ORDER = BEFORE, 10


def doubt(asked: Asked) -> Doubt | None:
    """Doubt where noise makes too much of the accelerations at the slowest useful cut-off."""
    prepared, joints = asked.base.prepared, asked.base.model.joints
    share = prepared.acceleration_noise
    if not share > asked.rules.angle_noise:
        return None
    density = np.max([recording.angle_noise * 0.5 * recording.full_rate for recording in prepared.train], axis=0)
    pairs = zip(np.sqrt(density), joints, strict=True)
    size = " and ".join(f"{x:.2g} {joint.unit('q')} at {joint.name}" for x, joint in pairs)
    return Doubt(
        f"noise of the angles makes {100 * share:.0f} % of the accelerations, at {prepared.choice.cutoff:g} Hz",
        f"The angles are too noisy for their accelerations ({size}): at the slowest useful cut-off "
        f"noise makes {100 * share:.0f} % of them, so every inertia comes out too small by about that part, and "
        "whatever smooths the model looks like an effect.",
        "check the encoders and the columns of the angles; record faster motion, or repeat one periodic motion many "
        "times and use --derivative fourier",
    )
