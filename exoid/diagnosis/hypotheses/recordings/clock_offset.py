"""The torques of some recordings come later or earlier than those of the others.

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
    """Return a delay of all torques, another one in some recordings."""
    return (replace(moving("clock_offset", "s", _late, LATEST, (1e3, "ms")), unlike="clock_offset"),)


def _late(seen: Seen) -> Float:
    return seen.t - seen.number


def said(claim: Claim, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on the delays {recording: words} of the torques."""
    each = each_said(sides(values, "later", "earlier"))
    return f"{than_usual('torques come at another time', when)}: {each}"
