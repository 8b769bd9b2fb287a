"""The angles were filtered before they were logged, and the torques were not."""

from __future__ import annotations

import numpy as np

from exoid.diagnosis.evidence.channel_doubt import Doubt
from exoid.diagnosis.hypotheses.channels import FIRST, Asked
from exoid.optimisation.preparation.smoothed import FILTERED

WHEN, ORDER = FIRST, 10


def doubt(asked: Asked) -> Doubt | None:
    """Doubt where the model leaves what such a filter may have taken away."""
    prepared, near = asked.base.prepared, asked.rules.near_noise
    if not prepared.angles_were_filtered or np.all(asked.base.evaluation_rms <= near * prepared.noise_floor):
        return None
    (filtered,) = [finding for finding in prepared.findings if finding.check == FILTERED]
    return Doubt(
        "the angles hold less noise than any sensor has, the torques do not, and the model leaves more than noise",
        f"{filtered.what[0].upper()}{filtered.what[1:]}. The torques were not: what a filter took out of the angles is "
        "missing in the model's torque, and looks like a delay, a soft drive or friction.",
        filtered.remedy,
    )
