"""Placebos, by which chance is judged: the same entry, shifted in time, sent through the same search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.gram import Gram
from exoid.diagnosis.evidence.score import Score, admissible, own_nodes

AT_ONCE = 12
"""Nodes that are tried in one piece of work."""
TOGETHER = 40_000
"""Nodes times placebos whose sums are held at once: of an arm, 5 kB each."""


def placebo(evidence: Evidence, score: Score, columns: Sequence[Columns]) -> Score:
    """Return `score` with its p-value: the share of placebos that gain as much, the candidate itself counted among
    them. One with a forbidden sign would not have been accepted either.
    """
    candidate, rules = score.candidate, evidence.rules
    seen = score.share * float(evidence.fold_losses.sum())
    if seen <= 0.0:  # a placebo that gains nothing is as good
        return replace(score, p_value=1.0)
    different, back = evidence.different_shifts
    good = np.zeros(len(different[0]), dtype=bool)

    def shifted(nodes: np.ndarray) -> list[Columns]:
        return [
            _telegraph(c.some(nodes), rules.telegraph * block.rate, r)
            for r, (c, block) in enumerate(zip(columns, evidence.blocks, strict=True))
        ]

    def exceed(grams: Gram) -> np.ndarray:
        return evidence.exceed(grams, seen, lambda values: admissible(candidate, values, rules))

    common = candidate.common
    if common.size > rules.placebo_nodes:
        common = np.union1d(common[:: int(np.ceil(common.size / rules.placebo_nodes))], score.nodes[:1])
    for nodes in filter(len, np.array_split(common, -(-common.size // AT_ONCE) or 1)):
        some = shifted(nodes)
        for v in range(len(nodes)):
            if (left := np.flatnonzero(~good)).size:
                good[left] = exceed(evidence.shifted(some, v, trained=True, by=[each[left] for each in different]))
    for nodes in candidate.groups:
        some, left = shifted(nodes), np.flatnonzero(~good)
        for piece in filter(len, np.array_split(left, -(-len(nodes) * left.size // TOGETHER) or 1)):
            each = (evidence.shifted(some, v, by=[each[piece] for each in different]) for v in range(len(nodes)))
            grams = Gram.stacked(each, len(nodes))
            good[piece] = exceed(evidence.pick(grams, own_nodes(evidence, candidate, grams)))
    return replace(score, p_value=(1 + int(np.count_nonzero(good[back]))) / (1 + evidence.draws))


def _telegraph(columns: Columns, samples: float, seed: int) -> Columns:
    """Return columns whose constants change sign at random about every `samples`: a shift changes no constant."""
    values = columns.values
    still = np.ptp(values, axis=2) <= 1e-6 * np.maximum(np.abs(values).max(axis=2), 1e-300)  # (V, A, m)
    still &= np.abs(values).max(axis=2) > 0.0
    if not still.any():
        return columns
    rng = np.random.default_rng(seed)
    count = int(np.ceil(values.shape[2] / max(1.0, samples)))
    signs = rng.permutation(np.arange(count) % 2) * 2.0 - 1.0
    sign = np.repeat(signs, int(np.ceil(values.shape[2] / count)))[: values.shape[2]]
    return Columns(columns.joints, np.where(still[:, :, None, :], values * sign[None, None, :, None], values))
