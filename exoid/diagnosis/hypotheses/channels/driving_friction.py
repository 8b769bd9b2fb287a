"""Friction of a joint, dry and viscous alike, drives it: its torque or its angle has the wrong sign."""

from __future__ import annotations

from exoid.diagnosis.evidence.channel_doubt import Doubt, turned_round
from exoid.diagnosis.hypotheses.channels import BEFORE, Asked

WHEN, ORDER = BEFORE, 40


def doubt(asked: Asked) -> Doubt | None:
    """Doubt where friction is negative for certain."""
    base = asked.base
    rigid, found = len(base.model.base().inertial), []
    for k, joint in enumerate(base.model.joints):
        dry, viscous = base.fit.estimates[rigid + 2 * k : rigid + 2 * k + 2]
        if dry.high < 0.0 and viscous.value < 0.0 and any(recording.driven[k] for recording in base.prepared.train):
            found.append((k, joint))
    if not found:
        return None
    names = " and ".join(joint.name for _, joint in found)
    torques, angles = (
        turned_round((f"{quantity}{k + 1}", joint.unit(quantity)) for k, joint in found) for quantity in ("tau", "q")
    )
    return Doubt(
        f"dry and viscous friction of the {names} are negative, and the interval of the dry one excludes 0",
        f"Friction would have to drive the {names}, where friction can only brake: torque and angle are not counted in "
        "the same direction.",
        f"find out which has the other sign: --units {torques} if the torque has, --units {angles} if the angle has",
    )
