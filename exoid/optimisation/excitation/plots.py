"""The picture of a motion: what each joint does over one period, between its limits (the paper's Fig. 4)."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

from exoid.ground.figures import FAINT, figure_style, joint_colours, label, new_figure
from exoid.measurement.trajectories.extremes import UNITS
from exoid.symbolic.motion import Motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

SYMBOLS = {"angle": "θ", "velocity": "θ'", "acceleration": "θ''"}


def motion_figure(title: str, motion: Motion, limits: Mapping[tuple[str, str], tuple[float, float]]) -> Figure:
    """Draw angle, velocity and acceleration (rows) of every joint (columns) with the limits as dashed lines.

    `limits` are {(joint, quantity): (lowest, highest)} in SI units.
    """
    with figure_style():
        colours = joint_colours(list(dict.fromkeys(joint for joint, _ in limits)))
        figure = new_figure(5.0 * len(colours), 7.0)
        grid = figure.subplots(3, len(colours), sharex=True, squeeze=False)
        for row, (quantity, signals) in enumerate(
            (("angle", motion.q), ("velocity", motion.dq), ("acceleration", motion.ddq))
        ):
            for j, (joint, colour) in enumerate(colours.items()):
                axes = grid[row][j]
                axes.plot(motion.t, signals[:, j], color=colour)
                for level in limits[joint, quantity]:
                    axes.axhline(level, color=FAINT, linestyle="--", linewidth=1.0)
                axes.set_ylabel(label(f"{SYMBOLS[quantity]}{chr(0x2081 + j)}", UNITS[quantity]))
                axes.margins(x=0.0, y=0.12)
                if row == 0:
                    axes.set_title(f"{joint}, limits dashed")
                if row == 2:
                    axes.set_xlabel(label("time", "s"))
        figure.suptitle(title, x=0.01, ha="left", fontsize=11)
    return figure
