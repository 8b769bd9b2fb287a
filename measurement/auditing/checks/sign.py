"""Signs, swapped channels and degrees, judged by physics: a leg fits a pendulum one way round only."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from measurement.auditing.channels import place
from measurement.auditing.rough import Smooth, smooth, unexplained
from measurement.finding import Finding
from measurement.reading.units import DEGREE
from measurement.recording import Recording

GOOD = 0.25
"""Share of the torques' power left, summed over the joints: a reading of the columns that fits leaves
less."""
DOUBTS = ((0.40, 4.0), (0.15, 8.0))
"""A better reading is only named when the recording as it stands leaves so much, and so many times more."""


def _turned(motion: Smooth, q: tuple[float, float] = (1.0, 1.0), tau: tuple[float, float] = (1.0, 1.0)) -> Smooth:
    return replace(motion, q=motion.q * q, dq=motion.dq * q, ddq=motion.ddq * q, tau=motion.tau * tau)


def _exchanged(motion: Smooth, q: bool = False, tau: bool = False) -> Smooth:
    a, b = slice(None, None, -1 if q else 1), slice(None, None, -1 if tau else 1)
    return replace(motion, q=motion.q[:, a], dq=motion.dq[:, a], ddq=motion.ddq[:, a], tau=motion.tau[:, b])


def readings(motion: Smooth) -> Mapping[str, tuple[Smooth, str]]:
    """Return {what may be wrong: (the motion put right, remedy)}; flipping both angles is flipping both
    torques."""
    return {
        "the hip angle has the wrong sign": (_turned(motion, q=(-1, 1)), "--units q1=-rad"),
        "the knee angle has the wrong sign": (
            _turned(motion, q=(1, -1)),
            "--units q2=-rad (flexion is negative)",
        ),
        "the hip torque has the wrong sign": (_turned(motion, tau=(-1, 1)), "--units tau1=-Nm"),
        "the knee torque has the wrong sign": (_turned(motion, tau=(1, -1)), "--units tau2=-Nm"),
        "both torques (or both angles) have the wrong sign": (
            _turned(motion, tau=(-1, -1)),
            "--units tau=-Nm",
        ),
        "hip and knee torque are swapped": (_exchanged(motion, tau=True), "--map exchanges tau1 and tau2"),
        "hip and knee angle are swapped": (_exchanged(motion, q=True), "--map exchanges q1 and q2"),
        "hip and knee are swapped": (
            _exchanged(motion, True, True),
            "--map exchanges q1 and q2, tau1 and tau2",
        ),
        "the angles are in degrees": (_turned(motion, q=(DEGREE, DEGREE)), "--units q=deg"),
    }


def check(recording: Recording) -> list[Finding]:
    """Warn when the torques contradict the motion and one other reading of the columns explains them well."""
    motion = smooth(recording)
    if motion is None or not np.all(motion.tau.std(axis=0) > 0) or not np.any(motion.q.std(axis=0) > 0.02):
        return []
    now = float(unexplained(motion).sum())
    if now < min(least for least, _ in DOUBTS):
        return []
    left = {what: float(unexplained(other).sum()) for what, (other, _) in readings(motion).items()}
    what = min(left, key=lambda key: left[key])
    if left[what] > GOOD or not any(now > least and now > times * left[what] for least, times in DOUBTS):
        return []
    rivals = [key for key, share in left.items() if key != what and share < min(GOOD, 2 * left[what])]
    text = f"it looks as if {what}" + "".join(f", or {rival}" for rival in rivals)
    return [
        Finding(
            "sign",
            "warning",
            f"{text}: a leg so read leaves {left[what]:.0%} of the torques unexplained, as it stands "
            f"{now:.0%} (of 200%)",
            place(recording),
            now,
            GOOD,
            f"if so: {readings(motion)[what][1]}",
            consequence="every parameter is wrong",
            confidence="possible" if rivals else "likely",
        )
    ]
