"""The thresholds of the Huber loss."""

from __future__ import annotations

import numpy as np

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import HOLDS, ItemAnswer, PaperTable
from exoid.apps.paper.printed import PAPER_DELTA
from exoid.optimisation.linear.loss import OUTLIER_SHARE

TITLE = "the thresholds δ"
SAYS = f"δ leaves {100 * OUTLIER_SHARE:.0f} % of the points outside: {PAPER_DELTA[0]} and {PAPER_DELTA[1]} N·m."


def answer(experiments: Experiments) -> ItemAnswer:
    """Apply the rule to recordings with three kinds of sensor errors."""
    rows, shares = [], []
    for name, several in experiments.fits.items():
        delta = np.median([entry.delta for entry in several], axis=0)
        outside = [np.mean(np.abs(item.data.residual(item.sse)) > item.delta[:, None]) for item in several]
        shares += outside
        gap = max(element.proof.gap for element in several)
        rows.append((name, f"{delta[0]:.0f} / {delta[1]:.0f}", f"{100 * np.median(outside):.1f} %", f"{gap:.0e}"))
    head = ("errors of the torque sensor", "δ hip / knee [N·m]", "points outside", "largest duality gap of Huber's fit")
    return ItemAnswer(
        f"the rule leaves {100 * min(shares):.1f} to {100 * max(shares):.1f} % outside, and gives about the paper's δ "
        "only where torque errors are about as large as that: its values say how rough its torque was.",
        HOLDS,
        tables=(PaperTable(head, rows),),
    )
