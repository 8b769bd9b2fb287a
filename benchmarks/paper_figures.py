"""The figures of docs/paper.md, in the one style of all figures."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING

import numpy as np
from paper_experiments import ERRORS, Curves, Fits, Search

from ground.figures import FAINT, INK, OKABE_ITO, figure_style, label, new_figure
from symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COLOURS = (OKABE_ITO["blue"], OKABE_ITO["vermilion"], OKABE_ITO["green"], OKABE_ITO["purple"], OKABE_ITO["orange"])
DASHES = ("-", "--", "-.", ":", (0, (3, 1, 1, 1)))


def search(found: Mapping[str, Search], published: float, best: float) -> Figure:
    """Draw the best condition number against evaluations: the median of the runs, and their range."""
    with figure_style():
        figure = new_figure(7.0, 3.8)
        axes = figure.subplots()
        for (name, one), colour, dash in zip(found.items(), COLOURS, DASHES, strict=False):
            middle = np.median(one.history, axis=0)
            if not np.isfinite(middle).any():
                axes.plot([], [], color=colour, linestyle=dash, label=f"{name}: ∞ throughout")
                continue
            axes.plot(one.counts, middle, color=colour, linestyle=dash, label=name)
            low, high = one.history.min(axis=0), np.where(np.isfinite(one.history), one.history, 1e6).max(axis=0)
            axes.fill_between(one.counts, low, high, color=colour, alpha=0.15, linewidth=0)
        axes.axhline(published, color=INK, linewidth=0.9, linestyle=":", label="the published coefficients")
        axes.axhline(best, color=INK, linewidth=1.0, linestyle="--", label="the best motion known")
        axes.set(yscale="log", ylim=(50, 300), xlabel="evaluations", ylabel="condition number of Ȳ")
        axes.set_yticks([50, 75, 100, 150, 200, 300], ["50", "75", "100", "150", "200", "300"])
        axes.minorticks_off()
        axes.legend(fontsize=8)
    return figure


def fit(one: Fits) -> Figure:
    """Draw measured torque on unseen motion, what SSE and Huber predict, and the true torque."""
    shown = slice(500, 1500)
    t = np.arange(one.verify.tau.shape[1]) / 100.0
    with figure_style():
        figure = new_figure(7.4, 5.0)
        for j, axes in enumerate(figure.subplots(2, 1, sharex=True)):
            axes.plot(t[shown], one.verify.tau[j][shown], color=FAINT, linewidth=0.5, alpha=0.6, label="measured")
            axes.plot(t[shown], one.truth.tau[j][shown], color=INK, linewidth=1.8, label="true")
            for name, linear, colour, dash in (
                ("SSE", one.sse, OKABE_ITO["vermilion"], "--"), ("Huber", one.huber, OKABE_ITO["blue"], "-"),
            ):  # fmt: skip
                predicted = one.verify.columns[j] @ linear
                axes.plot(t[shown], predicted[shown], color=colour, linestyle=dash, linewidth=1.1, label=name)
            axes.set(title=JOINTS[j], ylabel=label("torque", "N·m"))
        axes.set(xlabel=label("time", "s"))
        handles, names = axes.get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=4)
    return figure


def ratios(found: Mapping[str, list[Fits]], paper: float) -> Figure:
    """Draw Huber's error over that of SSE on unseen motion, one dot per seed."""
    with figure_style():
        figure = new_figure(7.0, 3.0)
        axes = figure.subplots()
        for row, name in enumerate(ERRORS):
            for against, marker, colour, shift in (
                ("measured", "o", OKABE_ITO["purple"], 0.14), ("true", "s", OKABE_ITO["blue"], -0.14),
            ):  # fmt: skip
                x = [one.ratio(against) for one in found[name]]
                text = f"against the {against} torque" if row == 0 else None
                axes.plot(x, np.full(len(x), row + shift), marker, color=colour, alpha=0.6, label=text)
        axes.axvline(1.0, color=FAINT, linewidth=0.8)
        axes.axvline(paper, color=INK, linewidth=1.0, linestyle="--", label=f"the paper: {paper}")
        axes.set_yticks(range(len(ERRORS)), list(ERRORS))
        axes.set(xlabel="RMS error of Huber / of SSE on unseen motion", ylim=(-0.5, len(ERRORS) - 0.5))
        axes.invert_yaxis()
        figure.legend(loc="outside lower center", ncols=3, fontsize=8)
    return figure


def convergence(found: Curves) -> Figure:
    """Draw how far each optimiser is above the certified optimum: the median of the runs, and their range."""
    with figure_style():
        figure = new_figure(7.0, 4.0)
        axes = figure.subplots()
        for place, (name, gaps) in enumerate(found.gaps.items()):
            # One colour per optimiser, one dash per kind of coordinates.
            colour, dash = COLOURS[place % 3], "--" if "whitened" in name else "-"
            counts = found.counts[name]
            axes.semilogy(counts, np.median(gaps, axis=0), color=colour, linestyle=dash, label=name)
            axes.fill_between(counts, gaps.min(axis=0), gaps.max(axis=0), color=colour, alpha=0.15, linewidth=0)
        axes.axhline(1e-16, color=INK, linewidth=1.2, label="certified optimum (rounding)")
        axes.axhline(1e-9, color=FAINT, linewidth=0.9, linestyle=":", label="proven from here on")
        axes.set(xlabel="evaluations", ylabel="relative distance to the optimum", ylim=(3e-17, None))
        figure.legend(fontsize=8, loc="outside lower center", ncols=3)
    return figure
