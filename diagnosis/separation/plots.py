"""The picture of a separating experiment: how far apart the rivals will be, and the motion that does it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from diagnosis.separation.result import ENOUGH
from ground.figures import FAINT, JOINT_COLOURS, OKABE_ITO, figure_style, label, new_figure
from symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from diagnosis.separation.result import Separation


def plot_separation(found: Separation) -> Figure:
    """Draw bars of the distances (designed, at random, present recordings) beside the angles of the motion."""
    with figure_style():
        figure = new_figure(11.0, 4.2)
        bars, motion = figure.subplots(1, 2)
        _bars(found, bars)
        if found.trajectory is not None:
            along = found.trajectory.at(np.linspace(0.0, found.trajectory.period, 400))
            for j, joint in enumerate(JOINTS):
                motion.plot(along.t, along.q[:, j], color=JOINT_COLOURS[joint], label=joint)
                for level in found.model.limits[joint].angle:
                    motion.axhline(level, color=JOINT_COLOURS[joint], linestyle=":", linewidth=0.9)
            motion.legend(loc="upper right")
        motion.set(title="the motion, limits dotted", xlabel=label("time", "s"), ylabel=label("angle", "rad"))
        motion.margins(x=0.0, y=0.2)
    return figure


def _bars(found: Separation, axes: Axes) -> None:
    rows = np.arange(len(found.apart))
    kinds = [("designed", found.apart, OKABE_ITO["blue"]), ("at random", found.usual, OKABE_ITO["orange"])]
    if found.present is not None:
        kinds.append((f"present ({found.present_seconds:.0f} s)", found.present, OKABE_ITO["green"]))
    height = 0.8 / len(kinds)
    for k, (name, distances, colour) in enumerate(kinds):
        values = [distances[pair] for pair in found.apart]
        axes.barh(rows + (k - 0.5 * (len(kinds) - 1)) * height, values, height, color=colour, label=name)
    axes.axvline(ENOUGH, color=FAINT, linestyle="--", linewidth=1.0)
    axes.set_yticks(rows, [f"{a} true,\n{b} fitted" for a, b in found.apart])
    axes.invert_yaxis()
    axes.set(title=f"apart after {found.duration:g} s", xlabel=label("distance", "σ of the noise"))
    if found.apart:
        axes.legend(loc="lower right", fontsize="small")
