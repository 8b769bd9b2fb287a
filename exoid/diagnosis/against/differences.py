"""Before against after: which number of the model, load, sensor or effect differs, with intervals and look-alikes.

The model is fitted to what was recorded before. Then `discover`'s evidence is asked, over all recordings together:
held-out parts, placebos by circular shifts, false-discovery rate, stability. A candidate may act only after (a change)
or all along (an error of the model that is no change). What leads is granted, and the rest asked again. A change that
an old error explains as well is not reported: another motion may merely show that error.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from types import MappingProxyType
from typing import Any

import numpy as np

from exoid.diagnosis.against.both_sides import CommonFit, cut_evidence, replace_blocks, with_columns
from exoid.diagnosis.against.questions import FARTHEST, NEAREST, Acting, Asked, questions
from exoid.diagnosis.against.result import ChangeFound, Course, Differences
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model, pooled_rms
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.look_alikes import look_alikes
from exoid.diagnosis.evidence.placebo import placebo
from exoid.diagnosis.evidence.ranking import agreed, mark_significant
from exoid.diagnosis.evidence.score import Score, weigh
from exoid.diagnosis.question import own_effects
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.ties import ascending
from exoid.measurement.forces import pushed_model
from exoid.measurement.reading.given import Given, question_of
from exoid.measurement.signals.methods import BUTTERWORTH
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.effect import Effect
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate

STRETCH = 2.0
"""Length in s of the stretches by which the course of a change is told."""
NONE: Mapping[str, Float] = MappingProxyType({})
MOST = 3
"""Differences named at most."""
ROUNDS, STEP, ENOUGH = 12, 0.1, 1e-4
"""Times the place of a load is looked for, by how many m at most at a time, and when it is found."""
QUICK = replace(RULES, placebo_for=6, placebo_nodes=25)
"""Thresholds as elsewhere; but half as many candidates get placebos, with fewer places in their search, for speed."""


def compare_against(
    model: Model | Fit,
    before: Given,
    after: Given,
    *,
    seed: int = 0,
    cutoff: float | None = None,
    derivative: str = BUTTERWORTH,
    extra: Sequence[Effect] = (),
) -> Differences:
    """Differences between recordings made `before` and `after` (maintenance, on two devices, of two wearers).

    `extra` are effects beyond the catalogue and the model's own. Refuses recordings that are too short or, before, do
    not determine the model.
    """
    model, before, after = question_of(model, before, after)
    machine = model.model if isinstance(model, Fit) else model
    assert isinstance(machine, Model)
    machine = machine if isinstance(model, Fit) else pushed_model(machine, (*before, *after))
    question = prepare(machine, before, after, cutoff=cutoff, derivative=derivative)
    began = time.perf_counter()
    now = fitted_model(identify(machine, question.train, optimisers=()), question)
    return BeforeAfter(now, seed, own_effects(machine, tuple(extra)), QUICK, MOST).run(began)


@dataclass(frozen=True, eq=False)
class _Granted:
    """A change taken into the model: its score, its columns (J, K, m) on every recording, and what looks like it.

    Of a load, `place` is where it is in m, and its columns are those of its mass and of its place.
    """

    score: Score
    asked: Asked
    columns: list[Float]
    alike: tuple[str, ...] = ()
    place: float | None = None


class BeforeAfter:
    """One question about before and after; `now` is the model fitted before, on all recordings.

    `already` is by how much what has been taken out of the recordings differs, {name: its numbers}.
    """

    def __init__(
        self, now: FittedModel, seed: int, extra: tuple[Effect, ...], rules: Rules, most: int,
        already: Mapping[str, Float] = NONE,
    ) -> None:  # fmt: skip
        self.now, self.seed, self.most, self.already = now, seed, most, already
        self.before = len(now.prepared.train)
        self.joints = len(now.model.joints)
        self.old: tuple[str, ...] = ()
        whole = cut_evidence(now, self.before, seed, rules)
        self.questions = questions(now, [block.columns for block in whole.blocks], self.before, extra)
        changes = sum(isinstance(c, Asked) and not c.always for c in self.questions.candidates)
        # Enough that one alone among so many can be significant.
        least = math.ceil(changes / rules.level)
        self.rules = replace(rules, placebos=max(rules.placebos, least))
        self.evidence = replace_blocks(whole, whole.blocks, seed, self.rules)

    def run(self, began: float) -> Differences:
        """Grant what leads until nothing is left that is significant."""
        granted: list[_Granted] = []
        evidence, refused = self.evidence, set[str]()
        while len(granted) < 2 * self.most and sum(not g.asked.always for g in granted) < self.most:
            found = self._next(evidence, granted, refused)
            if found is None:
                break
            if not found.asked.always and not self._exceeds_scatter(evidence, found):
                refused.add(found.asked.label)
                continue
            granted.append(found)
            evidence = with_columns(evidence, found.columns, self.seed, self.rules)
        return self._written(evidence, granted, began)

    def _next(self, evidence: Evidence, granted: Sequence[_Granted], refused: set[str]) -> _Granted | None:
        """The leader of all that is significant; of those that cannot be distinguished, one that is no change; None
        where nothing is significant.
        """
        taken = {g.asked.label for g in granted} | refused
        changes = self._changes(evidence, taken)
        good = [s for s in changes if s.significant]
        if any(not g.asked.always for g in granted):
            # Most often one thing changes: a second one has to be significant among all by itself.
            strict = self.rules.level / len(changes)
            good = [s for s in good if s.p_value is not None and s.p_value <= strict]
        if granted and not good:
            return None
        # An error that was there all along has to show nothing but that it explains as much: where something leads,
        # only what comes near it can.
        least = self.rules.half * changes[0].share if good and changes else 0.0
        scores = _by_share([*changes, *self._old(evidence, [s for s in changes if s.share >= least])])
        if not good:
            errors = [s for s in scores if s.eligible and _asked(s).always and s.share >= self.rules.worth_telling]
            self.old = tuple(_asked(s).label for s in errors[:1])
            return None
        lead = good[0]
        near = [s for s in scores if s.eligible and s is not lead and s.share >= self.rules.half * lead.share]
        pairs = [(s, self._at(s)) for s in near]
        lags = look_alikes(evidence, (lead, self._at(lead)), pairs)
        alike = [s for s in near if s.name in lags]
        old = [s for s in near if _asked(s).always and (s.name in lags or s.share > lead.share)]
        if old:
            lead = old[0]
        else:
            tied = [
                s for s in alike if lags[s.name] < self.rules.tied and s.share >= self.rules.practically * lead.share
            ]
            simpler = [s for s in tied if s.candidate.numbers < lead.candidate.numbers]
            if simpler:
                alike = [s for s in [lead, *alike] if s is not simpler[0]]
                lead = simpler[0]
        asked = _asked(lead)
        columns = [c.full(0, self.joints) for c in self._at(lead)]
        names = tuple(s.name for s in alike if not _asked(s).always and s is not lead)
        leader = _Granted(lead, asked, columns, names)
        return leader if asked.link is None else self._placed(evidence, leader)

    def _placed(self, evidence: Evidence, one: _Granted) -> _Granted:
        """Return a load at the place that fits best, with the slope by its place beside it."""
        place = float(one.score.shape[-1, 0])
        for _ in range(ROUNDS):
            found = replace(one, place=place)
            absent = (np.zeros((*base.shape[:2], 2)) for base in self.questions.base[: self.before])
            found = replace(found, columns=[*absent, *self._in_every_recording(found)[self.before :]])
            mass, moment = CommonFit(evidence, [found.columns]).solve()[-2:]
            nearer = place + (moment / mass if mass else 0.0)
            nearer = float(np.clip(nearer, max(NEAREST, place - STEP), min(FARTHEST, place + STEP)))
            if abs(nearer - place) < ENOUGH:
                break
            place = nearer
        return found

    def _changes(self, evidence: Evidence, taken: set[str]) -> list[Score]:
        """Return all changes that are asked about, best first, those that promise something with placebos."""
        asked = [c for c in self._asked(taken) if not c.always]
        changes = _by_share(self._weighed(evidence, asked))
        for score in [s for s in changes if s.eligible][: self.rules.placebo_for]:
            columns = self.questions.columns(score.candidate, self.now)
            changes[changes.index(score)] = placebo(evidence, score, columns)
        return mark_significant(changes, self.rules.level)

    def _old(self, evidence: Evidence, changes: Sequence[Score]) -> list[Score]:
        """Scores of the same `changes` as errors that were there all along."""
        labels = {_asked(s).label for s in changes}
        return self._weighed(evidence, [c for c in self._asked(set()) if c.always and c.label in labels])

    def _asked(self, taken: set[str]) -> list[Asked]:
        return [c for c in self.questions.candidates if isinstance(c, Asked) and c.label not in taken]

    def _weighed(self, evidence: Evidence, asked: Sequence[Asked]) -> list[Score]:
        columns = {c.name: self.questions.columns(c, self.now) for c in asked}
        scores = [weigh(evidence, c, columns[c.name]) for c in asked]
        # Of a side with a single recording, no split both fits and judges a part.
        lone = min(self.before, len(evidence.blocks) - self.before) < 2
        return scores if lone else agreed(evidence, scores, columns)

    def _at(self, score: Score) -> list[Columns]:
        """Return the columns of a score at its node."""
        whole = self.questions.columns(score.candidate, self.now)
        return [c.node(int(n)) for c, n in zip(whole, score.nodes, strict=True)]

    def _in_every_recording(self, one: _Granted) -> list[Float]:
        """Return the columns (J, K, m) of what was granted, as if it acted in every recording."""
        if one.place is not None:
            return [one.asked.placed(self.now.model, base, one.place) for base in self.questions.base]
        found = (self.questions.at(one.asked, row[None], k, self.now) for k, row in enumerate(one.score.shape))
        return [c.full(0, self.joints) for c in found]

    def _exceeds_scatter(self, evidence: Evidence, found: _Granted) -> bool:
        """True if the change is larger than what recordings made before differ by among themselves."""
        if self.before < 3:
            return True
        whole = self._in_every_recording(found)
        system = CommonFit(evidence, [found.columns])
        step = system.solve()
        size = step[-found.columns[0].shape[2] :]
        own = []
        for k in range(self.before):
            weight, column = system.weights[k], whole[k] @ size
            power = float(np.sum(weight * column**2))
            if power > 0.0:
                own.append((float(np.sum(weight * column * system.left(k, step))) / power, power))
        after = sum(
            float(np.sum(w * (x @ size) ** 2)) for w, x in zip(system.weights[self.before :], whole[self.before :],
            strict=True)
        )  # fmt: skip
        if len(own) < 3:
            return True
        values, power = np.array(own).T
        usable = power > 0.1 * np.median(power)
        # Relative to the change, which is 1 in these units; a recording that shows little of it scatters more.
        spread = float(np.sqrt(np.average(values[usable] ** 2, weights=power[usable])))
        share = float(np.median(power[usable])) / max(after, 1e-300)
        return self.rules.clear * spread * np.sqrt(min(1.0, share) + 1.0 / usable.sum()) < 1.0

    def _written(self, evidence: Evidence, granted: Sequence[_Granted], began: float) -> Differences:
        changes = [g for g in granted if not g.asked.always]
        prepared = self.now.prepared
        base = evidence.blocks  # with all that was granted
        system = CommonFit(replace_blocks(self.evidence, base, self.seed, self.rules), [])
        step = system.solve()
        left = [system.left(k, step) for k in range(len(base))]
        old = self.now.residuals
        train, verify = prepared.train, prepared.verify
        return Differences(
            found=tuple(self._difference(g, granted) for g in changes),
            old=tuple(dict.fromkeys([*(g.asked.label for g in granted if g.asked.always), *self.old])),
            before=tuple(p.name for p in train),
            after=tuple(p.name for p in verify),
            joints=self.now.model.joint_names,
            rms_before=tuple(map(float, pooled_rms(old[: self.before], train))),
            rms_after=tuple(map(float, pooled_rms(old[self.before :], verify))),
            rms_named=tuple(map(float, pooled_rms(left[self.before :], verify))),
            units=tuple(joint.unit("tau") for joint in self.now.model.joints),
            seconds=time.perf_counter() - began,
            audit=prepared.findings,
        )

    def _difference(self, one: _Granted, granted: Sequence[_Granted]) -> ChangeFound:
        """Return one change with its numbers before and after, all that was granted fitted beside it."""
        others = [g.columns for g in granted if g is not one]
        own = one.asked.number
        # What a load would add all along is in the model's own numbers.
        loads = one.place is not None
        whole = [] if own is not None or loads else [self._in_every_recording(one)]
        system = CommonFit(self.evidence, [*others, *whole, one.columns])
        step = system.solve()
        spread, critical = system.spread(step)
        width = one.columns[0].shape[2]
        count = len(step)
        change = np.eye(count)[count - width :]
        size = amount = change @ step
        model, fit = self.now.model, self.now.fit
        if own is not None:
            before, start = np.eye(count)[[own]], np.array([np.concatenate([fit.linear, fit.shape])[own]])
            units = [[*(p.unit for p in model.parameters), *(s.shape.unit for s in model.shapes)][own]]
            names = [one.asked.label]
        elif loads:
            change = change[:1]
            before, start = np.zeros((1, count)), np.zeros(1)
            names, units = ["mass"], ["kg"]
        else:
            before, start = np.eye(count)[count - 2 * width : count - width], np.zeros(width)
            names, units = _numbers(one.asked)

        if one.asked.change:  # a whole change at its value: the coefficient is a share of that
            before, change = (rows * one.score.shape[-1, 0] for rows in (before, change))
            size = change @ step

        def said(rows: Float, offset: Float) -> tuple[Estimate, ...]:
            middle = rows @ step + offset
            half = critical * np.sqrt(np.maximum(np.einsum("kp,pq,kq->k", rows, spread, rows), 0.0))
            return tuple(
                Estimate(n, float(v), u, float(v - h), float(v + h))
                for n, v, u, h in zip(names, middle, units, half, strict=True)
            )

        return ChangeFound(
            name=one.asked.label,
            kind=one.asked.kind,
            before=said(before, start + self._already(one, len(start))),
            after=said(before + change, start + self._already(one, len(start))),
            change=said(change, np.zeros(len(change))),
            place=self._place(one, step, spread, critical),
            acting=Acting(one.asked, one.score.shape[-1][None], one.place, amount),
            shape=_shape(one),
            look_alikes=one.alike,
            share=one.score.share,
            p_value=float(one.score.p_value if one.score.p_value is not None else 1.0),
            course=self._course(one, granted, size),
        )

    def _already(self, one: _Granted, count: int) -> Float:
        known = self.already.get(one.asked.label)
        return np.zeros(count) if known is None or known.size != count else known

    def _place(self, one: _Granted, step: Float, spread: Float, critical: float) -> Estimate | None:
        """Place of a load along its link, from the last two of `step`: its mass and that times what its place is off
        by; None where it has none.
        """
        if one.place is None or not step[-2]:
            return None
        slope = np.array([-step[-1] / step[-2] ** 2, 1.0 / step[-2]])
        middle = one.place + float(step[-1] / step[-2])
        half = critical * float(np.sqrt(slope @ spread[-2:, -2:] @ slope))
        low, high = (float(np.clip(x, NEAREST, FARTHEST)) for x in (middle - half, middle + half))
        return Estimate("along", float(np.clip(middle, NEAREST, FARTHEST)), "m", low, high)

    def _course(self, one: _Granted, granted: Sequence[_Granted], size: Float) -> Course:
        """Course of the change: the size it has, stretch by stretch, beside all else that was granted."""
        system = CommonFit(self.evidence, [*(g.columns for g in granted if g is not one), one.columns])
        step = system.solve()
        own = self._in_every_recording(one)
        rows = []
        for k, (masked, recording) in enumerate(zip(one.columns, self.now.prepared.all, strict=True)):
            weight, column = system.weights[k], own[k] @ size
            rest = system.left(k, step) + masked @ step[-size.size :]
            count = max(1, round(STRETCH * recording.kept_rate))
            starts = np.arange(0, rest.shape[1], count)
            power = np.add.reduceat(np.sum(weight * column**2, axis=0), starts)
            slope = np.add.reduceat(np.sum(weight * column * rest, axis=0), starts)
            middle = recording.t[np.minimum(starts + count // 2, recording.t.size - 1)]
            rows.append(np.array([middle, slope / np.maximum(power, 1e-300), power]))
        return Course(*np.concatenate(rows, axis=1))


def _by_share(scores: Sequence[Score]) -> list[Score]:
    return ascending(scores, lambda score: -score.share, 1.0)


def _asked(score: Score) -> Asked:
    assert isinstance(score.candidate, Asked)
    return score.candidate


def _numbers(asked: Asked) -> tuple[list[str], list[str]]:
    effect, term = asked.term.effect, asked.term
    entries: dict[str, Any] = dict(effect.coefficients) or {k: v for k, v in [*effect.shape.items()][:1]}
    return list(entries), [term.unit(entry.unit) for entry in entries.values()]


def _shape(one: _Granted) -> dict[str, float]:
    if one.place is not None:
        return {}
    if not one.asked.term.effect.coefficients:
        return {}
    return {key: float(v) for key, v in zip(one.asked.term.effect.shape, one.score.shape[-1], strict=True)}
