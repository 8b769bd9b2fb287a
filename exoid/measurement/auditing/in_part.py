"""Does something unmeasured act in part of the time, rather than a channel mean something else?

Another reading of the channels has to explain the torques always. A foot that is on the ground, or a hand that pushes,
leaves the rest of the time to the machine as it stands. So both are asked the same: of how little of the torques they
leave the part of the time that they explain best. The true one leaves noise there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exoid.measurement.auditing.hypotheses import ConventionHypothesis
from exoid.measurement.auditing.non_negative import non_negative
from exoid.measurement.auditing.rough import Smooth, machine_columns
from exoid.measurement.auditing.trimmed import Windows, joined, trimmed, windows_of
from exoid.symbolic.motion import Float

WINDOW = 0.12
"""s, of a window: a swing has several."""


def left_in_part(sets: Sequence[Sequence[Smooth]], reading: ConventionHypothesis) -> float | None:
    """Return the share of the torques' power that a rough machine leaves in the part of the time that it explains best
    if the channels are read so; None where there are too few windows.
    """
    scale = np.sqrt(np.mean([m.tau.var(axis=0) for group in sets for m in group], axis=0))
    left, count = 0.0, 0

    def solve(grams: Float, slopes: Float) -> Float:
        pairs = zip(grams, slopes, strict=True)
        return np.array([non_negative(*pair, either=len(scale)) for pair in pairs])  # offsets of either sign

    for group in sets:
        windows = joined([_windows(motion, reading, scale) for motion in group])
        best = trimmed(windows, solve)
        if best is None:
            continue
        x, chosen = best
        left += float(windows.losses(x[None])[0, chosen].sum())
        count += int(chosen.sum())
    return left / count if count else None


def _windows(motion: Smooth, reading: ConventionHypothesis, scale: np.ndarray) -> Windows:
    """Return the windows of a motion read in another way, in its own torques: no reading gains by mixing them."""
    rows = slice(motion.keep.start, motion.keep.stop)
    turn, back = reading.map.angle.T, np.linalg.inv(reading.map.torque)
    read = replace(motion, q=motion.q @ turn + reading.map.zero, dq=motion.dq @ turn, ddq=motion.ddq @ turn)
    offsets = np.repeat(np.eye(len(back))[:, None], len(motion.q), axis=1)
    columns = np.concatenate([offsets, machine_columns(read)], axis=2)[:, rows]
    columns = np.tensordot(back, columns, 1) / np.maximum(scale, 1e-12)[:, None, None]
    tau = ((motion.tau - motion.tau.mean(axis=0))[rows] / np.maximum(scale, 1e-12)).T
    length = max(1, round(WINDOW / motion.step))
    seen = np.broadcast_to(motion.measured[rows], tau.shape)
    return windows_of(columns, tau, motion.q[rows], motion.dq[rows], seen, length)
