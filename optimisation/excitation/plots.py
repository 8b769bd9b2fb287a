"""The picture of a motion: what each joint does over one period, between its limits (the paper's Fig. 4)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from ground.figures import FAINT, JOINT_COLOURS, figure_style, label, new_figure
from measurement.trajectories.extremes import UNITS
from symbolic.motion import Motion
from symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SYMBOLS = {"angle": "θ", "velocity": "θ'", "acceleration": "θ''"}


def motion_figure(title: str, motion: Motion, limits: Mapping[tuple[str, str], tuple[float, float]]) -> Figure:
    """Draw angle, velocity and acceleration (rows) of hip and knee (columns) with the limits as dashed lines.

    `limits` are {(joint, quantity): (lowest, highest)} in SI units.
    """
    with figure_style():
        figure = new_figure(10.0, 7.0)
        grid = figure.subplots(3, 2, sharex=True)
        for row, (quantity, signals) in enumerate(
            (("angle", motion.q), ("velocity", motion.dq), ("acceleration", motion.ddq))
        ):
            for j, joint in enumerate(JOINTS):
                axes = grid[row][j]
                axes.plot(motion.t, signals[:, j], color=JOINT_COLOURS[joint])
                for level in limits[joint, quantity]:
                    axes.axhline(level, color=FAINT, linestyle="--", linewidth=1.0)
                axes.set_ylabel(label(f"{SYMBOLS[quantity]}{'₁₂'[j]}", UNITS[quantity]))
                axes.margins(x=0.0, y=0.12)
                if row == 0:
                    axes.set_title(f"{joint}, limits dashed")
                if row == 2:
                    axes.set_xlabel(label("time", "s"))
        figure.suptitle(title, x=0.01, ha="left", fontsize=11)
    return figure
