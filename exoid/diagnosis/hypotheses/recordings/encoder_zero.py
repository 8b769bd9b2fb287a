"""The zero of an encoder is another one in some recordings, as where it counts from wherever it was switched on.

One that all have is the machine's, and an effect.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from exoid.diagnosis.hypotheses.recordings import Claim, Seen, StateColumn, each_said, sides, than_usual
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

MOST = 0.3
"""rad by which a zero may differ: beyond, torques are no line in the angle, and the first step does not find it."""


def claims(model: Model, columns: Sequence[StateColumn]) -> tuple[Claim, ...]:
    """Return another zero of the encoder of each joint that turns, in some recordings."""
    return tuple(
        Claim("encoder_zero", joint.name, "rad", partial(_by_angle, k), (-MOST, MOST), factor=True, turns=k)
        for k, joint in enumerate(model.joints)
        if joint.turns
    )


def _by_angle(joint: int, seen: Seen) -> Float:
    assert seen.by_angle is not None
    return seen.by_angle(joint)[:, :, None]


def said(claim: Claim, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on by how much {recording: words} an encoder reads too little, or too much."""
    each = each_said(sides(values, "too little", "too much"))
    return f"{than_usual(f'{claim.place} encoder has another zero', when)}: {each}"
