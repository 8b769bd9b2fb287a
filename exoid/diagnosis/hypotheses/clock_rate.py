"""The torques were logged by a clock that runs faster or slower than that of the angles."""

from __future__ import annotations

from collections.abc import Sequence

from exoid.diagnosis.hypotheses import Claim, StateColumn, each_said, listed
from exoid.symbolic.model import Model


def claims(model: Model, columns: Sequence[StateColumn]) -> tuple[Claim, ...]:
    """None: it shifts the motion instead of adding torque (`exoid.diagnosis.own_numbers.clocks`)."""
    return ()


def said(claim: Claim, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on the rates {recording: words} of the torques' clock."""
    if len(set(values.values())) == 1:
        rate = next(iter(values.values()))
        return f"The clock of the torques runs {rate} than that of the angles in {listed(values)}"
    return f"The clock of the torques runs at another rate than that of the angles: {each_said(values)}"
