"""All candidates against one model, best first: which of them counts.

A candidate counts when its coefficients have a physical sign, it lowers the error on held-out recordings and on the
verification recordings too, enough splits of the recordings agree, and hardly any placebo does as well: the same entry,
shifted in time, sent through the same search. Over the catalogue the false-discovery rate is controlled (Benjamini,
Hochberg 1995).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.gram import Gram
from exoid.diagnosis.evidence.library import Library
from exoid.diagnosis.evidence.look_alikes import clearly_helps, refine
from exoid.diagnosis.evidence.score import Score, admissible, harmless, own_nodes, weigh
from exoid.diagnosis.evidence.stability import Splits
from exoid.ground.progress import Progress, silent
from exoid.ground.ties import ascending

AT_ONCE = 12
"""Nodes that are tried in one piece of work."""
TOGETHER = 40_000
"""Nodes times placebos whose sums are held at once: of an arm, 5 kB each."""


def rank(evidence: Evidence, library: Library, fitted: FittedModel, tick: Progress = silent) -> list[Score]:
    """Return all candidates, best first: weighed, the promising ones with placebos and significance."""
    todo = [c for c in library.candidates if c.name not in fitted.model.effects]
    scores, columns = weigh_all(evidence, library, fitted, todo, lambda done, text: tick(0.6 * done, text))
    scores = agreed(evidence, ascending(scores, lambda s: -s.share, 1.0), columns, fitted)
    eligible = [s for s in scores if s.eligible]
    promising = [s for s in eligible if not s.candidate.reads_torque][: evidence.rules.placebo_for]
    promising += [s for s in eligible if s.candidate.reads_torque]
    tested = with_chance(evidence, promising, columns, lambda done, text: tick(0.6 + 0.4 * done, text))
    known = {s.name: s for s in tested}
    return mark_significant([known.get(s.name, s) for s in scores], evidence.rules.level)


def weigh_all(
    evidence: Evidence, library: Library, fitted: FittedModel, todo: Sequence[Candidate], tick: Progress = silent
) -> tuple[list[Score], dict[str, tuple[Columns, ...]]]:
    """The candidates `todo` weighed, without placebos, and their columns."""
    scores, columns = [], {}
    for k, candidate in enumerate(todo, start=1):
        columns[candidate.name] = library.columns(candidate, fitted)
        scores.append(weigh(evidence, candidate, columns[candidate.name]))
        tick(k / len(todo), candidate.name)
    return scores, columns


def with_chance(
    evidence: Evidence, scores: Sequence[Score], columns: Mapping[str, Sequence[Columns]], tick: Progress = silent
) -> list[Score]:
    """`scores` with their p-values."""
    out = []
    for k, score in enumerate(scores, start=1):
        out.append(placebo(evidence, score, columns[score.name]))
        tick(k / len(scores), score.name)
    return out


def agreed(
    evidence: Evidence,
    scores: Sequence[Score],
    columns: Mapping[str, Sequence[Columns]],
    fitted: FittedModel | None = None,
) -> list[Score]:
    """Return `scores` with what splits of the recordings say about those that gain enough to matter.

    What has a place is asked at its best one beside the model `fitted` where it hardly convinces at a node: a stop that
    begins beside its node leaves most where one recording goes furthest into it. Of a single recording its gain has to
    be clear beside how it scatters over the recording.
    """
    splits, rules = Splits(evidence), evidence.rules
    out = []
    for score in scores:
        if score.share >= rules.least_share:
            best = [c.node(int(n)) for c, n in zip(columns[score.name], score.nodes, strict=True)]
            agreement = splits.candidate(score, best)
            shapes = score.candidate.term.placed_shape.values()
            placed = any(shape.per_recording and shape.spacing == "position" for shape in shapes)
            if fitted is not None and placed and not agreement.enough(rules):
                agreement = splits.candidate(*refine(evidence, score, fitted))
            steady = score.steady if agreement.share is None else agreement.enough(rules)
            if len(evidence.blocks) == 1 and fitted is not None:  # no splits: the scatter over its blocks has to tell
                steady = steady and clearly_helps(evidence, best, fitted.prepared.choice.cutoff)
            helps = score.helps or (agreement.repeats(rules) and _outvoted(evidence, score))
            score = replace(score, agreement=agreement, steady=steady, helps=helps)
        out.append(score)
    return out


def _outvoted(evidence: Evidence, score: Score) -> bool:
    """True if the recordings held out lose little beside what the fitted ones gain, in units of torque."""
    gained = score.share * float(evidence.fold_losses.sum())
    return harmless(evidence.rules, np.array([gained, (score.unseen or 0.0) * evidence.unseen_loss]))


def mark_significant(scores: Sequence[Score], rate: float) -> list[Score]:
    """Benjamini-Hochberg over the effects of the whole catalogue; candidates without a placebo run count with p = 1.

    SciPy has it too, in a part whose import takes as long as the rest of the start.
    """
    total = sum(not score.candidate.reads_torque for score in scores)
    values = sorted(s.p_value for s in scores if s.p_value is not None)
    passed = [p for k, p in enumerate(values, start=1) if p <= rate * k / total]
    limit = max(passed, default=0.0)
    return [replace(s, significant=s.p_value is not None and s.p_value <= limit and s.eligible) for s in scores]


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
