"""The torques of some recordings come later or earlier than those of the others."""

from __future__ import annotations

from collections.abc import Sequence

from exoid.diagnosis.hypotheses import Claim, StateColumn, each_said
from exoid.symbolic.model import Model


def claims(model: Model, columns: Sequence[StateColumn]) -> tuple[Claim, ...]:
    """None: it shifts the motion instead of adding torque (`exoid.diagnosis.own_numbers.clocks`)."""
    return ()


def said(claim: Claim, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on the delays {recording: words} of the torques."""
    return f"The torques come at another time than in the other recordings: {each_said(values)}"
