"""No weight and no inertia show in any torque, and no machine is without mass: the torque is another one, or these
recordings do not carry an answer.
"""

from __future__ import annotations

import numpy as np

from exoid.diagnosis.evidence.channel_doubt import Doubt, left_beside
from exoid.diagnosis.evidence.model_error import is_near_noise
from exoid.diagnosis.hypotheses.channels import AFTER, Asked
from exoid.symbolic.joints import machine_word

WHEN, ORDER = AFTER, 30


def doubt(asked: Asked) -> Doubt | None:
    """Doubt where a model near the noise explains every torque as well without them, at every joint that moves."""
    last, rules = asked.last, asked.rules
    if not is_near_noise(last, rules):
        return None
    model, train = last.model, last.prepared.train
    columns = [item.smooth_columns(last.unfiltered(k)[0])[:, :, len(model.inertial) :] for k, item in enumerate(train)]
    told = []
    for j, joint in enumerate(model.joints):
        tau, residual, without = left_beside(last, columns, j)
        if not np.any(tau):
            continue
        share = 1.0 - float(np.sum(residual**2) / max(float(np.sum(without**2)), 1e-300))
        if share >= rules.worth_telling:
            return None
        told.append(f"{joint.name} {100 * max(share, 0.0):.1g} %")
    if not told:
        return None
    machine = machine_word(model.joints)
    return Doubt(
        f"weight and inertia explain less than {100 * rules.worth_telling:g} % of what friction leaves of every torque",
        f"No weight and no inertia show in the torques ({', '.join(told)} of what friction and the like leave), and no "
        f"{machine} is without: either these are not the torques of this {machine} (a column computed from the "
        "velocity looks so), or these recordings do not carry an answer: its mass asks for less than the noise.",
        "check what the torque columns hold; if they are right, record faster motion, or motion against gravity",
    )
