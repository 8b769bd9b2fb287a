"""The search for what a model is missing: forwards, backwards, and against curves that know no physics.

Forward: the best significant candidate is added, the model refitted, everything weighed anew. Backward: a term that the
others have made superfluous goes, and one term takes the place of two where it does as well. Then accepted terms are
held against a curve with no physics (`unexplained`): those that such a curve clearly beats were only the nearest thing
the catalogue had; they are taken back, and the search goes on without them.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from diagnosis.evidence.candidates import Candidate, Columns, Library, stacked
from diagnosis.evidence.gain import Block, Evidence
from diagnosis.evidence.look_alikes import BLOCK_SECONDS, CLEAR, CLOSE, TIED, columns_at, look_alikes, refine
from diagnosis.evidence.present import Present, present
from diagnosis.evidence.remainder import Remainder, Winner, beaten, remainders, significant, suggest
from diagnosis.evidence.suspects import LEAST_SHARE, Score, placebo, rank, weigh
from optimisation.fitting.fit import Fit
from optimisation.fitting.identify import identify
from optimisation.preparation.prepare import Prepared
from symbolic.model import Model
from symbolic.motion import Float
from symbolic.quantity import JOINTS

Progress = Callable[[float, str], None]
MERGED = 0.97
"""Part of the gain of two accepted terms that a single one must have to take their place."""
MANY_NUMBERS = 4
"""A term with so many numbers is only believed if plainer ones do not do as well."""
SURE = 0.01
"""p-value that an accepted term must still reach beside the others."""
NEAR = 0.8
"""Part of the best gain from which on a candidate is refitted too: on a grid it may have been off its best place."""
OWN_PLACE = 0.5
"""Part of its gain that a candidate with places of its own must keep where every recording has zeros of its own."""
REFITTED = 5
"""Rivals at most that are told apart by a refit of everything."""
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


@dataclass(frozen=True, eq=False)
class Search:
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
        banned: set[str] = set()
        stages, left = self._until_nothing_stands_in([stage], banned)
        first = self.rank(stage, 1)[1]
        for score in [s.added for s in stages[1:] if s.added is not None]:
            if score.candidate.numbers < MANY_NUMBERS:
                continue
            # So many numbers can build what two plain effects make; see whether plain ones do as well.
            others, rest = self._until_nothing_stands_in([stage], {*banned, score.name})
            if _numbers(others) <= _numbers(stages) and _unseen_gain(stages[-1], others[-1]) > -LEAST_SHARE:
                return others, first, rest
        return stages, first, left

    def _until_nothing_stands_in(self, stages: list[Stage], banned: set[str]) -> tuple[list[Stage], Remainder | None]:
        for _ in range(ROUNDS):
            stages = self._to_and_fro(stages, banned)
            left = self.left(stages[-1])
            stand_ins = self.stand_ins(stages, left) | _impossible(stages[-1])
            if not stand_ins:
                return stages, left
            banned |= stand_ins
            stages = self._replay(stages, [n for n in _names(stages) if n not in banned])
        return stages, self.left(stages[-1])

    def _to_and_fro(self, stages: list[Stage], banned: set[str]) -> list[Stage]:
        """Go forwards, then drop what has become superfluous, and again, until nothing is dropped."""
        dropped: set[str] = set()
        while True:
            longer = self.forward(stages, banned | dropped)
            stages = self.exchange(self.merge(self.prune(longer), banned), banned)
            fewer = {*_names(longer)} - {*_names(stages)}
            if not fewer:
                return stages
            dropped |= fewer

    def forward(self, stages: list[Stage], banned: set[str]) -> list[Stage]:
        """Add the best candidate, and again, as long as one helps."""
        stages = list(stages)
        while len(stages) <= self.most:
            evidence, scores = self.rank(stages[-1], len(stages))
            found = self.next_stage(stages[-1], evidence, scores, banned)
            if found is None:
                break
            stages.append(found)
        return stages

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
            alike = look_alikes(evidence, refined[0], refined[1:])
            near = [p[0] for p in refined if p[0].name in alike or p[0].share >= NEAR * refined[0][0].share]
            chosen = self._refitted(stage, evidence, near, alike)
            if chosen is not None:
                return chosen
            banned.add(refined[0][0].name)
            good = [s for s in good if s.name not in banned]
        return None

    def _refitted(
        self, stage: Stage, evidence: Evidence, rivals: Sequence[Score], alike: Collection[str]
    ) -> Stage | None:
        """Return the stage with the best of `rivals` (best first) added, each compared after a refit of everything.

        Linearised and on a grid they were too close to call; those in `alike` stay look-alikes unless a refit tells
        them apart. None where none of them helps unseen recordings, or where what they gain is made by the noise of the
        angles.
        """
        scale = stage.now.scale
        tried = [(score, self._added(stage, score)) for score in rivals[:REFITTED]]
        tried = [(score, found) for score, found in tried if _unseen_gain(stage, found) > 0.0]
        if not tried:
            return None
        losses = {score.name: found.now.block_losses(scale, BLOCK_SECONDS) for score, found in tried}
        least = min(losses.values(), key=np.sum)
        lag = {name: _lag(loss, least) for name, loss in losses.items()}
        score, found = min(
            ((s, f) for s, f in tried if lag[s.name] < TIED),
            key=lambda p: (p[0].candidate.numbers, p[0].candidate.tangent),
        )
        if not (self._outlives_noise(stage, evidence, score) and self._outlives_zeros(stage, evidence, score)):
            return None
        others = [s for s in rivals if s is not score and lag.get(s.name, 0.0) < CLEAR and s.name in {*lag, *alike}]
        never = tuple(s.name for s in others if _same(s, score))
        return replace(found, added=score, alike=tuple(s.name for s in others), never=never)

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

    def _outlives_zeros(self, stage: Stage, evidence: Evidence, score: Score) -> bool:
        """Whether a candidate with places of its own in every recording is more than other zeros of the sensors.

        A stop that is met elsewhere in each recording can take the place of a torque that is a little higher in one
        than in another. So means are taken off: recording by recording, of residual, model and candidate alike.
        """
        if not score.candidate.per_recording or len(evidence.blocks) < 2:
            return True
        count = len(evidence.train)
        blocks = [_centred(block) for block in evidence.blocks]
        level = Evidence(
            blocks[:count], blocks[count:], seed=self.seed, draws=0, sigma=evidence.sigma, prior=evidence.prior
        )
        columns = [
            replace(c, values=c.values - _mean(c.values, block.use[list(c.joints)][None, :, :, None], 2))
            for c, block in zip(self._columns(score, stage), evidence.blocks, strict=True)
        ]
        gain = float(level.gain(level.plain(columns)).total[0]) / float(evidence.fold_losses.sum())
        return gain >= max(LEAST_SHARE, OWN_PLACE * score.share)

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
        found = self._added(stage, score)
        return found if _unseen_gain(stage, found) > 0.0 else None

    def _added(self, stage: Stage, score: Score) -> Stage:
        term = score.candidate.term
        model = stage.now.model.with_effect(term.effect, term.joint)
        count = len(self.prepared.train)
        own = score.shape[:count] if not score.candidate.tangent else _from_tangent(score, count)
        start = np.concatenate([np.broadcast_to(stage.fit.shapes, (count, len(stage.fit.shape))), own], axis=1)
        if not any(s.shape.per_recording for s in model.shapes):
            start = start[0]
        return self.fit(model, start if model.shapes else None)

    def prune(self, stages: list[Stage]) -> list[Stage]:
        """Drop terms that the later ones have made superfluous."""
        last = stages[-1]
        terms = [s.added for s in stages[1:] if s.added is not None]
        for score in terms[:-1]:
            if len(terms) < 2:
                break
            without = self._without(last, [score])
            again = self._again(without, score)
            if not (again.helps and again.p_value is not None and again.p_value <= SURE):
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

    def exchange(self, stages: list[Stage], banned: set[str]) -> list[Stage]:
        """Hold every accepted term but the last against its rivals once more, now that the others are there.

        The first terms were chosen while other effects were still missing: a rival that could imitate a little of those
        too had an advantage then. What these data cannot tell apart is counted anew as well.
        """
        for score in [s.added for s in stages[1:-1] if s.added is not None]:
            self.tick(0.87, f"holding {score.name} against its rivals once more")
            without, evidence = self._without_them(stages[-1], [score])
            taken = {*_names(stages), *banned} - {score.name}
            wanted = [score.name, *(n for n in self._rivals(score) if n not in taken)]
            weighed = [self._weighed(without, evidence, self.library.find(name)) for name in wanted]
            refined = [self._refine(evidence, without, s) for s in weighed if s.helps and not s.caution]
            refined.sort(key=lambda pair: -pair[0].share)
            if not refined:
                continue
            alike = look_alikes(evidence, refined[0], refined[1:])
            near = [p[0] for p in refined if p[0].name in alike or p[0].share >= NEAR * refined[0][0].share]
            if [s.name for s in near] == [score.name]:
                stages = [replace(s, alike=(), never=()) if s.added is score else s for s in stages]
                continue
            chosen = self._refitted(without, evidence, near, alike)
            if chosen is None or chosen.added is None:
                continue
            if chosen.added.name == score.name:
                stages = [replace(s, alike=chosen.alike, never=chosen.never) if s.added is score else s for s in stages]
                continue
            again = self._again(without, chosen.added)
            if again.helps and again.p_value is not None and again.p_value <= SURE:
                rest = self._replay(stages, [n for n in _names(stages) if n != score.name])
                stages = [*rest, replace(chosen, added=replace(chosen.added, p_value=again.p_value))]
        return stages

    def _rivals(self, score: Score) -> list[str]:
        """Return the candidates that came close to an accepted one when it stood out most."""
        best: tuple[float, list[str]] = 0.0, []
        for _, scores in self._ranked.values():
            own = next((s.share for s in scores if s.name == score.name), 0.0)
            lead = own / max(s.share for s in scores) if scores and own > 0.0 else 0.0
            if lead > best[0]:
                best = lead, [s.name for s in scores if s.share >= CLOSE * own and s.name != score.name]
        return best[1]

    def _one_would_do(self, stage: Stage, pair: Sequence[Score], banned: set[str]) -> bool:
        """Whether a single candidate gains nearly what the two of `pair` gain together."""
        without, evidence = self._without_them(stage, pair)
        columns = [self._columns(_as_fitted(score, stage), without) for score in pair]
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
        """Return the stages again with only the terms in `names`, the one that helps most at each step first.

        Their old order may not do: a term can be worth nothing before another has come.
        """
        out = [stages[0]]
        waiting = [s for s in stages[1:] if s.added is not None and s.added.name in names]
        while waiting:
            tried = [(self._added(out[-1], s.added), s) for s in waiting if s.added is not None]
            found, old = max(tried, key=lambda pair: _unseen_gain(out[-1], pair[0]))
            out.append(replace(found, added=old.added, alike=old.alike, never=old.never))
            waiting = [s for s in waiting if s is not old]
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
                columns = [self._columns(_as_fitted(scores[n], stages[-1]), without) for n in group]
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

    def on_all_of(self, prepared: Prepared, stages: Sequence[Stage]) -> list[Stage]:
        """Return the stages refitted to recordings of which the search had seen only stretches."""
        out = []
        for stage in stages:
            start = np.median(stage.fit.shapes, axis=0) if stage.now.model.shapes else None
            fitted = identify(stage.now.model, prepared.train, optimisers=(), start=start)
            out.append(replace(stage, fit=fitted, now=present(fitted, prepared)))
        return out

    def left(self, stage: Stage) -> Remainder | None:
        """Return the remainder of the last model, if it is significant, with suggested closed forms."""
        self.tick(0.88, "looking at what is left")
        found = remainders(stage.now, stage.now.evidence(seed=self.seed))
        best = next((r for r in found if significant(r)), None)
        return None if best is None else replace(best, suggestions=suggest(best))


def _as_fitted(score: Score, stage: Stage) -> Score:
    """Return the score of an accepted candidate at the shape values that the model of `stage` ended at.

    It was weighed on a grid; held against a curve that bends freely, it must stand where it fits best.
    """
    own = [k for k, entry in enumerate(stage.now.model.shapes) if entry.term == score.name]
    if not own or score.candidate.tangent:
        return score
    shapes = stage.now.shapes[:, own]
    nodes = replace(score.candidate, nodes=shapes[:, None, :])
    return replace(score, candidate=nodes, nodes=np.zeros(len(shapes), dtype=int))


def _centred(block: Block) -> Block:
    """Return a block of which every column and the residual have no mean at either joint."""
    columns = block.columns - _mean(block.columns, block.use[:, :, None], 1)
    return replace(block, columns=columns, residual=block.residual - _mean(block.residual, block.use, 1))


def _mean(x: Float, use: np.ndarray, axis: int) -> Float:
    """Return the mean of `x` over the usable samples along `axis`, kept as an axis of length one."""
    return np.sum(x * use, axis=axis, keepdims=True) / np.maximum(use.sum(axis=axis, keepdims=True), 1)


def _names(stages: Sequence[Stage]) -> list[str]:
    return [s.added.name for s in stages if s.added is not None]


def _numbers(stages: Sequence[Stage]) -> int:
    """Return how many numbers the accepted terms have together."""
    return sum(s.added.candidate.numbers for s in stages if s.added is not None)


def _impossible(stage: Stage) -> set[str]:
    """Return the terms whose coefficients, refitted beside the others, are certainly outside what physics allows."""
    known = {e.name: e for e in stage.fit.estimates}
    out = set()
    for entry in stage.now.model.parameters:
        if entry.term is None or entry.name not in known:
            continue
        one = known[entry.name]
        low, high = (entry.min is not None and one.high < entry.min), (entry.max is not None and one.low > entry.max)
        if low or high:
            out.add(entry.term)
    return out


def _span(step: int) -> tuple[float, float]:
    """Return from where to where the progress bar moves in a step; nobody knows how many there will be."""
    return 0.9 * (1.0 - 0.55 ** (step - 1)), 0.9 * (1.0 - 0.55**step)


def _lag(loss: Float, least: Float) -> float:
    """Return by how many standard errors a model's loss in blocks of time is above the least one's; 0 for itself."""
    difference = loss - least
    spread = float(np.sqrt(np.sum((difference - difference.mean()) ** 2)))
    return float(difference.sum()) / spread if spread > 1e-9 * float(least.sum()) else 0.0


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
