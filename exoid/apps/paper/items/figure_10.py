"""PSO, GA and NFO on the fit."""

from __future__ import annotations

import numpy as np

from exoid.apps.paper.experiments import ENTRANTS, Experiments
from exoid.apps.paper.item import FAILS, HOLDS, ItemAnswer, PaperPicture, PaperTable
from exoid.apps.paper.pictures import gap_figure
from exoid.optimisation.contest.standings import Rivals

TITLE = "PSO, GA and NFO on the fit (SSE, and Huber beside it)"
SAYS = "minimising SSE, NFO reaches the optimum, and before PSO and GA."
LEAST = 1e-16
"""Gaps below this are rounding."""


def answer(experiments: Experiments) -> ItemAnswer:
    """Compare them with the optimum, which is proven: both losses are convex."""
    found = experiments.on_fits
    squared = found["SSE"]
    middle = {name: float(np.median(squared.gaps(name))) for name in squared.outcomes}
    order = sorted(ENTRANTS, key=lambda name: middle[name])
    arrived = squared.runtimes["nfo"][-1].hits
    soon = {name: squared.runtimes[name][-1] for name in squared.outcomes if name.endswith("_whitened")}
    right = order[0] == "nfo" and arrived == len(squared.seeds)
    last = squared.contest.targets[-1]
    whitened = ", ".join(f"{_written(name)} in {entry.hits} of {entry.runs} runs" for name, entry in soon.items())
    panels = {
        loss: {_written(name): item.convergence(name) for name in item.outcomes} for loss, item in found.items()
    }
    alt = "Relative distance to the proven optimum over evaluations of NFO, PSO and GA; left SSE, right Huber."
    return ItemAnswer(
        "after 40 × 400 evaluations of SSE the median is " + ", ".join(f"{middle[n]:.0e} ({n.upper()})" for n in order)
        + f" above the proven optimum; in whitened coordinates within {last:.0e} come {whitened}.",
        HOLDS if right else FAILS,
        "" if right else f"as printed {order[0].upper()} is ahead; “nearest” is a Euclidean word, and in physical "
        "coordinates a kg·m² and an N·m·s/rad count alike although the torque feels one of them a hundred times more",
        tables=tuple(_table(loss, element) for loss, element in found.items()),
        pictures=(PaperPicture("convergence", alt, gap_figure(panels, LEAST)),),
    )  # fmt: skip


def _written(name: str) -> str:
    base, _, whitened = name.partition("_")
    return base.upper() + (", whitened" if whitened else "")


def _table(loss: str, found: Rivals) -> PaperTable:
    rows = []
    for name in found.outcomes:
        gaps, time = np.maximum(found.gaps(name), LEAST), found.runtimes[name][-1]
        expected = f"{time.ert:.0f}" if np.isfinite(time.ert) else "–"
        spread = f"{gaps.min():.0e} to {gaps.max():.0e}"
        rows.append((_written(name), f"{np.median(gaps):.0e}", spread, f"{time.hits} of {time.runs}", expected))
    target = found.contest.targets[-1]
    head = (f"{loss}, 40 × 400 evaluations", "relative distance, median", "range", f"runs within {target:.0e}",
            "evaluations expected until then")  # fmt: skip
    return PaperTable(head, rows)
