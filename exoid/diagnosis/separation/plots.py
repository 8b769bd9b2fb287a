"""The picture of a separating experiment: how far apart the rivals will be, and the motion that does it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from exoid.ground.figures import FAINT, OKABE_ITO, figure_style, joint_colours, label, new_figure
from exoid.symbolic.joints import LEG, Joint, names, units
from exoid.symbolic.motion import Motion

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = tuple(OKABE_ITO[name] for name in ("blue", "orange", "green"))


def separation_figure(
    pairs: Sequence[str],
    distances: Sequence[tuple[str, Sequence[float]]],
    enough: float,
    title: str,
    motion: Motion | None,
    limits: Sequence[tuple[float, float]],
    joints: Sequence[Joint] = LEG,
) -> Figure:
    """Draw bars of the distances beside the angles of the motion that was designed, if there is one.

    `distances` are (kind of motion, one distance in σ per pair), `enough` the σ that distinguish a pair, `limits` the
    lowest and highest angle of each of the `joints` in rad, or m where it slides.
    """
    with figure_style():
        figure = new_figure(11.0, 4.2)
        bars, angles = figure.subplots(1, 2)
        height = 0.8 / len(distances)
        for k, ((name, values), colour) in enumerate(zip(distances, COLOURS, strict=False)):
            place = (k - 0.5 * (len(distances) - 1)) * height
            bars.barh(np.arange(len(pairs)) + place, values, height, color=colour, label=name)
        bars.axvline(enough, color=FAINT, linestyle="--", linewidth=1.0)
        bars.set_yticks(np.arange(len(pairs)), pairs)
        bars.invert_yaxis()
        bars.set(title=title, xlabel=label("distance", "σ of the noise"))
        if pairs:
            bars.legend(loc="lower right", fontsize="small")
        if motion is not None:
            for j, (name, colour) in enumerate(joint_colours(names(joints)).items()):
                angles.plot(motion.t, motion.q[:, j], color=colour, label=name)
                for level in limits[j]:
                    angles.axhline(level, color=colour, linestyle=":", linewidth=0.9)
            angles.legend(loc="upper right")
        angles.set(title="the motion, limits dotted", xlabel=label("time", "s"))
        angles.set_ylabel(label("angle", units(joints, "q")))
        angles.margins(x=0.0, y=0.2)
    return figure
