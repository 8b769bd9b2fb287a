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
    """Return another gain of each torque, and one of all of them, a factor to the others' gain."""
    places = [(joint.name, at_joint(k, partial(_of, k))) for k, joint in enumerate(model.joints)]
    return tuple(
        Claim("torque_gain", place, "1", pieces, BOUNDS, 1.0, factor=True, drive=True)
        for place, pieces in (*places, (None, _of_all))
    )


def _of(joint: int, seen: Seen) -> Float:
    return seen.torque[joint]


def _of_all(seen: Seen) -> Float:
    return seen.torque[:, :, None]


def said(claim: Claim, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on the gains {recording: words}."""
    what = f"{claim.place} torque is" if claim.place else "torques are"
    return f"{than_usual(f'{what} told with another gain', when)}: {each_said(values)} times"
