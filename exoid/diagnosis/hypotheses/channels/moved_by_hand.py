"""Every torque is a function of the angles alone: a machine that is moved by hand, or a column that is a command."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from exoid.diagnosis.evidence.channel_doubt import Doubt, left_beside
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.hypotheses.channels import BEFORE, Asked
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.symbolic.motion import Float

WHEN, ORDER = BEFORE, 60


def doubt(asked: Asked) -> Doubt | None:
    """Doubt where inertia and friction explain less than half of what the angles alone leave of every torque."""
    base, rules = asked.base, asked.rules
    still, left = [_at_rest(base, recording) for recording in base.prepared.train], []
    for joint in range(len(base.model.joints)):
        tau, residual, rest = left_beside(base, still, joint)
        if tau.size and tau.var() > 0.0:
            if rest.var() > rules.negligible * tau.var() or np.mean(residual**2) < rules.half * rest.var():
                return None
            left.append(rest.var() / tau.var())
    if not left:
        return None
    return Doubt(
        f"the angles alone explain all but {100 * max(left):.2g} % of the torques' variance, and inertia and friction "
        "less than half of that",
        "The torque follows from the angles alone, whichever way and however fast the joints move: neither inertia nor "
        "friction is in it. So it is when a machine is moved by hand while its drives carry its weight, or when the "
        "column is a command computed from the angles. What is left of it is no effect of the machine.",
        "record motion that the drives make, and log the torque that they produce",
    )


def _at_rest(base: FittedModel, one: PreparedRecording) -> Float:
    """Columns (J, K, P) of a recording's postures alone, without velocity and acceleration, and a column of ones."""
    zero = np.zeros(one.motion.q.shape)
    columns = base.model.base().columns(replace(one.motion, dq=zero, ddq=zero, sign=zero))
    return one.smooth_columns(np.concatenate([columns, np.ones((*columns.shape[:2], 1))], axis=2))
