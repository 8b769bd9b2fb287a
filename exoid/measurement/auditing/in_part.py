"""Does something unmeasured act in part of the time, rather than a channel mean something else?

Another reading of the channels has to explain the torques always. A foot that is on the ground, or a hand that pushes,
leaves the rest of the time to the machine as it stands. So both are asked the same: of how little of the torques they
leave the part of the time that they explain best. The true one leaves noise there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exoid.measurement.auditing.hypotheses import ConventionHypothesis, hypothesis
from exoid.measurement.auditing.non_negative import non_negative
from exoid.measurement.auditing.rough import Smooth, machine_columns
from exoid.measurement.auditing.trimmed import Windows, joined, trimmed, windows_of

WINDOW = 0.12
"""s, of a window: a swing has several."""


def acts_in_part(
    sets: Sequence[Sequence[Smooth]], held: Sequence[Sequence[Smooth]], reading: ConventionHypothesis
) -> bool:
    """True if something that acts in part of the time explains motions as they stand (`sets`) better than another
    `reading` of what the files hold (`held`) explains them.
    """
    stands = left_in_part(sets, hypothesis((), sets[0][0].joints))
    return stands is not None and stands < (left_in_part(held, reading) or 0.0)


def left_in_part(sets: Sequence[Sequence[Smooth]], reading: ConventionHypothesis) -> float | None:
    """Return the share of the torques' power that a rough machine leaves in the part of the time that it explains best
    if the channels are read so; None where there are too few windows.
    """
    scale = np.sqrt(np.mean([m.tau.var(axis=0) for group in sets for m in group], axis=0))
    left, count = 0.0, 0
    for group in sets:
        windows = joined([_windows(motion, reading, scale) for motion in group])
        best = trimmed(windows, non_negative)
        if best is None:
            continue
        left += float(best.losses[best.chosen].sum())
        count += best.chosen.size
    return left / count if count else None


def _windows(motion: Smooth, reading: ConventionHypothesis, scale: np.ndarray) -> Windows:
    """Return the windows of a motion read in another way, in its own torques: no reading gains by mixing them."""
    rows = slice(motion.keep.start, motion.keep.stop)
    turn, back = reading.map.angle.T, np.linalg.inv(reading.map.torque)
    read = replace(motion, q=motion.q @ turn + reading.map.zero, dq=motion.dq @ turn, ddq=motion.ddq @ turn)
    columns = np.tensordot(back, machine_columns(read)[:, rows], 1) / np.maximum(scale, 1e-12)[:, None, None]
    tau = ((motion.tau - motion.tau.mean(axis=0))[rows] / np.maximum(scale, 1e-12)).T
    length = max(1, round(WINDOW / motion.step))
    seen = np.broadcast_to(motion.measured[rows], tau.shape)
    return windows_of(columns, tau, motion.q[rows], motion.dq[rows], seen, length)
