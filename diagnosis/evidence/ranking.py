"""All candidates against one model, best first: which of them counts.

A candidate counts when its coefficients have a physical sign, it lowers the error on held-out recordings and on the
verification recordings too, enough splits of the recordings agree, and hardly any placebo does as well. Over the
catalogue the false-discovery rate is controlled (Benjamini, Hochberg 1995).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from diagnosis.evidence.candidates import Library
from diagnosis.evidence.columns import Columns
from diagnosis.evidence.fitted import FittedModel
from diagnosis.evidence.gain import Evidence
from diagnosis.evidence.placebo import as_good, p_value, searches
from diagnosis.evidence.score import Score, weigh
from diagnosis.evidence.stability import Splits
from ground.engines.forks import allowed_processes, share_out, shared


def rank(
    evidence: Evidence,
    library: Library,
    fitted: FittedModel,
    tick: Callable[[float, str], None] | None = None,
) -> list[Score]:
    """Return all candidates, best first: weighed, the promising ones with placebos and significance."""
    present = {term.name for term in fitted.model.terms}
    todo = [c for c in library.candidates if c.name not in present]
    many = allowed_processes()
    rooms = [library.room(c, fitted.prepared, many) for c in todo]
    found: dict[int, Score] = {}

    def weighed(k: int) -> dict[str, Any]:
        library.fill(todo[k], fitted, rooms[k])
        return weigh(evidence, todo[k], rooms[k]).to_plain()

    def heard(k: int, answer: dict[str, Any]) -> None:
        found[k] = Score.of(todo[k], answer)
        if tick:
            tick(0.6 * len(found) / len(todo), todo[k].name)

    share_out(weighed, sorted(range(len(todo)), key=lambda k: -todo[k].nodes.shape[1] * todo[k].width), heard, many)
    columns = {c.name: library.keep(c, room) for c, room in zip(todo, rooms, strict=True)}
    scores = sorted((found[k] for k in range(len(todo))), key=lambda s: -s.share)
    scores = agreed(evidence, scores, columns)
    promising = [k for k, s in enumerate(scores) if s.eligible][: evidence.rules.placebo_for]

    parts = [(k, part) for k in promising for part in searches(evidence, scores[k])]
    good = np.frombuffer(shared(evidence.draws * len(parts), many), dtype=bool)
    good = good[: evidence.draws * len(parts)].reshape(-1, evidence.draws)

    def chance(i: int) -> None:
        k, part = parts[i]
        good[i] = as_good(evidence, scores[k], columns[scores[k].name], part)

    def settled(i: int, answer: None) -> None:
        if tick:
            tick(0.6 + 0.4 * (i + 1) / len(parts), scores[parts[i][0]].name)

    share_out(chance, range(len(parts)), settled, many)
    for k in promising:
        own = [good[i] for i, (whose, _) in enumerate(parts) if whose == k]
        scores[k] = replace(scores[k], p_value=p_value(evidence, own))
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
    """Benjamini-Hochberg over the whole catalogue; candidates without a placebo run count with p = 1.

    SciPy has it too, in a part whose import takes as long as the rest of the start.
    """
    total = len(scores)
    values = sorted(s.p_value for s in scores if s.p_value is not None)
    passed = [p for k, p in enumerate(values, start=1) if p <= rate * k / total]
    limit = max(passed, default=0.0)
    return [replace(s, significant=s.p_value is not None and s.p_value <= limit and s.eligible) for s in scores]
