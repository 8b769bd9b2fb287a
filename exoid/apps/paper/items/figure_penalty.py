"""The effect of the infinite penalty on the search for a motion."""

from __future__ import annotations

import numpy as np

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import IN_PART, ItemAnswer, PaperPicture, PaperTable
from exoid.apps.paper.items.figure_9 import condition_curve, run_conditions
from exoid.apps.paper.pictures import condition_figure

TITLE = "cond(Ȳ) as fitness, ∞ outside the limits"
SAYS = "NFO finds the motion with the least condition number when a motion outside Table 1 counts as ∞."


def answer(experiments: Experiments) -> ItemAnswer:
    """Search in boxes of several sizes with the penalty, and with every motion rescaled into the limits."""
    found = experiments.boxes
    ends = {name: run_conditions(found, name) for name in found.outcomes}
    inside = {name: end[np.isfinite(end)] for name, end in ends.items()}
    starved = [name for name, item in inside.items() if not item.size]
    rescaled = float(np.median(ends[list(ends)[-1]]))
    design = experiments.designs["condition"].condition
    rows = [
        (name, f"{entry.size} of {len(ends[name])}",
         f"{np.median(entry):.1f} ({entry.min():.1f} to {entry.max():.1f})" if entry.size else "∞ in every run")
        for name, entry in inside.items()
    ]  # fmt: skip
    rows += [(f"`exoid design`: {name}", "", f"{value:.1f}") for name, value in experiments.motions.known.items()]
    head = ("NFO, 20 × 400 evaluations", "runs that found a motion inside", "cond(Ȳ), median (range)")
    published = experiments.published().condition
    marks = {"the published coefficients": published, "the best motion known": found.contest.best}
    alt = "Best condition number over evaluations: rescaling falls furthest; ∞ outside with a small box stays above."
    lost = f"{'; '.join(starved)} stays at ∞ in every run; " if starved else ""
    return ItemAnswer(
        f"{lost}motions rescaled into the limits end at {rescaled:.1f}, `exoid design` at {design:.1f}.",
        IN_PART,
        "∞ gives a search nothing to compare: from a wide box it never begins, a narrow one may hold no good motion; "
        "the paper does not print its own; shrinking every motion until Table 1 holds removes the question",
        tables=(PaperTable(head, rows),),
        pictures=(PaperPicture("search", alt, condition_figure({n: condition_curve(found, n) for n in ends}, marks)),),
    )
