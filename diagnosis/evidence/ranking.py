"""All candidates against one model, best first: which of them counts.

A candidate counts when its coefficients have a physical sign, it lowers the error on held-out recordings and on the
verification recordings too, enough splits of the recordings agree, and hardly any placebo does as well. Over the
catalogue the false-discovery rate is controlled (Benjamini, Hochberg 1995).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace

from diagnosis.evidence.candidates import Library
from diagnosis.evidence.columns import Columns
from diagnosis.evidence.fitted import FittedModel
from diagnosis.evidence.gain import Evidence
from diagnosis.evidence.placebo import placebo
from diagnosis.evidence.score import Score, weigh
from diagnosis.evidence.stability import Splits


def rank(
    evidence: Evidence,
    library: Library,
    fitted: FittedModel,
    tick: Callable[[float, str], None] | None = None,
) -> list[Score]:
    """Return all candidates, best first: weighed, the promising ones with placebos and significance."""
    present = {term.name for term in fitted.model.terms}
    scores, columns = [], {}
    todo = [c for c in library.candidates if c.name not in present]
    for number, candidate in enumerate(todo):
        columns[candidate.name] = library.columns(candidate, fitted)
        scores.append(weigh(evidence, candidate, columns[candidate.name]))
        if tick:
            tick(0.6 * (number + 1) / len(todo), candidate.name)
    scores.sort(key=lambda s: -s.share)
    scores = agreed(evidence, scores, columns)
    promising = [s for s in scores if s.eligible][: evidence.rules.placebo_for]
    for number, score in enumerate(promising):
        scores[scores.index(score)] = placebo(evidence, score, columns[score.name])
        if tick:
            tick(0.6 + 0.4 * (number + 1) / len(promising), score.name)
    return mark_significant(scores, evidence.rules.false_discovery_rate)


def agreed(evidence: Evidence, scores: Sequence[Score], columns: Mapping[str, Sequence[Columns]]) -> list[Score]:
    """Return `scores` with what splits of the recordings say about those that gain enough to matter."""
    splits, rules = Splits(evidence), evidence.rules
    out = []
    for score in scores:
        if score.share >= rules.least_share:
            best = [c.node(int(n)) for c, n in zip(columns[score.name], score.nodes, strict=True)]
            agreement = splits.candidate(score, best)
            steady = score.steady if agreement.share is None else agreement.enough(rules)
            score = replace(score, agreement=agreement, steady=steady)
        out.append(score)
    return out


def mark_significant(scores: Sequence[Score], rate: float) -> list[Score]:
    """Benjamini-Hochberg over the whole catalogue; candidates without a placebo run count with p = 1."""
    total = len(scores)
    values = sorted(s.p_value for s in scores if s.p_value is not None)
    passed = [p for k, p in enumerate(values, start=1) if p <= rate * k / total]
    limit = max(passed, default=0.0)
    return [replace(s, significant=s.p_value is not None and s.p_value <= limit and s.eligible) for s in scores]
