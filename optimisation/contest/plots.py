"""Pictures of a comparison of optimisers: the way down to the optimum, targets solved over time, running times."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from ground.figures import FAINT, INK, OKABE_ITO, figure_style, label, new_figure
from optimisation.contest.runtime import runtime_ecdf

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from optimisation.contest.standings import Rivals

FLOOR = 1e-16
"""Where gaps of exactly zero are drawn; the certified optimum is the line below everything."""
ECDF_TARGETS = np.logspace(2.0, -10.0, 49)


def plot_rivals(found: Rivals) -> Figure:
    """Draw the three pictures side by side under one legend."""
    styles = _styles(found)
    with figure_style():
        figure = new_figure(13.0, 4.8)
        down, solved, times = figure.subplots(1, 3)
        plot_convergence(found, down, styles)
        plot_solved(found, solved, styles)
        plot_runtimes(found, times, styles)
        handles, names = times.get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=min(6, len(names)), fontsize="small")
    return figure


def plot_convergence(found: Rivals, axes: Axes, styles: Mapping[str, Any]) -> None:
    """Draw the median gap after each generation, and the band between the quartiles."""
    for name in found.outcomes:
        evaluations, gaps = found.convergence(name)
        low, middle, high = np.maximum(np.quantile(gaps, [0.25, 0.5, 0.75], axis=0), FLOOR)
        axes.semilogy(evaluations, middle, **styles[name])
        axes.fill_between(evaluations, low, high, color=styles[name]["color"], alpha=0.18, linewidth=0)
    axes.axhline(FLOOR, color=INK, linewidth=1.6)
    axes.annotate(
        "certified optimum (to rounding)", (1.0, FLOOR), xycoords=("axes fraction", "data"), ha="right",
        va="top", xytext=(0, -3), textcoords="offset points", fontsize="small", color=INK,
    )  # fmt: skip
    axes.set_ylim(0.02 * FLOOR, None)
    axes.set(title="Way to the optimum", xlabel="evaluations", ylabel="relative gap (median, quartiles)")


def plot_solved(found: Rivals, axes: Axes, styles: Mapping[str, Any]) -> None:
    """Draw which share of all runs and targets was solved after how many evaluations."""
    budget = found.contest.budget
    grid = np.unique(np.round(np.logspace(0.0, np.log10(budget), 300)))
    for name in found.outcomes:
        axes.semilogx(grid, runtime_ecdf(found.hits(name, ECDF_TARGETS), grid), **styles[name])
    axes.set(title="Targets solved", xlabel="evaluations", ylabel="share of runs × targets (10² … 10⁻¹⁰)")
    axes.set_ylim(-0.02, 1.02)


def plot_runtimes(found: Rivals, axes: Axes, styles: Mapping[str, Any]) -> None:
    """Draw the expected running time to each target with its interval; without a hit there is none."""
    for name, runtimes in found.runtimes.items():
        shown = [one for one in runtimes if np.isfinite(one.ert)]
        x = [one.target for one in shown]
        axes.loglog(x, [one.ert for one in shown], marker="o", markersize=3.5, label=name, **styles[name])
        banded = [one for one in shown if np.isfinite(one.high)]
        band = ([one.target for one in banded], [one.low for one in banded], [one.high for one in banded])
        axes.fill_between(*band, color=styles[name]["color"], alpha=0.18, linewidth=0)
    axes.axhline(found.contest.budget, color=FAINT, linewidth=0.8, linestyle=":")
    axes.annotate(
        "budget of one run", (1.0, found.contest.budget), xycoords=("axes fraction", "data"), xytext=(-4, 3),
        textcoords="offset points", fontsize="small", color=FAINT, ha="right",
    )  # fmt: skip
    axes.invert_xaxis()
    axes.set(
        title="Expected running time",
        xlabel="target: relative gap",
        ylabel=label("ERT and 95 % interval", "evaluations"),
    )


def _styles(found: Rivals) -> dict[str, dict[str, Any]]:
    """Return the line of each optimiser: one colour per algorithm, dashed where it searches whitened coordinates."""
    bases = {name: name.removesuffix("_whitened") for name in found.outcomes}
    colours = [OKABE_ITO[c] for c in ("vermilion", "blue", "green", "orange", "purple", "sky", "yellow")]
    order = sorted(set(bases.values()), key=list(bases.values()).index)
    return {
        name: {
            "color": colours[order.index(base) % len(colours)],
            "linestyle": "--" if found.searches[name].whitened else "-",
        }
        for name, base in bases.items()
    }
