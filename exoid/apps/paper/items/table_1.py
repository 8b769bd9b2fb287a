"""Table 1: the limits of the joints."""

from __future__ import annotations

import numpy as np

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import FAILS, HOLDS, ItemAnswer, PaperTable
from exoid.measurement.trajectories.extremes import shortest_period
from exoid.measurement.trajectories.trajectory import paper_trajectory

TITLE = "limits of the joints"
SAYS = "hip and knee stay inside these angles, velocities and accelerations."


def answer(experiments: Experiments) -> ItemAnswer:
    """Put beside each limit what the published motion makes of it."""
    path, limits = paper_trajectory(), experiments.leg.motion_limits
    motion = path.at(np.linspace(0.0, path.period, 2000))
    rows = []
    for j, (joint, limit) in enumerate(limits.items()):
        q, dq, ddq = motion.q[:, j], np.abs(motion.dq[:, j]).max(), np.abs(motion.ddq[:, j]).max()
        low, high = limit.angle
        rows += [
            (joint, "angle [rad]", f"{low:g} to {high:g}", f"{q.min():.3f} to {q.max():.3f}"),
            (joint, "velocity [rad/s]", f"±{limit.velocity:g}", f"{dq:.2f}"),
            (joint, "acceleration [rad/s²]", f"±{limit.acceleration:g}", f"{ddq:.2f}"),
        ]
    inside = shortest_period(path, limits) <= path.period
    return ItemAnswer(
        f"the published motion {'keeps' if inside else 'breaks'} them with a period of {path.period:g} s.",
        HOLDS if inside else FAILS,
        "" if inside else "with this period a limit is exceeded",
        tables=(PaperTable(("joint", "quantity", "Table 1", "published motion, degrees, 10 s"), rows),),
    )
