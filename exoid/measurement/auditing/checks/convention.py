"""Signs, zeros, absolute angles, swapped channels and degrees, judged by physics."""

from __future__ import annotations

from exoid.measurement.auditing.convention import check_conventions, counted_joints
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import is_leg


def check(recording: Recording) -> list[Finding]:
    """Warn when the torques contradict the motion and another reading of the columns explains them far better.

    Of a leg: whether any other machine moves under gravity, its model says. Where its encoders have their zeros, which
    takes a search, all recordings are asked together later on.
    """
    asked = is_leg(recording.joints) and not counted_joints([recording])
    return list(check_conventions([recording])) if asked else []
