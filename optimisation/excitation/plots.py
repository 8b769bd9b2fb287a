"""The picture of a motion: what each joint does over one period, between its limits (the paper's Fig. 4)."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ground.figures import FAINT, JOINT_COLOURS, figure_style, label, new_figure
from measurement.trajectories.extremes import UNITS
from symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from optimisation.excitation.result import Excitation

SYMBOLS = {"angle": "θ", "velocity": "θ'", "acceleration": "θ''"}
POINTS = 600


def plot_motion(found: Excitation) -> Figure:
    """Draw angle, velocity and acceleration (rows) of hip and knee (columns) with the limits as dashed lines."""
    motion = found.trajectory.at(np.linspace(0.0, found.trajectory.period, POINTS + 1))
    with figure_style():
        figure = new_figure(10.0, 7.0)
        grid = figure.subplots(3, 2, sharex=True)
        for row, (quantity, signals) in enumerate(
            (("angle", motion.q), ("velocity", motion.dq), ("acceleration", motion.ddq))
        ):
            for j, joint in enumerate(JOINTS):
                axes = grid[row][j]
                (use,) = (u for u in found.uses if u.joint == joint and u.quantity == quantity)
                axes.plot(motion.t, signals[:, j], color=JOINT_COLOURS[joint])
                for level in use.limit:
                    axes.axhline(level, color=FAINT, linestyle="--", linewidth=1.0)
                axes.set_ylabel(label(f"{SYMBOLS[quantity]}{'₁₂'[j]}", UNITS[quantity]))
                axes.margins(x=0.0, y=0.12)
                if row == 0:
                    axes.set_title(f"{joint}, limits dashed")
                if row == 2:
                    axes.set_xlabel(label("time", "s"))
        figure.suptitle(f"cond(Ȳ) = {found.condition:.1f}, {found.chosen}", x=0.01, ha="left", fontsize=11)
    return figure
