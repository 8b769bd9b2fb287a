"""How often chance does as well: the same entry, shifted in time, sent through the same search."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from diagnosis.evidence.candidates import Candidate
from diagnosis.evidence.columns import Columns
from diagnosis.evidence.gain import Evidence, Gain, Gram
from diagnosis.evidence.score import Score, admissible, groups_of, own_nodes
from symbolic.motion import Float


def placebo(evidence: Evidence, score: Score, columns: Sequence[Columns]) -> Score:
    """Return `score` with its p-value."""
    return replace(score, p_value=p_value(evidence, score, columns))


def p_value(evidence: Evidence, score: Score, columns: Sequence[Columns]) -> float:
    """Return the share of placebos that gain as much as a candidate through the same search."""
    candidate, rules = score.candidate, evidence.rules
    columns = [_telegraph(c, rules.telegraph * evidence.blocks[r].rate, r) for r, c in enumerate(columns)]
    nodes = candidate.common
    if nodes.size > rules.placebo_nodes:
        nodes = np.union1d(nodes[:: int(np.ceil(nodes.size / rules.placebo_nodes))], score.nodes[:1])
    null = np.full(evidence.draws, -np.inf)
    for v in nodes:
        null = np.maximum(null, _null_of(evidence, candidate, evidence.gain(evidence.shifted(columns, int(v)))))
    for group in groups_of(candidate):
        each = [evidence.shifted(columns, int(v)) for v in group]
        grams = Gram(*(np.stack(part, axis=-2) for part in zip(*((u.g, u.h, u.a) for u in each), strict=True)))
        chosen = evidence.pick(grams, own_nodes(evidence, candidate, grams))
        null = np.maximum(null, _null_of(evidence, candidate, evidence.gain(chosen)))
    seen = score.share * float(evidence.fold_losses.sum())
    beaten = int(np.count_nonzero(null >= seen))
    return (1 + beaten) / (1 + evidence.draws)


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


def _null_of(evidence: Evidence, candidate: Candidate, gain: Gain) -> Float:
    """Return the gains (draws,) of placebos; one with a forbidden sign would not have been accepted either."""
    return np.where(admissible(candidate, gain.coefficients, evidence.rules), gain.total, 0.0)[1:]
