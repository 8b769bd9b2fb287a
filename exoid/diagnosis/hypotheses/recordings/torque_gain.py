"""The torque sensor, or the drive that reports its current, has another gain in some recordings."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from exoid.diagnosis.hypotheses.recordings import Claim, Seen, StateColumn, at_joint, each_said, than_usual
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

BOUNDS = (-0.95, 19.0)
"""By what a gain is larger than the others': a switched range is ten times another, a half bridge tells half."""


def claims(model: Model, columns: Sequence[StateColumn]) -> tuple[Claim, ...]:
    """Return another gain of each torque, a factor to the others' gain."""
    return tuple(
        Claim("torque_gain", joint.name, "1", at_joint(k, partial(_of, k)), BOUNDS, 1.0, factor=True, drive=True)
        for k, joint in enumerate(model.joints)
    )


def _of(joint: int, seen: Seen) -> Float:
    return seen.torque[joint]


def said(claim: Claim, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on the gains {recording: words}."""
    return f"{than_usual(f'{claim.place} torque is told with another gain', when)}: {each_said(values)} times"
