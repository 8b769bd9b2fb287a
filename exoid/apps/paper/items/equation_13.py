"""Equation (13): the excitation as a Fourier series."""

from __future__ import annotations

import numpy as np

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import HOLDS, ItemAnswer
from exoid.measurement.trajectories.trajectory import CENTRE, paper_trajectory

TITLE = "the excitation as a Fourier series"
SAYS = f"five harmonics per joint about θ_0 = ({CENTRE[0]:g}, {CENTRE[1]:g}) rad."
TEXT = "θ_i(t) = θ_i0 + Σ_{k=1..5} a_ik sin(k ω t) + b_ik cos(k ω t),    ω = 2π / T"
STEP = 1e-5


def answer(experiments: Experiments) -> ItemAnswer:
    """Hold the velocities and accelerations of the series to differences of its angles, and its end to its start."""
    path = paper_trajectory()
    t = np.linspace(0.0, path.period, 101)
    motion, before, after = path.at(t), path.at(t - STEP), path.at(t + STEP)
    dq, ddq = (after.q - before.q) / (2 * STEP), (after.dq - before.dq) / (2 * STEP)
    apart = max(float(np.max(np.abs(dq - motion.dq))), float(np.max(np.abs(ddq - motion.ddq))))
    closed = float(np.max(np.abs(motion.q[0] - motion.q[-1])))
    count = path.sine.size + path.cosine.size
    return ItemAnswer(
        f"{count} coefficients; velocity and acceleration are its derivatives (to {apart:.0e}), and it ends where it "
        f"began (to {closed:.0e} rad).",
        HOLDS,
        text=TEXT,
    )
