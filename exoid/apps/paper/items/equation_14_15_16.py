"""Equations (14) to (16): the two losses."""

from __future__ import annotations

import numpy as np

from exoid.apps.paper.experiments import USUAL, Experiments
from exoid.apps.paper.item import HOLDS, ItemAnswer
from exoid.apps.paper.printed import PAPER_DELTA
from exoid.optimisation.linear.loss import huber

TITLE = "SSE and the Huber loss"
SAYS = "SSE = Σ r²; Huber has four cases, by whether |r| of the hip and of the knee exceed δ."
TEXT = """\
r = τ - Y Φ
SSE   = Σ r1² + r2²
Huber = Σ h1 + h2,    h = r² where |r| ≤ δ,    h = 2 δ (|r| - δ/2) elsewhere
      = Σ c (2|r| - c),    c = min(|r|, δ)"""


def answer(experiments: Experiments) -> ItemAnswer:
    """Hold the loss without branches to the four printed cases, and the optimum of a fit to its proof."""
    rng = np.random.default_rng([experiments.seed, 16])
    r, (d1, d2) = PAPER_DELTA[:, None] * rng.normal(size=(2, 1000)), PAPER_DELTA
    a, b = np.abs(r)
    far = 2 * d1 * (a - d1 / 2), 2 * d2 * (b - d2 / 2)
    cases = [(a <= d1) & (b <= d2), (a > d1) & (b <= d2), (a <= d1) & (b > d2), (a > d1) & (b > d2)]
    printed = np.select(cases, [a**2 + b**2, far[0] + b**2, a**2 + far[1], far[0] + far[1]])
    apart = abs(huber(r, PAPER_DELTA) / float(printed.sum()) - 1.0)
    fit = experiments.fits[USUAL][0]
    left = fit.data.residual(fit.sse)
    squared = abs(huber(left, np.full(2, np.inf)) / float(np.sum(left**2)) - 1.0)
    return ItemAnswer(
        f"all four cases are the sum of the joints' terms (to {apart:.0e}), and δ = ∞ gives SSE (to {squared:.0e}). "
        f"Both are convex in Φ: the optimum of a fit is proven (relative duality gap {fit.proof.gap:.0e}).",
        HOLDS,
        text=TEXT,
    )

