"""The torques of some recordings come later or earlier than those of the others."""

from __future__ import annotations

from exoid.diagnosis.hypotheses import Claim, each_said
from exoid.symbolic.model import Model


def claims(model: Model) -> tuple[Claim, ...]:
    """None: it shifts the motion instead of adding torque (`exoid.diagnosis.own_numbers.clocks`)."""
    return ()


def said(place: str | None, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on the delays {recording: words} of the torques."""
    return f"The torques come at another time than in the other recordings: {each_said(values)}"
