"""Pictures of a comparison of optimisers: the way down to the optimum, targets solved over time, running times."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.ground.figures import FAINT, INK, OKABE_ITO, figure_style, label, new_figure
from exoid.optimisation.contest.runtime import Runtime, quartiles, runtime_ecdf
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

DASHES = {"whitened": "--", "penalty": ":"}
"""Line of a variant of an optimiser, by the last word of its name."""


@dataclass(frozen=True, eq=False)
class Goal:
    """Reference of the gaps, in words; the `targets` (T,) that are drawn; where gaps of zero are."""

    name: str
    targets: Float
    floor: float


@dataclass(frozen=True, eq=False)
class Entrant:
    """Curves of one optimiser: the best `gaps` (R, G) of its runs after `evaluations` (G,), the evaluations
    `hits` (R, T) at which each run came to each of the drawn targets, and its `runtimes`, one per target asked for.
    """

    name: str
    evaluations: Float
    gaps: Float
    hits: Float
    runtimes: Sequence[Runtime]


def contest_figure(entrants: Sequence[Entrant], budget: int, goal: Goal) -> Figure:
    """Draw convergence, solved targets and running times side by side under one legend."""
    styles = _styles(entrants)
    with figure_style():
        figure = new_figure(13.0, 4.8)
        down, solved, times = figure.subplots(1, 3)
        _convergence(entrants, goal, down, styles)
        _solved(entrants, budget, goal, solved, styles)
        _runtimes(entrants, budget, times, styles)
        handles, names = times.get_legend_handles_labels()
        figure.legend(handles, names, loc="outside lower center", ncols=min(6, len(names)), fontsize="small")
    return figure


def _convergence(entrants: Sequence[Entrant], goal: Goal, axes: Axes, styles: Mapping[str, Any]) -> None:
    """Draw the median gap after each generation, and the band between the quartiles."""
    from matplotlib.ticker import MaxNLocator

    for entrant in entrants:
        found = np.maximum(quartiles(entrant.gaps), goal.floor)
        low, middle, high = np.where(np.isfinite(found), found, np.nan)  # what is infinite is not drawn
        axes.semilogy(entrant.evaluations, middle, **styles[entrant.name])
        axes.fill_between(entrant.evaluations, low, high, color=styles[entrant.name]["color"], alpha=0.18, linewidth=0)
    axes.axhline(goal.floor, color=INK, linewidth=1.6)
    axes.annotate(
        goal.name, (1.0, goal.floor), xycoords=("axes fraction", "data"), ha="right",
        va="top", xytext=(0, -3), textcoords="offset points", fontsize="small", color=INK,
    )  # fmt: skip
    axes.xaxis.set_major_locator(MaxNLocator(4))  # five digits each
    axes.set_ylim(goal.floor * (0.02 if goal.floor < 1e-9 else 0.5), None)
    axes.set(title="Way to the optimum", xlabel="evaluations", ylabel="relative gap (median, quartiles)")


def _solved(
    entrants: Sequence[Entrant], budget: int, goal: Goal, axes: Axes, styles: Mapping[str, Any]
) -> None:
    """Draw which share of all runs and targets was solved after how many evaluations."""
    grid = np.unique(np.round(np.logspace(0.0, np.log10(budget), 300)))
    for entrant in entrants:
        axes.semilogx(grid, runtime_ecdf(entrant.hits, grid), **styles[entrant.name])
    axes.set(title="Targets solved", xlabel="evaluations", ylabel="share of runs × targets")
    targets = f"targets: gaps of {goal.targets[0]:g} … {goal.targets[-1]:.0e}"
    axes.annotate(targets, (0.03, 0.94), xycoords="axes fraction", fontsize="small", color=FAINT)
    axes.set_ylim(-0.02, 1.02)


def _runtimes(entrants: Sequence[Entrant], budget: int, axes: Axes, styles: Mapping[str, Any]) -> None:
    """Draw the expected running time to each target with its interval; without a hit there is none."""
    for entrant in entrants:
        style = styles[entrant.name]
        shown = [r for r in entrant.runtimes if np.isfinite(r.ert)]
        points = ([r.target for r in shown], [r.ert for r in shown])
        axes.loglog(*points, marker="o", markersize=3.5, label=entrant.name, **style)
        banded = [r for r in shown if np.isfinite(r.high)]
        band = ([r.target for r in banded], [r.low for r in banded], [r.high for r in banded])
        axes.fill_between(*band, color=style["color"], alpha=0.18, linewidth=0)
    axes.axhline(budget, color=FAINT, linewidth=0.8, linestyle=":")
    axes.annotate(
        "budget of one run", (1.0, budget), xycoords=("axes fraction", "data"), xytext=(-4, 3),
        textcoords="offset points", fontsize="small", color=FAINT, ha="right",
    )  # fmt: skip
    axes.invert_xaxis()
    axes.set(
        title="Expected running time",
        xlabel="target: relative gap",
        ylabel=label("ERT and 95 % interval", "evaluations"),
    )


def _styles(entrants: Sequence[Entrant]) -> dict[str, dict[str, Any]]:
    """Return the line of each optimiser: one colour per algorithm, one dash per variant."""
    variants = {item.name: next((word for word in DASHES if item.name.endswith(f"_{word}")), "") for item in entrants}
    bases = {name: name.removesuffix(f"_{word}") for name, word in variants.items()}
    colours = [OKABE_ITO[c] for c in ("vermilion", "blue", "green", "orange", "purple", "sky", "yellow")]
    order = sorted(set(bases.values()), key=list(bases.values()).index)
    return {
        entrant.name: {
            "color": colours[order.index(bases[entrant.name]) % len(colours)],
            "linestyle": DASHES.get(variants[entrant.name], "-"),
        }
        for entrant in entrants
    }
