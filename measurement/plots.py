"""Pictures of what was measured, and of the motion asked for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np

from ground.figures import JOINT_COLOURS, ROLE_COLOURS, figure_style, label, new_figure
from symbolic.model import TABLE_1, Limits
from symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from measurement.recording import Recording
    from measurement.trajectories.trajectory import Fourier


def plot_recording(recording: Recording) -> Figure:
    """Draw angles and torques over time; rows that are masked are shaded."""
    with figure_style():
        figure = new_figure(8.0, 4.4)
        above, below = figure.subplots(2, 1, sharex=True)
        for axes, values, name in ((above, recording.q, ("angle", "rad")), (below, recording.tau, ("torque", "N·m"))):
            for j, joint in enumerate(JOINTS):
                shown = np.where(recording.valid, values[:, j], np.nan)
                style = "-" if joint == "hip" else "--"
                axes.plot(recording.t, shown, style, color=JOINT_COLOURS[joint], label=joint, linewidth=1.1)
            axes.set(ylabel=label(*name))
            for start, stop in _masked(recording):
                axes.axvspan(start, stop, color=ROLE_COLOURS["measured"], alpha=0.25, linewidth=0)
        above.set(title=recording.name)
        above.legend(loc="upper right", ncols=2)
        below.set(xlabel=label("time", "s"))
    return figure


def _masked(recording: Recording) -> list[tuple[float, float]]:
    """Return the stretches (from, to) in s in which rows are masked."""
    edges = np.flatnonzero(np.diff(np.r_[True, recording.valid, True].astype(int)))
    t, last = recording.t, len(recording) - 1
    return [(float(t[max(a - 1, 0)]), float(t[min(b, last)])) for a, b in edges.reshape(-1, 2)]


def plot_trajectory(path: Fourier, limits: Mapping[str, Limits] = TABLE_1) -> Figure:
    """Draw angle, velocity and acceleration of one period, each between its limits."""
    motion = path.at(np.linspace(0.0, path.period, 600))
    rows = (("angle", "rad", motion.q), ("velocity", "rad/s", motion.dq), ("acceleration", "rad/s²", motion.ddq))
    with figure_style():
        figure = new_figure(7.4, 5.4)
        for axes, (name, unit, values) in zip(figure.subplots(3, 1, sharex=True), rows, strict=True):
            for j, joint in enumerate(JOINTS):
                size, colour = getattr(limits[joint], name), JOINT_COLOURS[joint]
                for border in size if name == "angle" else (-size, size):
                    axes.axhline(border, color=colour, linewidth=0.9, linestyle=":" if j else "--")
                axes.plot(motion.t, values[:, j], color=colour, label=joint)
            axes.set(ylabel=label(name, unit))
        axes.set(xlabel=label("time", "s"))
        handles, names = axes.get_legend_handles_labels()
        figure.legend(handles, [f"{n}, with its limits" for n in names], loc="outside lower center", ncols=2)
    return figure
