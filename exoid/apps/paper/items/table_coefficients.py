"""The published coefficients of the excitation, and what they are worth at several periods."""

from __future__ import annotations

import numpy as np

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import IN_PART, ItemAnswer, PaperTable
from exoid.measurement.trajectories.trajectory import paper_trajectory
from exoid.symbolic.quantity import JOINTS

TITLE = "the coefficients of the excitation"
SAYS = "these coefficients of the Fourier series (13) make the motion with the least condition number."
PERIODS = (8.0, 9.0, 10.0, 12.0, 15.0)


def answer(experiments: Experiments) -> ItemAnswer:
    """Evaluate them at several periods, and read as radians."""
    path = paper_trajectory()
    swing = np.abs(path.at(np.linspace(0.0, path.period, 2000)).q - path.offset)
    found = {period: experiments.published(period) for period in PERIODS}
    rows = [(f"{p:g} s", f"{item.condition:.1f}", "yes" if item.feasible else "**no**") for p, item in found.items()]
    degrees = [
        (joint, word, *(f"{value:.2f}" for value in np.rad2deg(values[j])))
        for j, joint in enumerate(JOINTS) for word, values in (("sin", path.sine), ("cos", path.cosine))
    ]  # fmt: skip
    best = experiments.designs["condition"].condition
    ten = found[10.0].condition
    return ItemAnswer(
        f"cond(Ȳ) = {ten:.1f} at 10 s; the best motion known at that period has {best:.1f}. Read as radians they would "
        f"swing a joint by {np.rad2deg(swing).max():.0f} rad.",
        IN_PART,
        "they are degrees, which is not printed, and a better motion is known",
        tables=(
            PaperTable(("joint", "", *(f"k = {k}" for k in range(1, 6))), degrees, "As printed, in degrees:"),
            PaperTable(("period", "cond(Ȳ)", "inside Table 1"), rows, "At periods the paper does not print:"),
        ),
    )
