"""The torque sensor, or the drive that reports its current, has another gain in some recordings."""

from __future__ import annotations

from functools import partial

from exoid.diagnosis.hypotheses import Claim, Seen, at_joint, each_said
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float


def claims(model: Model) -> tuple[Claim, ...]:
    """Return another gain of each torque, a factor to the others' gain."""
    return tuple(
        Claim("torque_gain", joint.name, "1", at_joint(k, partial(_of, k)), (-0.5, 1.0), usual=1.0)
        for k, joint in enumerate(model.joints)
    )


def _of(joint: int, seen: Seen) -> Float:
    return seen.torque[joint]


def said(place: str | None, values: dict[str, str], where: str) -> str:
    """Sentence on the gains {recording: words}."""
    return f"The {place} torque is told with another gain than in the other recordings: {each_said(values)} times"
