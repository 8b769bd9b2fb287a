"""The torques of some recordings come later or earlier than those of the others: all, or that of one joint.

A delay that all have is the machine's, and an effect.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from exoid.diagnosis.hypotheses.recordings import Claim, Seen, StateColumn, each_said, moving, sides, than_usual
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

LATEST = 1.0
"""s by which torques may come late: beyond, nobody would take the files for recordings of one moment."""


def claims(model: Model, columns: Sequence[StateColumn]) -> tuple[Claim, ...]:
    """Return a delay of all torques, and of that of each joint of several, another one in some recordings."""
    joints = [None, *(enumerate(model.joint_names) if len(model.joints) > 1 else ())]
    late = (moving("clock_offset", "s", _late, LATEST, (1e3, "ms"), joint) for joint in joints)
    return tuple(replace(claim, unlike="clock_offset") for claim in late)


def _late(seen: Seen) -> Float:
    return seen.t - seen.number


def said(claim: Claim, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on the delays {recording: words} of the torques."""
    what = "torques come" if claim.place is None else f"torque of the {claim.place} comes"
    return f"{than_usual(f'{what} at another time', when)}: {each_said(sides(values, 'later', 'earlier'))}"
