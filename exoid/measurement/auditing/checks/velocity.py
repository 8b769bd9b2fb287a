"""Check that a logged velocity is the derivative of the angle."""

from __future__ import annotations

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.measurement.auditing.channels import WORDS, place
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording

WINDOW = 0.1
"""s over which the velocity is summed: long enough to average noise, short against the motion."""
WRONG: Threshold = 0.2
"""relative difference of logged velocity and derivative: a filtered velocity called wrong"""
SCALES = (
    (57.3, "it looks like degrees per second", "deg/s"),
    (9.55, "it looks like rpm", "rpm"),
    (-1.0, "its sign is the other way round", "-rad/s"),
)
SLIDING = ((1000.0, "it looks like millimetres per second", "mm/s"), (-1.0, "its sign is the other way round", "-m/s"))


def check(recording: Recording) -> list[Finding]:
    """Warn when the summed velocity is not the change of the angle within 20 %."""
    hop = max(1, round(WINDOW * recording.rate))
    if recording.dq is None or len(recording) < 10 * hop:
        return []
    found = []
    steps = np.diff(recording.t)
    known = recording.angle_valid.all(axis=1)
    usable = np.asarray(np.lib.stride_tricks.sliding_window_view(known, hop + 1).all(axis=1))[::hop]
    for joint, owner in enumerate(recording.joints):
        speed = recording.dq[:, joint]
        travelled = np.r_[0.0, np.cumsum(0.5 * (speed[1:] + speed[:-1]) * steps)][::hop]
        by_speed, by_angle = (np.diff(way)[usable] for way in (travelled, recording.q[::hop, joint]))
        if by_angle.size < 10 or np.ptp(by_angle) < 1e-3 * owner.reach:
            continue
        slope = float(by_speed @ by_angle / (by_angle @ by_angle))
        if abs(slope - 1.0) < WRONG:
            continue
        scales = SCALES if owner.turns else SLIDING
        close = [(text, unit) for scale, text, unit in scales if abs(slope / scale - 1.0) < 0.2]
        what = f"the {owner.name} velocity is {slope:.3g} times the derivative of its {WORDS['q'][not owner.turns]}"
        what += "".join(f": {text}" for text, _ in close)
        column, consequence = f"dq{joint + 1}", "none while the velocity is taken from the angle"
        remedy = f"--units {column}={close[0][1]}" if close else f"check the column, or leave {column} out of the file"
        where = place(recording, column)
        found.append(Finding("velocity", "warning", what, where, slope, 0.2, remedy, consequence, "likely"))
    return found
