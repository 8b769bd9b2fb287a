"""Compare, diagnose, add, and again, until nothing that helps on unseen motion is left.

Forward: the best significant candidate is added, the model refitted, everything weighed anew. Backward: a term that the
others have made superfluous goes. Then each accepted term is held against a curve with no physics (`unexplained`):
a term that such a curve clearly beats at the same joint was only the nearest thing the catalogue had; it is taken back.
"""

from __future__ import annotations

import itertools
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import cast

import numpy as np

from diagnosis.candidates import Candidate, Columns, Library, build_library, stacked
from diagnosis.evidence import Evidence
from diagnosis.look_alikes import CLOSE, TIED, columns_at, look_alikes, refine
from diagnosis.present import Present, present
from diagnosis.results import Accepted, Diagnosis, Step, Suspect
from diagnosis.suspects import LEAST_SHARE, Score, placebo, rank, weigh
from diagnosis.unexplained import Remainder, Winner, beaten, remainders, significant, suggest
from diagnosis.verdict import biased_parameters, conclude, sentence_of
from measurement.recording import Recording
from optimisation.fit import Fit
from optimisation.identify import identify
from optimisation.prepare import Prepared, prepare
from symbolic.effect import Effect
from symbolic.model import Model
from symbolic.motion import Float
from symbolic.quantity import JOINTS

Progress = Callable[[float, str], None]
MERGED = 0.97
"""Part of the gain of two accepted terms that a single one must have to take their place."""
ROUNDS = 4
"""Times the search goes on after it had to take back a stand-in."""
MOST_TERMS = 6
"""Terms added at most; a model that needs more has another problem."""


@dataclass(frozen=True, eq=False)
class Stage:
    """A fitted model on the way: where it stands on all recordings, and how the term added last was judged."""

    fit: Fit
    now: Present
    added: Score | None = None
    alike: tuple[str, ...] = ()
    never: tuple[str, ...] = ()


def discover(
    model: Model | Fit,
    recordings: Sequence[Recording],
    verify: Sequence[Recording] = (),
    *,
    seed: int = 0,
    cutoff: float | None = None,
    extra: Sequence[Effect] = (),
    progress: Progress | None = None,
    most: int = MOST_TERMS,
) -> Diagnosis:
    """Find which effects `model` (or the model of a Fit) is missing and add them, at most `most` of them.

    `verify` are recordings that are never fitted and must improve; `extra` are effects beyond the catalogue. Every
    random number comes from `seed`. Refuses recordings that are too short, too slow or do not determine the model.
    """
    began = time.perf_counter()
    model = cast("Model", model.model) if isinstance(model, Fit) else model
    tick = progress or _silent
    tick(0.02, "preparing the recordings")
    prepared = prepare(model, recordings, verify, cutoff=cutoff)
    library = build_library(model, prepared.all, (*extra, *_own_effects(model)))
    search = _Search(prepared, library, seed, tick, most)
    stages, first, left = search.run(search.fit(model))
    if len(stages) > most:  # there may be more that the catalogue explains; nothing is called unexplained yet
        left = None
    tick(0.97, "writing it down")
    return _write_up(search, stages, first, left, recordings, verify, began, most)


def diagnose(
    model: Model | Fit,
    recordings: Sequence[Recording],
    verify: Sequence[Recording] = (),
    *,
    seed: int = 0,
    cutoff: float | None = None,
    extra: Sequence[Effect] = (),
    progress: Progress | None = None,
) -> Diagnosis:
    """Find the effect that `model` misses most: `discover` that stops after one step."""
    return discover(model, recordings, verify, seed=seed, cutoff=cutoff, extra=extra, progress=progress, most=1)


def _silent(fraction: float, text: str) -> None:
    """Say nothing."""


def _own_effects(model: Model) -> tuple[Effect, ...]:
    """Return the user's own effects that the model file declares, as suspects for the other joint too."""
    return tuple({t.effect.id: t.effect for t in model.terms if t.effect.custom}.values())


@dataclass(frozen=True, eq=False)
class _Search:
    """What stays the same during one search."""

    prepared: Prepared
    library: Library
    seed: int
    tick: Progress
    most: int = MOST_TERMS
    _ranked: dict[tuple[str, ...], tuple[Evidence, list[Score]]] = field(default_factory=dict)
    """What was found against a model with these terms, for when the search comes back to it."""

    def run(self, stage: Stage) -> tuple[list[Stage], list[Score], Remainder | None]:
        """Return the stages from `stage` to the last model, the candidates as ranked at first, and what is left.

        Where an accepted term turns out to be a stand-in, it is taken back and the search goes on without it: what it
        stood in front of may now be seen.
        """
        stages, first = [stage], list[Score]()
        banned: set[str] = set()
        for _ in range(ROUNDS):
            while len(stages) <= self.most:
                evidence, scores = self.rank(stages[-1], len(stages))
                first = first or scores
                found = self.next_stage(stages[-1], evidence, scores, banned)
                if found is None:
                    break
                stages.append(found)
            stages = self.merge(self.prune(stages), banned)
            left = self.left(stages[-1])
            stand_ins = self.stand_ins(stages, left)
            if not stand_ins:
                return stages, first, left
            banned |= stand_ins
            stages = self._replay(stages, [n for n in _names(stages) if n not in banned])
        return stages, first, self.left(stages[-1])

    def fit(self, model: Model, start: Float | None = None) -> Stage:
        """Return `model` fitted to the training recordings, and where it then stands on all."""
        fitted = identify(model, self.prepared.train, optimisers=(), start=start)
        return Stage(fitted, present(fitted, self.prepared))

    def rank(self, stage: Stage, step: int) -> tuple[Evidence, list[Score]]:
        """Return the evidence against the model of `stage`, and all candidates weighed by it, best first."""
        key = tuple(term.name for term in stage.now.model.terms)
        if key not in self._ranked:
            self._ranked[key] = self._rank(stage, step)
        return self._ranked[key]

    def _rank(self, stage: Stage, step: int) -> tuple[Evidence, list[Score]]:
        low, high = _span(step)
        evidence = stage.now.evidence(seed=self.seed)
        scores = rank(
            evidence,
            self.library,
            stage.now.model,
            stage.fit.linear,
            stage.fit.shape,
            lambda f, text: self.tick(low + f * (high - low), f"step {step}: {text}"),
        )
        return evidence, scores

    def next_stage(self, stage: Stage, evidence: Evidence, scores: Sequence[Score], banned: set[str]) -> Stage | None:
        """Return the model with the best candidate that really helps after a full refit, or None."""
        good = [s for s in scores if s.significant and s.name not in banned]
        while good:
            # A rival need not beat its own placebos: that something is missing is certain, the question is what.
            rivals = [s for s in scores if s.helps and not s.caution and s.name not in banned and s is not good[0]]
            close = [good[0], *(s for s in rivals if s.share >= CLOSE * good[0].share)]
            refined = [self._refine(evidence, stage, s) for s in close]
            refined.sort(key=lambda pair: -pair[0].share)
            best = refined[0]
            alike = look_alikes(evidence, best, refined[1:])
            best = _simplest(best, refined, alike)
            if not self._outlives_noise(stage, evidence, best[0]):
                banned.add(best[0].name)
                good = [s for s in good if s.name not in banned]
                continue
            names = tuple(n for n in [p[0].name for p in refined] if n in {*alike, refined[0][0].name})
            names = tuple(n for n in names if n != best[0].name)
            found = self._add(stage, best[0])
            if found is not None:
                never = tuple(p[0].name for p in refined if p[0].name in names and _same(p[0], best[0]))
                return replace(found, added=best[0], alike=names, never=never)
            banned.add(best[0].name)
            good = [s for s in good if s.name not in banned]
        return None

    def _outlives_noise(self, stage: Stage, evidence: Evidence, score: Score) -> bool:
        """Whether a candidate still gains enough once the part that the noise of the angles makes is taken off.

        Noise makes accelerations, and so the model's torque, rougher than the motion was; whatever smooths it (a
        flexible drive, a delay) then gains. With the noise added once more that part doubles, the true part does not.
        """
        noisy = self.noisy(stage)
        columns = columns_at(
            score.candidate, score.shape, noisy.prepared.all, noisy.model, noisy.linear, stage.fit.shape
        )
        single = replace(score.candidate, nodes=score.shape[:, None, :])
        rougher = noisy.evidence(seed=self.seed, draws=0, sigma=evidence.sigma)
        with_noise = weigh(rougher, single, columns)
        loss, rough_loss = float(evidence.fold_losses.sum()), float(rougher.fold_losses.sum())
        made_by_noise = max(with_noise.share * rough_loss - score.share * loss, 0.0) / loss
        return score.share - made_by_noise >= LEAST_SHARE

    def noisy(self, stage: Stage) -> Present:
        """Return the model of `stage` on the recordings as they would be with the noise of their encoders doubled."""
        rng = np.random.default_rng(self.seed)
        train = tuple(one.noisier(rng) for one in self.prepared.train)
        verify = tuple(one.noisier(rng) for one in self.prepared.verify)
        return stage.now.on(replace(self.prepared, train=train, verify=verify))

    def _refine(self, evidence: Evidence, stage: Stage, score: Score) -> tuple[Score, list[Columns]]:
        return refine(evidence, score, self.library, stage.now.model, stage.fit.linear, stage.fit.shape)

    def _add(self, stage: Stage, score: Score) -> Stage | None:
        """Return the stage with the term of `score` added, or None where unseen recordings do not gain."""
        term = score.candidate.term
        model = stage.now.model.with_effect(term.effect, term.joint)
        count = len(self.prepared.train)
        own = score.shape[:count] if not score.candidate.tangent else _from_tangent(score, count)
        start = np.concatenate([np.broadcast_to(stage.fit.shapes, (count, len(stage.fit.shape))), own], axis=1)
        if not any(s.shape.per_recording for s in model.shapes):
            start = start[0]
        found = self.fit(model, start if model.shapes else None)
        return found if _unseen_gain(stage, found) > 0.0 else None

    def prune(self, stages: list[Stage]) -> list[Stage]:
        """Drop terms that the later ones have made superfluous."""
        last = stages[-1]
        terms = [s.added for s in stages[1:] if s.added is not None]
        for score in terms[:-1]:
            if len(terms) < 2:
                break
            without = self._without(last, [score])
            again = self._again(without, score)
            if not (again.helps and again.p_value is not None and again.p_value <= 0.01):
                terms = [t for t in terms if t.name != score.name]
                last = without
        if len(terms) == len(stages) - 1:
            return stages
        return self._replay(stages, [t.name for t in terms])

    def merge(self, stages: list[Stage], banned: set[str]) -> list[Stage]:
        """Put one term in the place of two wherever it does as well: forward steps may go round the truth.

        Each pair of accepted terms is taken out; if a single candidate then gains nearly what both gained together, the
        model with fewer terms is the one to believe.
        """
        scores = [s.added for s in stages[1:] if s.added is not None]
        for pair in itertools.combinations(scores, 2):
            self.tick(0.87, f"looking for one effect instead of {pair[0].name} and {pair[1].name}")
            if not self._one_would_do(stages[-1], pair, banned):
                continue
            names = {score.name for score in pair}
            shorter = self._replay(stages, [s.name for s in scores if s.name not in names])
            evidence, ranked = self.rank(shorter[-1], len(shorter))
            found = self.next_stage(shorter[-1], evidence, ranked, banned)
            fresh = found is not None and found.added is not None and found.added.name not in names
            if found is not None and fresh and _unseen_gain(stages[-1], found) > -2.0 * LEAST_SHARE:
                return self.merge([*shorter, found], banned)
        return stages

    def _one_would_do(self, stage: Stage, pair: Sequence[Score], banned: set[str]) -> bool:
        """Whether a single candidate gains nearly what the two of `pair` gain together."""
        without, evidence = self._without_them(stage, pair)
        columns = [self._columns(score, without) for score in pair]
        together = evidence.plain([stacked(each) for each in zip(*columns, strict=True)])
        wanted = float(evidence.gain(together).total[0]) / float(evidence.fold_losses.sum())
        taken = {term.name for term in without.now.model.terms} | banned | {score.name for score in pair}
        scores = [self._weighed(without, evidence, c) for c in self.library.candidates if c.name not in taken]
        return any(s.share >= MERGED * wanted and s.helps and not s.caution for s in scores)

    def _weighed(self, stage: Stage, evidence: Evidence, candidate: Candidate) -> Score:
        columns = self.library.columns(candidate, stage.now.model, stage.fit.linear, stage.fit.shape)
        return weigh(evidence, candidate, columns)

    def _without(self, stage: Stage, scores: Sequence[Score]) -> Stage:
        names = {score.name for score in scores}
        model = stage.now.model
        keep = [i for i, s in enumerate(model.shapes) if s.term not in names]
        for name in names:
            model = model.without(name)
        shapes = np.asarray(stage.fit.shapes)[:, keep]
        start = shapes if any(s.shape.per_recording for s in model.shapes) else shapes[0]
        return self.fit(model, start if model.shapes else None)

    def _again(self, stage: Stage, score: Score) -> Score:
        """Weigh the candidate of `score` against the model of `stage`, with placebos."""
        evidence = stage.now.evidence(seed=self.seed)
        candidate = self.library.find(score.name)
        columns = self.library.columns(candidate, stage.now.model, stage.fit.linear, stage.fit.shape)
        return placebo(evidence, weigh(evidence, candidate, columns), columns)

    def _replay(self, stages: list[Stage], names: Sequence[str]) -> list[Stage]:
        """Return the stages again with only the terms in `names`, in their order."""
        out = [stages[0]]
        for stage in stages[1:]:
            if stage.added is not None and stage.added.name in names:
                found = self._add(out[-1], stage.added)
                if found is not None:
                    out.append(replace(found, added=stage.added, alike=stage.alike, never=stage.never))
        return out

    def stand_ins(self, stages: list[Stage], left: Remainder | None) -> set[str]:
        """Return the accepted terms that a curve without physics clearly beats.

        All of a joint together first: two entries may build one curve that neither would pass for. Then one by one, at
        their own joint; and, where something is `left`, at its joint too: what nobody explains at one joint bends the
        parameters that both share, and a term at the other joint may bend them back. With them go the candidates that
        could only take their place: those that add little to the same curve.
        """
        scores = {s.added.name: s.added for s in stages[1:] if s.added is not None}
        for joint in JOINTS:
            here = [n for n, s in scores.items() if s.candidate.term.joint == joint]
            disturbed = left is not None and left.joint == joint
            single = [[n] for n, s in scores.items() if disturbed or s.candidate.term.joint in (joint, None)]
            for group in ([here] if len(here) > 1 else []) + single:
                self.tick(0.9, f"holding {' and '.join(group)} against a curve without physics")
                without, evidence = self._without_them(stages[-1], [scores[n] for n in group])
                numbers = sum(scores[n].candidate.numbers for n in group)
                columns = [self._columns(scores[n], without) for n in group]
                together = [stacked(each) for each in zip(*columns, strict=True)]
                winner = beaten(without.now, evidence, joint, together, numbers)
                if winner is not None:
                    return {*group, *self._superseded(without, evidence, winner, joint)}
        return set()

    def _without_them(self, stage: Stage, group: Sequence[Score]) -> tuple[Stage, Evidence]:
        without = self._without(stage, group)
        return without, without.now.evidence(seed=self.seed, draws=0)

    def _columns(self, score: Score, stage: Stage) -> list[Columns]:
        """Return the columns of an accepted candidate, where it was accepted, at the model of `stage`."""
        now = stage.now
        return columns_at(score.candidate, score.shape, self.prepared.all, now.model, stage.fit.linear, stage.fit.shape)

    def _superseded(self, stage: Stage, evidence: Evidence, winner: Winner, joint: str) -> set[str]:
        """Return the candidates that touch `joint` and add little to the curve that won there."""
        out = set()
        present_already = {term.name for term in stage.now.model.terms}
        for candidate in self.library.candidates:
            if candidate.name in present_already or candidate.term.joint not in (joint, None):
                continue
            columns = self.library.columns(candidate, stage.now.model, stage.fit.linear, stage.fit.shape)
            score = self._weighed(stage, evidence, candidate)
            best = [c.node(int(n)) for c, n in zip(columns, score.nodes, strict=True)]
            if score.share >= LEAST_SHARE and winner.supersedes(best):
                out.add(candidate.name)
        return out

    def left(self, stage: Stage) -> Remainder | None:
        """Return the remainder of the last model, if it is significant, with suggested closed forms."""
        self.tick(0.88, "looking at what is left")
        found = remainders(stage.now, stage.now.evidence(seed=self.seed))
        best = next((r for r in found if significant(r)), None)
        return None if best is None else replace(best, suggestions=suggest(best))


def _names(stages: Sequence[Stage]) -> list[str]:
    return [s.added.name for s in stages if s.added is not None]


def _span(step: int) -> tuple[float, float]:
    """Return from where to where the progress bar moves in a step; nobody knows how many there will be."""
    return 0.9 * (1.0 - 0.55 ** (step - 1)), 0.9 * (1.0 - 0.55**step)


def _simplest(
    best: tuple[Score, list[Columns]], refined: Sequence[tuple[Score, list[Columns]]], lag: Mapping[str, float]
) -> tuple[Score, list[Columns]]:
    """Return the candidate with the fewest numbers (linear ones first) among those as good as the best."""
    tied = [p for p in refined if lag.get(p[0].name, np.inf) < TIED]
    return min([best, *tied], key=lambda pair: (pair[0].candidate.numbers, pair[0].candidate.tangent))


def _same(one: Score, other: Score) -> bool:
    """Whether two candidates gain the same to rounding, on every held-out recording: no motion here differs."""
    return bool(np.allclose(one.folds, other.folds, rtol=1e-4, atol=1e-6))


def _from_tangent(score: Score, count: int) -> Float:
    """Return start values (R, S) for a number that was weighed as a tangent: its fitted value, inside its bounds."""
    shapes = list(score.candidate.term.effect.shape.values())
    value = float(np.clip(score.coefficients[0], shapes[0].min, shapes[0].max))
    rest = [s.typical if s.typical is not None else 0.5 * (s.min + s.max) for s in shapes[1:]]
    return np.tile([value, *rest], (count, 1))


def _unseen_gain(before: Stage, after: Stage) -> float:
    """Return the fall of the Huber loss on unseen recordings (the fitted ones without any), as a share of it."""
    scale = before.now.unseen_scale
    return 1.0 - after.now.unseen_loss(scale) / max(before.now.unseen_loss(scale), 1e-300)


def _write_up(
    search: _Search,
    stages: Sequence[Stage],
    first: Sequence[Score],
    left: Remainder | None,
    recordings: Sequence[Recording],
    verify: Sequence[Recording],
    began: float,
    most: int,
) -> Diagnosis:
    last = stages[-1]
    accepted = []
    for before, stage in pairwise(stages):
        score = stage.added
        assert score is not None
        term = score.candidate.term
        prefix = f"{term.name}."
        numbers = {e.name.removeprefix(prefix): e for e in last.fit.estimates if e.name.startswith(prefix)}
        accepted.append(
            Accepted(
                effect=term.effect.id,
                joint=term.joint,
                parameters=numbers,
                look_alikes=stage.alike,
                never_separable=stage.never,
                p_value=float(score.p_value or 1.0),
                rms_before=_shown(before),
                rms_after=_shown(stage),
                sentence=sentence_of(term, numbers),
            )
        )
    steps = tuple(
        Step(
            "base" if s.added is None else f"+ {s.added.name}",
            s.now.train_rms,
            s.now.verify_rms,
            "" if s.added is None else accepted[i - 1].sentence,
        )
        for i, s in enumerate(stages)
    )
    conclusion = conclude(accepted, left, stages[0], last, bool(verify), len(recordings), most)
    alike = {a.name: a.look_alikes for a in accepted}
    return Diagnosis(
        verdict=conclusion.verdict,
        rule=conclusion.rule,
        sentence=conclusion.sentence,
        accepted=tuple(accepted),
        suspects=tuple(_suspect(s, alike) for s in first if s.share > 0.0 or s.caution),
        steps=steps,
        noise_floor=search.prepared.noise_floor,
        unexplained=left,
        unexplained_significant=left is not None,
        audit=search.prepared.findings,
        seconds=time.perf_counter() - began,
        next_experiment=conclusion.next_experiment,
        model=last.now.model,
        fit=last.fit,
        cutoff=search.prepared.choice.reason,
        stopped_because=conclusion.stopped_because,
        biased=biased_parameters(stages[0].fit, last.fit),
    )


def _shown(stage: Stage) -> Float:
    return stage.now.train_rms if stage.now.verify_rms is None else stage.now.verify_rms


def _suspect(score: Score, alike: dict[str, tuple[str, ...]]) -> Suspect:
    term = score.candidate.term
    return Suspect(term.effect.id, term.joint, score.share, score.p_value, alike.get(term.name, ()), score.caution)
