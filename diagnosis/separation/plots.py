"""The picture of a separating experiment: how far apart the rivals will be, and the motion that does it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ground.figures import FAINT, JOINT_COLOURS, OKABE_ITO, figure_style, label, new_figure
from symbolic.motion import Motion
from symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = tuple(OKABE_ITO[name] for name in ("blue", "orange", "green"))


def separation_figure(
    pairs: Sequence[str],
    distances: Sequence[tuple[str, Sequence[float]]],
    enough: float,
    title: str,
    motion: Motion | None,
    limits: Sequence[tuple[float, float]],
) -> Figure:
    """Draw bars of the distances beside the angles of the motion that was designed, if there is one.

    `distances` are (kind of motion, one distance in σ per pair), `enough` the σ that distinguish a pair, `limits` the
    lowest and highest angle of each joint in rad.
    """
    with figure_style():
        figure = new_figure(11.0, 4.2)
        bars, angles = figure.subplots(1, 2)
        _bars(pairs, distances, enough, title, bars)
        if motion is not None:
            for j, joint in enumerate(JOINTS):
                angles.plot(motion.t, motion.q[:, j], color=JOINT_COLOURS[joint], label=joint)
                for level in limits[j]:
                    angles.axhline(level, color=JOINT_COLOURS[joint], linestyle=":", linewidth=0.9)
            angles.legend(loc="upper right")
        angles.set(title="the motion, limits dotted", xlabel=label("time", "s"), ylabel=label("angle", "rad"))
        angles.margins(x=0.0, y=0.2)
    return figure


def _bars(
    pairs: Sequence[str], distances: Sequence[tuple[str, Sequence[float]]], enough: float, title: str, axes: Axes
) -> None:
    rows = np.arange(len(pairs))
    height = 0.8 / len(distances)
    for k, ((name, values), colour) in enumerate(zip(distances, COLOURS, strict=False)):
        axes.barh(rows + (k - 0.5 * (len(distances) - 1)) * height, values, height, color=colour, label=name)
    axes.axvline(enough, color=FAINT, linestyle="--", linewidth=1.0)
    axes.set_yticks(rows, pairs)
    axes.invert_yaxis()
    axes.set(title=title, xlabel=label("distance", "σ of the noise"))
    if pairs:
        axes.legend(loc="lower right", fontsize="small")
