"""Placebos, by which chance is judged: the same entry, shifted in time, sent through the same search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.gram import Gram
from exoid.diagnosis.evidence.score import Score, admissible, own_nodes

AT_ONCE = 12
"""Nodes that are tried in one piece of work."""
TOGETHER = 40_000
"""Nodes times placebos whose sums are held at once: of an arm, 5 kB each."""


@dataclass(frozen=True, eq=False)
class PlaceboSearch:
    """A part of a placebo's search: the `nodes` that are tried, and whether each recording chooses `own` among them."""

    nodes: np.ndarray
    own: bool


def placebo(evidence: Evidence, score: Score, columns: Sequence[Columns]) -> Score:
    """Return `score` with its p-value."""
    found = [as_good(evidence, score, columns, part) for part in searches(evidence, score)]
    return replace(score, p_value=p_value(evidence, found))


def p_value(evidence: Evidence, found: Sequence[np.ndarray]) -> float:
    """Return the share of placebos that gain as much as a candidate, `found` (draws,) in each part of the search."""
    return (1 + int(np.count_nonzero(np.any(found, axis=0)))) / (1 + evidence.draws)


def searches(evidence: Evidence, score: Score) -> list[PlaceboSearch]:
    """Return the parts of the search that placebos of a candidate go through."""
    nodes, most = score.candidate.common, evidence.rules.placebo_nodes
    if nodes.size > most:
        nodes = np.union1d(nodes[:: int(np.ceil(nodes.size / most))], score.nodes[:1])
    parts = np.array_split(nodes, max(1, -(-nodes.size // AT_ONCE)))
    common = [PlaceboSearch(part, False) for part in parts if part.size]
    return common + [PlaceboSearch(group, True) for group in score.candidate.groups]


def as_good(evidence: Evidence, score: Score, columns: Sequence[Columns], search: PlaceboSearch) -> np.ndarray:
    """Mask (draws,) of the placebos of a candidate that gain as much as it does, in a part of the search.

    One with a forbidden sign would not have been accepted either.
    """
    candidate, rules = score.candidate, evidence.rules
    seen = score.share * float(evidence.fold_losses.sum())
    if seen <= 0.0:  # a placebo that gains nothing is as good
        return np.ones(evidence.draws, dtype=bool)
    some = [
        _telegraph(c.some(search.nodes), rules.telegraph * block.rate, r)
        for r, (c, block) in enumerate(zip(columns, evidence.blocks, strict=True))
    ]

    def exceed(grams: Gram) -> np.ndarray:
        return evidence.exceed(grams, seen, lambda values: admissible(candidate, values, rules))

    different, back = evidence.different_shifts
    if search.own:
        many = -(-len(search.nodes) * len(different[0]) // TOGETHER)
        pieces, out = np.array_split(np.arange(len(different[0])), max(1, many)), []
        for piece in pieces:
            nodes = (evidence.shifted(some, v, by=[e[piece] for e in different]) for v in range(len(search.nodes)))
            grams = Gram.stacked(nodes, len(search.nodes))
            out.append(exceed(evidence.pick(grams, own_nodes(evidence, candidate, grams))))
        return np.concatenate(out)[back]
    good = np.zeros(len(different[0]), dtype=bool)
    for v in range(len(search.nodes)):
        if not (left := np.flatnonzero(~good)).size:
            break
        good[left] = exceed(evidence.shifted(some, v, trained=True, by=[entry[left] for entry in different]))
    return good[back]


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
