"""Drawings of what is identified: the leg along its motion, the mechanism with its symbols, the recording loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.ground.figures import FAINT, GRID, INK, OKABE_ITO, PAPER, figure_style, joint_colours, label, new_figure
from exoid.symbolic.model_structure import Limits
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

POSES = 14
GREEN = OKABE_ITO["green"]
LEG_COLOURS = joint_colours(["hip", "knee"])
HIP, KNEE = LEG_COLOURS.values()


def leg_figure(q: Float, lengths: tuple[float, float], limits: Sequence[Limits]) -> Figure:
    """Draw the leg in postures `q` (N, 2) rad, and what `limits` let its end reach; `lengths` of thigh and shank, m."""
    with figure_style():
        figure = new_figure(5.0, 4.6)
        axes = figure.subplots()
        edge = _edge([limit.angle for limit in limits])
        reach = points_of(edge, lengths)[:, 2]
        axes.fill(*reach.T, color=GRID, alpha=0.6, linewidth=0, label="what Table 1 lets the end reach")
        for k, (hip, knee, end) in enumerate(points_of(q, lengths)):
            for start, stop, colour, name in ((hip, knee, HIP, "thigh"), (knee, end, KNEE, "shank")):
                shown = name if k == len(q) - 1 else None
                way, alpha = np.transpose([start, stop]), 0.25 + 0.7 * k / len(q)
                axes.plot(*way, color=colour, label=shown, alpha=alpha, solid_capstyle="round", linewidth=2.5)
        axes.plot(0.0, 0.0, "o", color=INK, markersize=7)
        axes.set(aspect="equal", xlabel=label("forwards", "m"), ylabel=label("upwards", "m"))
        figure.legend(loc="outside lower center", ncols=3, fontsize=8)
    return figure


def points_of(q: Float, lengths: tuple[float, float]) -> Float:
    """Return hip, knee and end (N, 3, 2), m, forwards and upwards, for angles `q` (N, 2)."""
    thigh, shank = lengths
    first, second = q[:, 0], q[:, 0] + q[:, 1]
    knee = thigh * np.column_stack([np.sin(first), -np.cos(first)])
    end = knee + shank * np.column_stack([np.sin(second), -np.cos(second)])
    return np.stack([np.zeros_like(knee), knee, end], axis=1)


def _edge(ranges: Sequence[tuple[float, float]], steps: int = 60) -> Float:
    """Return angles (N, 2) once around the rectangle of the two ranges."""
    (a, b), (c, d) = ranges
    up, along = np.linspace(a, b, steps), np.linspace(c, d, steps)
    still = np.ones(steps)
    sides = ((up, c * still), (b * still, along), (up[::-1], d * still), (a * still, along[::-1]))
    return np.concatenate([np.column_stack(side) for side in sides])


def mechanism_figure() -> Figure:
    """Draw the two links with their angles, lengths, centres of mass and the forces at the cuffs."""
    with figure_style():
        figure = new_figure(5.4, 4.8)
        axes = figure.subplots()
        q = np.array([[0.75, -1.25]])
        hip, knee, end = points_of(q, (1.0, 1.0))[0]
        first = -0.5 * np.pi + q[0, 0]
        axes.plot([-0.25, 0.25], [0.0, 0.0], color=INK, linewidth=2.0)
        axes.plot([0.0, 0.0], [0.0, -0.38], color=FAINT, linestyle=":")
        axes.plot(*np.transpose([knee, knee + 0.6 * (knee - hip)]), color=FAINT, linestyle=":")
        for start, stop, colour, mass in ((hip, knee, HIP, "m_th, I_th"), (knee, end, KNEE, "m_sh, I_sh")):
            along, centre = stop - start, start + 0.5 * (stop - start)
            out = _across(along)
            axes.plot(*np.transpose([start, stop]), color=colour, linewidth=5.0, solid_capstyle="round", zorder=2)
            axes.plot(*start, "o", color=INK, markersize=9, zorder=3)
            axes.plot(*centre, "o", color=PAPER, markeredgecolor=INK, markersize=8, zorder=3)
            _text(axes, centre + 0.14 * out, mass, ha="right", va="center", color=INK)
            cuff = start + 0.8 * along
            axes.annotate("", cuff, cuff + 0.35 * out, arrowprops={"arrowstyle": "->", "color": GREEN})
        axes.text(end[0] - 0.36, end[1] + 0.12, "F_dis at\nthe cuffs", ha="right", va="center", color=GREEN)
        _arc(axes, hip, (-0.5 * np.pi, first), 0.22, "θ1")
        _arc(axes, knee, (first, first + q[0, 1]), 0.5, "θ2")
        _dimension(axes, hip, 0.5 * knee, "l_th", 0.12)
        _dimension(axes, hip, knee, "a_th", 0.3)
        _dimension(axes, knee, 0.5 * (knee + end), "l_sh", 0.12)
        axes.annotate("", (1.4, -0.45), (1.4, -0.1), arrowprops={"arrowstyle": "->", "color": FAINT})
        axes.text(1.46, -0.28, "g", color=INK)
        axes.set(aspect="equal", xlim=(-0.5, 1.7), ylim=(-1.85, 0.25))
        axes.axis("off")
    return figure


def _across(along: Float) -> Float:
    return np.asarray(np.array([along[1], -along[0]]) / np.hypot(*along))


def _dimension(axes: Axes, start: Float, stop: Float, text: str, off: float) -> None:
    """Write a length beside the link, `off` from it."""
    shift = -off * _across(stop - start)
    arrow = {"arrowstyle": "<->", "color": FAINT, "shrinkA": 0, "shrinkB": 0}
    (x1, y1), (x2, y2) = start + shift, stop + shift
    axes.annotate("", (x1, y1), (x2, y2), arrowprops=arrow)
    _text(axes, 0.5 * (start + stop) + shift - 0.06 * _across(stop - start), text, ha="left", va="center", color=INK)


def _arc(axes: Axes, centre: Float, angles: tuple[float, float], radius: float, text: str) -> None:
    """Draw an angle from the first to the second, with an arrow at its end."""
    turn = np.linspace(*angles, 40)
    x, y = centre[0] + radius * np.cos(turn), centre[1] + radius * np.sin(turn)
    axes.plot(x, y, color=INK, linewidth=1.0)
    axes.annotate("", (x[-1], y[-1]), (x[-3], y[-3]), arrowprops={"arrowstyle": "->", "color": INK})
    middle = turn[len(turn) // 2]
    away = np.array([np.cos(middle), np.sin(middle)])
    _text(axes, centre + (radius + 0.1) * away, text, ha="center", va="center", color=INK)


def _text(axes: Axes, place: Float, text: str, **how: Any) -> None:
    axes.text(float(place[0]), float(place[1]), text, **how)


HIGH = 0.42
"""Half of the height of a block."""
BLOCKS: Mapping[str, tuple[float, float, float, str]] = {
    "motion": (0.0, 0.0, 0.75, "excitation\nθ_d(t)"),
    "control": (2.3, 0.0, 0.75, "PD control,\n1 kHz"),
    "drive": (4.6, 0.0, 0.8, "motors,\ntorque limit"),
    "leg": (7.6, 0.0, 1.45, "leg:\nM θ'' + C θ' + G + τ_f"),
    "encoder": (4.6, -1.5, 0.85, "encoders,\ndifferentiator"),
    "record": (11.0, 0.0, 1.2, "recording, 100 Hz:\nθ, τ, F"),
    "wearer": (7.6, 1.5, 0.95, "wearer:\nF at the cuffs"),
}
"""Centre, half of the width, and words of each block of the loop."""
ARROWS: Sequence[tuple[str, str, str]] = (
    ("motion", "control", ""), ("control", "drive", ""), ("drive", "leg", "τ"), ("leg", "record", ""),
    ("leg", "encoder", "θ"), ("encoder", "control", "θ, θ'"), ("wearer", "leg", "τ_dis = Jᵀ F"),
)  # fmt: skip


def loop_figure(t: Float, wanted: Float, followed: Float) -> Figure:
    """Draw the loop that records, and how closely the leg follows: angles (N, 2) rad over `t` (N,) s."""
    with figure_style():
        figure = new_figure(8.6, 5.4)
        above, below = figure.subplots(2, 1, height_ratios=(1.3, 1.0))
        for x, y, half, words in BLOCKS.values():
            above.fill(*_frame(x, y, half), facecolor="none", edgecolor=FAINT, linewidth=1.0)
            above.text(x, y, words, ha="center", va="center", fontsize=8.5, color=INK)
        for start, stop, words in ARROWS:
            _arrow(above, BLOCKS[start], BLOCKS[stop], words)
        above.set(xlim=(-0.9, 12.3), ylim=(-2.0, 2.0))
        above.axis("off")
        for j, (joint, colour) in enumerate(LEG_COLOURS.items()):
            below.plot(t, wanted[:, j], color=FAINT, linewidth=3.0, alpha=0.6, label="asked for" if not j else None)
            below.plot(t, followed[:, j], color=colour, linestyle=("-", "--")[j], label=joint)
        below.set(xlabel=label("time", "s"), ylabel=label("angle", "rad"))
        below.margins(x=0.0)
        figure.legend(loc="outside lower center", ncols=3, fontsize=8)
    return figure


def _frame(x: float, y: float, half: float) -> tuple[Sequence[float], Sequence[float]]:
    return (x - half, x + half, x + half, x - half), (y - HIGH, y - HIGH, y + HIGH, y + HIGH)


def _arrow(axes: Axes, start: Sequence[Any], stop: Sequence[Any], words: str) -> None:
    """Draw an arrow from the edge of one block to that of another, round one corner where they are not in line."""
    (x1, y1, half1, _), (x2, y2, half2, _) = start, stop
    side, up = np.sign(x2 - x1), np.sign(y2 - y1)
    if not up:
        way = [(x1 + side * half1, y1), (x2 - side * half2, y2)]
    elif not side:
        way = [(x1, y1 + up * HIGH), (x2, y2 - up * HIGH)]
    elif up < 0:  # down and then aside
        way = [(x1, y1 + up * HIGH), (x1, y2), (x2 - side * half2, y2)]
    else:
        way = [(x1 + side * half1, y1), (x2, y1), (x2, y2 - up * HIGH)]
    axes.plot(*np.transpose(way), color=INK, linewidth=1.0)
    axes.annotate("", way[-1], way[-2], arrowprops={"arrowstyle": "->", "color": INK, "shrinkA": 0, "shrinkB": 0})
    (x, y), (x_end, y_end) = way[:2]
    across = x != x_end
    place = (0.5 * (x + x_end), y + 0.1) if across else (x + 0.12, 0.5 * (y + y_end))
    how: dict[str, Any] = {"ha": "center", "va": "bottom"} if across else {"ha": "left", "va": "center"}
    axes.text(*place, words, fontsize=8.5, color=INK, **how)
