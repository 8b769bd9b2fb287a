"""Pictures of what was measured, and of the motion asked for."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from exoid.ground.figures import LINE_STYLES, ROLE_COLOURS, figure_style, joint_colours, label, new_figure
from exoid.symbolic.joints import Joint, names, units
from exoid.symbolic.model_structure import Limits
from exoid.symbolic.motion import Float, Motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def angles_and_torques(
    title: str, t: Float, q: Float, tau: Float, valid: NDArray[np.bool_], joints: Sequence[Joint]
) -> Figure:
    """Draw `q` and `tau` (N, J) of `joints` over `t` (N,) s; rows that are not `valid` (N,) are shaded."""
    colours = joint_colours(names(joints))
    words = ("angle", "torque") if all(joint.turns for joint in joints) else ("position", "force")
    with figure_style():
        figure = new_figure(8.0, 4.4)
        above, below = figure.subplots(2, 1, sharex=True)
        for axes, values, name in (
            (above, q, (words[0], units(joints, "q"))),
            (below, tau, (words[1], units(joints, "tau"))),
        ):
            for j, (joint, colour) in enumerate(colours.items()):
                shown = np.where(valid, values[:, j], np.nan)
                axes.plot(t, shown, LINE_STYLES[j % len(LINE_STYLES)], color=colour, label=joint, linewidth=1.1)
            axes.set(ylabel=label(*name))
            for start, stop in _masked(t, valid):
                axes.axvspan(start, stop, color=ROLE_COLOURS["measured"], alpha=0.25, linewidth=0)
        above.set(title=title)
        above.legend(loc="upper right", ncols=min(4, len(joints)))
        below.set(xlabel=label("time", "s"))
    return figure


def _masked(t: Float, valid: NDArray[np.bool_]) -> list[tuple[float, float]]:
    """Return the stretches (from, to) in s in which rows are masked."""
    edges = np.flatnonzero(np.diff(np.r_[True, valid, True].astype(int)))
    last = len(t) - 1
    return [(float(t[max(a - 1, 0)]), float(t[min(b, last)])) for a, b in edges.reshape(-1, 2)]


def motion_between_limits(motion: Motion, limits: Mapping[str, Limits]) -> Figure:
    """Draw angle, velocity and acceleration of `motion`, each between its limits."""
    rows = (("angle", "rad", motion.q), ("velocity", "rad/s", motion.dq), ("acceleration", "rad/s²", motion.ddq))
    with figure_style():
        figure = new_figure(7.4, 5.4)
        for axes, (name, unit, values) in zip(figure.subplots(3, 1, sharex=True), rows, strict=True):
            for j, (joint, colour) in enumerate(joint_colours(list(limits)).items()):
                size = getattr(limits[joint], name)
                for border in size if name == "angle" else (-size, size):
                    axes.axhline(border, color=colour, linewidth=0.9, linestyle=":" if j else "--")
                axes.plot(motion.t, values[:, j], color=colour, label=joint)
            axes.set(ylabel=label(name, unit))
        axes.set(xlabel=label("time", "s"))
        handles, names = axes.get_legend_handles_labels()
        figure.legend(handles, [f"{n}, with its limits" for n in names], loc="outside lower center", ncols=2)
    return figure
