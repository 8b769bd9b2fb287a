"""Signs, zeros, absolute angles, swapped channels and degrees, judged by physics."""

from __future__ import annotations

from exoid.measurement.auditing.convention import check_conventions
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import is_leg


def check(recording: Recording) -> list[Finding]:
    """Warn when the torques contradict the motion and another reading of the columns explains them far better.

    Of a leg: whether any other machine moves under gravity, its model says.
    """
    return list(check_conventions([recording])) if is_leg(recording.joints) else []
