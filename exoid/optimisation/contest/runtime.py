"""Expected running times of optimisers, and tests of the difference between two of them.

    ERT(target) = (evaluations of all runs until they hit it, or until they gave up) / (number of runs that hit it)

Its interval is the percentile bootstrap over the seeds. Two optimisers are compared by Wilcoxon's signed-rank test on
the pairs of runs with the same first population, the p-values of one question corrected by Holm. Sources: Hansen,
Auger, Ros, Mersmann, Tušar, Brockhoff, "COCO", Optimization Methods and Software 36, 2021; Holm, Scand. J. Statistics
6, 1979.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from exoid.ground.plain import AsJson
from exoid.symbolic.motion import Float

RESAMPLES = 2000
LEVEL = 0.95


@dataclass(frozen=True)
class Runtime(AsJson):
    """Expected running time `ert` to `target` in evaluations, with its interval; `hits` of `runs` came there."""

    target: float
    ert: float
    low: float
    high: float
    hits: int
    runs: int

    @property
    def success(self) -> float:
        """Share of the runs that came to the target."""
        return self.hits / self.runs

    def _json(self) -> dict[str, Any]:
        return {**super()._json(), "success": self.success}


@dataclass(frozen=True)
class Difference(AsJson):
    """True if `first` differs from `second` in `question`: `wins` and `losses` of `first` over the pairs, p-values."""

    first: str
    second: str
    question: str
    wins: int
    losses: int
    p: float
    p_holm: float


def expected_runtime(hits: Float, budget: float, target: float, rng: np.random.Generator) -> Runtime:
    """Return the ERT of one optimiser from the evaluations `hits` (R,) at which its runs came to `target`, ∞: never."""
    reached = np.isfinite(hits)
    spent = np.where(reached, hits, budget)
    chosen = rng.integers(len(hits), size=(RESAMPLES, len(hits)))
    samples = _ert(spent[chosen].sum(axis=1), reached[chosen].sum(axis=1))
    # Not interpolated: between a number and infinity there is no number.
    edges = np.sort(samples)[[int((1 - LEVEL) / 2 * RESAMPLES), int((1 + LEVEL) / 2 * RESAMPLES)]]
    ert = float(_ert(spent.sum(keepdims=True), reached.sum(keepdims=True))[0])
    return Runtime(target, ert, float(edges[0]), float(edges[1]), int(reached.sum()), len(hits))


def _ert(spent: Float, successes: np.ndarray) -> Float:
    return np.where(successes > 0, spent / np.maximum(successes, 1), np.inf)


def runtime_ecdf(hits: Float, evaluations: Float) -> Float:
    """Return the share (G,) of pairs of run and target in `hits` (R, T) solved after `evaluations` (G,)."""
    return np.searchsorted(np.sort(hits.ravel()), evaluations, side="right") / hits.size


def quartiles(values: Float) -> Float:
    """Return the quartiles (3, ...) of runs (R, ...); between a number and infinity the lower is taken."""
    where = np.array([0.25, 0.5, 0.75])
    if np.isfinite(values).all():
        return np.asarray(np.quantile(values, where, axis=0))
    return np.asarray(np.quantile(values, where, axis=0, method="inverted_cdf"))


def differences(measured: Mapping[str, Float], against: str, question: str) -> tuple[Difference, ...]:
    """Compare all with `against`; `measured` {name: (R,)} is positive, small is good, and paired by run."""
    reference = np.log(measured[against])
    raw = []
    for name, values in measured.items():
        if name != against:
            apart = np.log(values) - reference
            raw.append((name, int(np.sum(apart < 0)), int(np.sum(apart > 0)), _signed_rank(apart)))
    corrected = holm([p for *_, p in raw])
    return tuple(
        Difference(name, against, question, wins, losses, p, c)
        for (name, wins, losses, p), c in zip(raw, corrected, strict=True)
    )


def _signed_rank(apart: Float) -> float:
    from scipy.stats import wilcoxon

    if not np.any(apart):
        return 1.0
    # Pairs that tie say that there is no difference: their ranks are split between both sides.
    return float(wilcoxon(apart, zero_method="zsplit", method="approx").pvalue)


def holm(p: Sequence[float]) -> list[float]:
    """Return p-values corrected for their number by Holm's step-down rule."""
    order = np.argsort(p, kind="stable")
    steps = np.maximum.accumulate(np.array([p[i] * (len(p) - k) for k, i in enumerate(order)], dtype=float))
    out = [1.0] * len(p)
    for place, value in zip(order, steps, strict=True):
        out[int(place)] = min(1.0, float(value))
    return out
