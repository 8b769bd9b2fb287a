"""A measured force is not zero while the foot is in the air: the load that is not there resembles a spring."""

from __future__ import annotations

from exoid.diagnosis.evidence.channel_doubt import Doubt
from exoid.diagnosis.hypotheses.channels import BEFORE, Asked
from exoid.measurement.stance import UPWARDS

WHEN, ORDER = BEFORE, 30
TARED = "tared"
"""The check of recordings that says which force is not zero while nothing pushes."""


def doubt(asked: Asked) -> Doubt | None:
    """Doubt where some recordings have such a force and the model uses it."""
    found = [finding for finding in asked.base.prepared.findings if finding.check == TARED]
    if UPWARDS not in asked.base.model.channels or not found:
        return None
    where = "; ".join(f"{item.where}: {item.what}" for item in found)
    remedies = "; ".join(dict.fromkeys(item.remedy for item in found))
    rule = f"{UPWARDS} is not zero while the foot is in the air"
    return Doubt(rule, f"A force was not tared: {where}.", remedies)
