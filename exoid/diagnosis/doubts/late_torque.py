"""A torque fits far better read earlier, or as what a slow filter made of it."""

from __future__ import annotations

from exoid.diagnosis.doubts import BEFORE, Asked
from exoid.diagnosis.evidence.channel_doubt import Doubt
from exoid.diagnosis.evidence.timing import late_torque

WHEN, ORDER = BEFORE, 50


def doubt(asked: Asked) -> Doubt | None:
    """Doubt where another timing of a torque leaves less than the best entry of the catalogue, which is the nearer
    answer otherwise, as dry friction that builds up slowly.
    """
    late = late_torque(asked.base, asked.rules)
    return None if late is not None and 1.0 - asked.explained() < late.share else late
