"""The identified parameters."""

from __future__ import annotations

import numpy as np

from exoid.apps.paper.experiments import ONE_SIDED, USUAL, Experiments
from exoid.apps.paper.item import IN_PART, ItemAnswer, PaperTable
from exoid.apps.paper.printed import PAPER_HUBER, PAPER_SSE
from exoid.optimisation.fitting.plausibility import check_plausibility
from exoid.symbolic.quantity import Estimate

TITLE = "the identified parameters"
SAYS = "these Φ come of the SSE and of the Huber fit."


def answer(experiments: Experiments) -> ItemAnswer:
    """Take the paper's Huber fit for the truth, and see what SSE, Huber and `exoid identify` make of it."""
    leg, fits = experiments.leg, experiments.fits
    own = np.median(experiments.identified, axis=0)
    columns = [PAPER_HUBER, PAPER_SSE]
    columns += [
        np.median([getattr(item, which) for item in fits[name]], axis=0)
        for name in (USUAL, ONE_SIDED) for which in ("sse", "huber")
    ]  # fmt: skip
    rows = [
        (f"Φ{k + 1} [{parameter.unit}]", *(f"{column[k]:.2f}" for column in (*columns, own)))
        for k, parameter in enumerate(leg.parameters)
    ]
    head = ("", "paper's Huber = the truth here", "paper's SSE", "SSE, bench", "Huber, bench", "SSE, one way",
            "Huber, one way", "`exoid identify`, bench")  # fmt: skip
    exact = [Estimate(p.name, value, p.unit, value, value) for p, value in zip(leg.parameters, PAPER_SSE, strict=True)]
    wrong = [finding.what for finding in check_plausibility(leg, PAPER_SSE, exact)]
    worst = float(np.max(np.abs(own / PAPER_HUBER - 1.0)))
    return ItemAnswer(
        f"`exoid identify` finds the leg's numbers to {100 * worst:.1f} %; of the paper's SSE it says: "
        f"{wrong[0].partition(',')[0]}.",
        IN_PART,
        "a knee that pushes itself on cannot be: Φ8 of the SSE fit is negative. Where a joint sticks, sgn θ' says "
        "nothing about dry friction; both fits keep such samples, `exoid identify` leaves them out",
        tables=(PaperTable(head, rows, "Medians; “one way”: large sensor errors that all point one way."),),
    )
