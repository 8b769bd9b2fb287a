"""The pictures of the paper's experiments, in the one style of all figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from exoid.ground.figures import FAINT, INK, OKABE_ITO, figure_style, label, new_figure
from exoid.optimisation.contest.runtime import quartiles
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLOURS = tuple(OKABE_ITO[name] for name in ("vermilion", "blue", "green", "orange", "purple", "sky", "yellow"))
FITTED = {"SSE": (OKABE_ITO["vermilion"], "--"), "Huber": (OKABE_ITO["blue"], "-")}
VARIANTS = (", whitened", ", ∞ outside")
"""Ends of names of what is drawn in the colour of the same optimiser, dashed."""
Lines = Mapping[str, tuple[Float, Float]]
"""{name: evaluations (G,), values (R, G) of its runs}"""


def torque_figure(t: Float, measured: Float, true: Float, predicted: Mapping[str, Float]) -> Figure:
    """Draw torques (J, N) over `t` (N,) s: measured, true, and what each fit predicts."""
    with figure_style():
        figure = new_figure(7.4, 5.0)
        for j, axes in enumerate(figure.subplots(2, 1, sharex=True)):
            axes.plot(t, measured[j], color=FAINT, linewidth=0.5, alpha=0.6, label="measured")
            axes.plot(t, true[j], color=INK, linewidth=1.8, label="true")
            for name, torque in predicted.items():
                colour, dash = FITTED[name]
                axes.plot(t, torque[j], color=colour, linestyle=dash, linewidth=1.1, label=name)
            axes.set(title=JOINTS[j], ylabel=label("torque", "N·m"))
            axes.margins(x=0.0)
        axes.set(xlabel=label("time", "s"))
        figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def ratio_figure(ratios: Mapping[str, Mapping[str, Sequence[float]]], printed: float) -> Figure:
    """Draw Huber's error over that of SSE, one dot per seed: {kind of error: {"measured" or "true": ratios}}."""
    with figure_style():
        figure = new_figure(7.0, 3.0)
        axes = figure.subplots()
        for row, ratio in enumerate(ratios.values()):
            for against, marker, colour, shift in (
                ("measured", "o", OKABE_ITO["purple"], 0.14), ("true", "s", OKABE_ITO["blue"], -0.14),
            ):  # fmt: skip
                text = f"against the {against} torque" if row == 0 else None
                x = ratio[against]
                axes.plot(x, np.full(len(x), row + shift), marker, color=colour, alpha=0.6, label=text)
        axes.axvline(1.0, color=FAINT, linewidth=0.8)
        axes.axvline(printed, color=INK, linewidth=1.0, linestyle="--", label=f"the paper: {printed}")
        axes.set_yticks(range(len(ratios)), list(ratios))
        axes.set(xlabel="RMS error of Huber / of SSE on unseen motion", ylim=(-0.5, len(ratios) - 0.5))
        axes.invert_yaxis()
        figure.legend(loc="outside lower center", ncols=3, fontsize=8)
    return figure


def gap_figure(panels: Mapping[str, Lines], floor: float) -> Figure:
    """Draw the relative distance to the proven optimum over evaluations, a panel per loss: median and quartiles."""
    with figure_style():
        figure = new_figure(10.0, 4.2)
        for axes, (title, lines) in zip(figure.subplots(1, len(panels), sharey=True), panels.items(), strict=True):
            _lines(axes, {name: (x, np.maximum(gaps, floor)) for name, (x, gaps) in lines.items()})
            axes.axhline(floor, color=INK, linewidth=1.2, label="certified optimum (rounding)")
            axes.set(yscale="log", title=title, xlabel="evaluations", ylim=(0.3 * floor, None))
        figure.axes[0].set_ylabel("relative distance to the optimum")
        figure.legend(*figure.axes[0].get_legend_handles_labels(), fontsize=8, loc="outside lower center", ncols=4)
    return figure


def condition_figure(lines: Lines, marks: Mapping[str, float]) -> Figure:
    """Draw the best condition number over evaluations, median and quartiles, with horizontal `marks`."""
    with figure_style():
        figure = new_figure(7.4, 4.4)
        axes = figure.subplots()
        _lines(axes, lines)
        for (name, value), dash in zip(marks.items(), (":", "--", "-."), strict=False):
            axes.axhline(value, color=INK, linewidth=1.0, linestyle=dash, label=name)
        axes.set(yscale="log", ylim=(50, 210), xlabel="evaluations", ylabel="condition number of Ȳ")
        axes.set_yticks([50, 60, 75, 100, 150, 200], ["50", "60", "75", "100", "150", "200"])
        axes.minorticks_off()
        figure.legend(fontsize=8, loc="outside lower center", ncols=3)
    return figure


def _lines(axes: Axes, lines: Lines) -> None:
    """Draw median and quartiles of runs: one colour per optimiser, dashed where it is a variant."""
    order: list[str] = []
    for name, (x, values) in lines.items():
        base = next((name.removesuffix(end) for end in VARIANTS if name.endswith(end)), name)
        order += [] if base in order else [base]
        colour, dash = COLOURS[order.index(base) % len(COLOURS)], "-" if base == name else "--"
        low, middle, high = quartiles(values)
        if not np.isfinite(middle).any():
            axes.plot([], [], color=colour, linestyle=dash, label=f"{name}: ∞ throughout")
            continue
        low, middle, high = (np.where(np.isfinite(item), item, np.nan) for item in (low, middle, high))
        axes.plot(x, middle, color=colour, linestyle=dash, label=name)
        axes.fill_between(x, low, high, color=colour, alpha=0.15, linewidth=0)


def criteria_figure(scores: Mapping[str, Mapping[str, float]]) -> Figure:
    """Draw how much worse than the best each motion is by each measure: {motion: {measure: factor ≥ 1}}."""
    with figure_style():
        figure = new_figure(7.0, 3.4)
        axes = figure.subplots()
        measures = list(next(iter(scores.values())))
        wide = 0.8 / len(scores)
        for k, ((name, item), colour) in enumerate(zip(scores.items(), COLOURS, strict=False)):
            place = np.arange(len(measures)) + (k - 0.5 * (len(scores) - 1)) * wide
            axes.bar(place, list(item.values()), width=0.92 * wide, color=colour, label=name)
        axes.axhline(1.0, color=INK, linewidth=0.8)
        axes.set_xticks(range(len(measures)), measures)
        axes.set(ylabel="times the best motion's", ylim=(0.9, None))
        figure.legend(loc="outside lower center", ncols=2, fontsize=8)
    return figure
