"""Before against after: which number of the model, load, sensor or effect differs, with intervals and look-alikes.

The model is fitted to what was recorded before. What differs is then a claim about a group of recordings, those made
after, and is asked as `discover` asks what belongs to recordings: learnt on one half of each, judged on the other. What
leads is granted, and the rest asked again. A change that an error of the model explains as well, if it was there all
along, is not reported: another motion may merely show that error.
"""

from __future__ import annotations

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from exoid.diagnosis.against.questions import Acting, Asked, questions
from exoid.diagnosis.against.result import ChangeFound, Course, Differences
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model, pooled_rms
from exoid.diagnosis.evidence.gain import Evidence, pooled_scale, robust_weight
from exoid.diagnosis.evidence.ranking import agreed, placebo
from exoid.diagnosis.evidence.score import weigh
from exoid.diagnosis.hypotheses.recordings import Claim, nothing
from exoid.diagnosis.own_numbers.compared import clearer, total
from exoid.diagnosis.own_numbers.fits import Fits
from exoid.diagnosis.own_numbers.found import TRIED, at_best_node, placed, placed_anew
from exoid.diagnosis.own_numbers.numbers import spread_of
from exoid.diagnosis.own_numbers.state import Claimed, State
from exoid.diagnosis.question import own_effects
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.errors import RecordingError
from exoid.ground.ties import ascending, least_of
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
MOST = 3
"""Differences named at most."""


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

    `extra` are effects beyond the catalogue and the model's own. Refuses recordings that are too short, that are in
    other units or another convention than the others, or that, before, do not determine the model.
    """
    model, before, after = question_of(model, before, after)
    machine = model.model if isinstance(model, Fit) else model
    assert isinstance(machine, Model)
    machine = machine if isinstance(model, Fit) else pushed_model(machine, (*before, *after))
    question = prepare(machine, before, after, cutoff=cutoff, derivative=derivative)
    if question.misread:
        finding = question.misread[0]
        raise RecordingError(finding.what, where=finding.where, remedy=finding.remedy)
    began = time.perf_counter()
    now = fitted_model(identify(machine, question.train, optimisers=()), question)
    found = BeforeAfter(now, seed, own_effects(machine, tuple(extra)), RULES, MOST, {}).run()
    return replace(found, seconds=time.perf_counter() - began)


@dataclass(frozen=True, eq=False)
class _Change:
    """Change that was `asked` about, as it is `held` at its `node` (S,): after, or `always`; `beside` what was granted
    before, which is placed anew with it. A load taken off is one that is held before.

    `share` is the part of the loss that it explains, `alike` what these data cannot distinguish from it.
    """

    asked: Asked
    held: State
    node: Float
    always: bool = False
    beside: State = ()
    share: float = 0.0
    p_value: float = 1.0
    alike: tuple[str, ...] = ()

    @property
    def whole(self) -> State:
        """All that is held with it."""
        return (*self.beside, *self.held)

    def among(self, whole: State) -> _Change:
        """The same change among claims that were placed anew."""
        many = len(whole) - len(self.held)
        node = self.node if self.asked.claim is None else np.array(whole[-1].node)
        return replace(self, beside=whole[:many], held=whole[many:], node=node)


class BeforeAfter:
    """One question about before and after; `now` is the model fitted before, on all recordings.

    `already` is by how much what has been taken out of the recordings differs, {name: its numbers}.
    """

    def __init__(
        self, now: FittedModel, seed: int, extra: tuple[Effect, ...], rules: Rules, most: int,
        already: Mapping[str, Float],
    ) -> None:  # fmt: skip
        self.now, self.seed, self.rules, self.most, self.already = now, seed, rules, most, already
        self.fits = Fits(now, rules, {})
        self.all = tuple(range(len(now.prepared.all)))
        self.before, self.after = self.all[: len(now.prepared.train)], self.all[len(now.prepared.train) :]
        self.questions = questions(now, extra, self.fits.claims)
        for item in self.questions:
            if item.claim is not None and item.column is not None:
                self.fits.place[item.claim] = slice(item.column, item.column + 1)
        self.old: tuple[str, ...] = ()
        self.helpful = set[str]()
        self.columns: dict[tuple[str, int], Columns] = {}

    def run(self) -> Differences:
        """Grant what leads until nothing is left that is significant."""
        granted: list[_Change] = []
        refused = set[str]()
        while len(granted) < 2 * self.most and sum(not g.always for g in granted) < self.most:
            if (found := self._next(granted, refused)) is None:
                break
            if found.always or self._exceeds_scatter(granted, found):
                granted.append(found)
                for k, change in enumerate(granted):
                    rest = _state([g for g in granted if g is not change])
                    granted[k] = change.among(placed(self.fits, (*rest, *change.held)))
            else:
                refused.add(found.asked.name)
        return self._written(granted)

    def _next(self, granted: Sequence[_Change], refused: set[str]) -> _Change | None:
        """Leader of all that pays, or what is no change and cannot be distinguished; None where nothing pays."""
        fits, state = self.fits, _state(granted)
        taken = {g.asked.name for g in granted} | refused
        changes = self._promising(state, [item for item in self.questions if item.name not in taken], self.after)
        lead = self._leading(changes) if changes else None
        chance = None if lead is None else self._pays(granted, lead)
        if lead is None or chance is None:
            if not granted:
                some = [item for item in self.questions if item.candidate is None or item.name in self.helpful]
                errors = self._promising(state, some, self.all)
                told = [e.asked.name for e in errors if self._share(state, e) >= self.rules.worth_telling]
                self.old = tuple(told[:1])
            return None
        least_share = self.rules.half * self._share(state, lead)
        near = [c for c in changes if c.asked is not lead.asked and self._share(state, c) >= least_share]
        errors = self._promising(state, [c.asked for c in (lead, *near) if c.asked.column is None], self.all)
        fits.weigh(lead.whole)
        once, least = fits.losses(state), fits.losses(lead.whole)
        alike: dict[_Change, float] = {}
        for rival in (*near, *errors):
            loss = fits.losses(rival.whole)
            gain = total(once) - total(loss)
            beside = total(least) - total(fits.losses((*lead.whole, *rival.held)))
            lag = clearer(loss, least)
            if lag < self.rules.clear and (beside <= self.rules.half * gain or rival.asked is lead.asked):
                alike[rival] = lag
        if old := [rival for rival in errors if rival in alike]:
            return old[0]
        tied = [r for r, lag in alike.items() if lag < self.rules.tied and _many(r) < _many(lead)]
        rest = [c for c in (lead, *alike) if c not in tied[:1]]
        lead = tied[0] if tied else lead
        names = tuple(c.asked.name for c in rest if c.asked.name != lead.asked.name)
        return replace(lead, alike=names, share=self._share(state, lead), p_value=chance)

    def _leading(self, changes: Sequence[_Change]) -> _Change:
        """The change that explains most where the fit is weighted for it."""
        some = ascending(changes, lambda one: self.fits.loss(one.whole), 1.0)[:TRIED]
        for _ in range(2):  # the second time in units of what the first leaves
            lead = least_of(some, lambda one: self.fits.weighed_loss(one.whole), 1.0)
            self.fits.weigh(lead.whole)
            self.fits.rescale(lead.whole)
        return lead.among(placed(self.fits, lead.whole))

    def _pays(self, granted: Sequence[_Change], lead: _Change) -> float | None:
        """Chance, among all that is asked, of explaining as much as a change that pays; None of one that does not.
        Most often one thing changes: a second one has to be clearer, in its blocks.
        """
        fits, state, rules = self.fits, _state(granted), self.rules
        first = all(g.always for g in granted)
        once, then = fits.losses(state), fits.losses(lead.whole)
        enough = total(once) - total(then) >= rules.worth_telling * total(once[len(self.before) :])
        if not enough or not np.isfinite(fits.loss(lead.whole)):
            return None
        level = rules.level if first else rules.strict_level
        chance = 0.5 * math.erfc(clearer(once, then) / math.sqrt(2.0)) * len(self.questions)
        if chance > level and first and lead.asked.candidate is not None:
            chance = self._beyond_placebos(state, lead.asked)
        return chance if chance <= level else None

    def _beyond_placebos(self, state: State, asked: Asked) -> float:
        """The same by placebos: what shows at few reversals is in too few blocks to be clear by how these scatter."""
        assert asked.candidate is not None
        many, columns = len(self.questions), self._columns(asked, self.after)
        evidence = self._evidence(state, max(self.rules.placebos, math.ceil(many / self.rules.level)))
        score = weigh(evidence, asked.candidate, columns)
        if min(len(self.before), len(self.after)) > 1:  # else no split both fits and judges a part
            score = agreed(evidence, [score], {asked.name: columns})[0]
        return many * (placebo(evidence, score, columns).p_value or 1.0) if score.eligible else 1.0

    def _share(self, state: State, one: _Change) -> float:
        """Part of the loss that a change explains."""
        once, then = self.fits.losses(state), self.fits.losses(one.whole)
        return 1.0 - total(then) / max(total(once), 1e-300)

    def _promising(self, state: State, asked: Sequence[Asked], where: tuple[int, ...]) -> list[_Change]:
        """Changes that explain at least a little where they act in the recordings `where`, best first."""
        fits, always = self.fits, where == self.all
        fits.weigh(state)
        evidence = self._evidence(state)
        effects = [(item, item.candidate) for item in asked if item.candidate is not None]
        scores = [(item, weigh(evidence, candidate, self._columns(item, where))) for item, candidate in effects]
        self.helpful = {item.name for item, score in scores if score.share >= self.rules.least_share}
        best = ascending([(i, s) for i, s in scores if s.eligible], lambda pair: -pair[1].share, 1.0)[:TRIED]
        found = [self._taken(item, item.nodes[int(score.nodes[0])], where) for item, score in best]
        fits.weigh(state)
        for item in asked:
            if (claim := item.claim) is not None and not (always and item.column is not None):
                groups = (where, self.before) if claim.shared and not always else (where,)
                held = [at_best_node(fits, state, Claimed(claim, claim.nodes[0], (group,))) for group in groups]
                least = least_of(held, lambda one: fits.loss((*state, one)), 1.0)
                found.append(_Change(item, (least,), np.array(least.node), always))
        most = (1.0 - self.rules.least_share) * fits.loss(state)
        beside = [change.among(placed_anew(fits, (*state, *change.held))) for change in found]
        losses = [(fits.loss(change.whole), change) for change in beside]
        return [change for _, change in ascending([p for p in losses if p[0] <= most], lambda pair: pair[0], 1.0)]

    def _evidence(self, state: State, draws: int = 0) -> Evidence:
        """Evidence of what is left beside a state, each recording in two halves, to weigh effects by."""
        fits = self.fits
        each = zip(fits.blocks, fits.rows, fits.chosen(state), fits.left(state), strict=True)
        blocks = [
            replace(block, columns=rows @ chosen[:, :-1], residual=r, fold=np.arange(r.shape[1]) * 2 // r.shape[1])
            for block, rows, chosen, r in each
        ]
        prior = np.pad(fits.prior, (0, blocks[0].columns.shape[2] - fits.count))
        return Evidence(blocks, [], seed=self.seed, draws=draws, prior=prior, rules=self.rules)

    def _columns(self, item: Asked, where: tuple[int, ...]) -> list[Columns]:
        """Columns of an effect at its nodes on all recordings, of which it acts in `where`."""
        for k in where:
            if (item.name, k) not in self.columns:
                self.columns[item.name, k] = self._columns_on(k, item, item.nodes)
        some = self.columns[item.name, where[0]]
        nodes, joints, _, width = some.values.shape
        shapes = [(nodes, joints, block.residual.shape[1], width) for block in self.fits.blocks]
        return [self.columns[item.name, k] if k in where else Columns.absent(some.joints, shapes[k]) for k in self.all]

    def _columns_on(self, k: int, item: Asked, nodes: Float) -> Columns:
        return item.columns(nodes, self.now.prepared.all[k], self.fits.blocks[k].columns, self.now)

    def _taken(self, item: Asked, node: Float, where: tuple[int, ...]) -> _Change:
        """An effect at a node, its columns among the claims."""
        own = [self._columns_on(k, item, node[None]).full(0, len(self.now.model.joints)) for k in self.all]
        claims = [Claim("effect", item.name, unit, nothing, (low, high)) for unit, low, high in item.numbers.values()]
        self.fits.take(claims, own)
        return _Change(item, tuple(Claimed(claim, (), (where,)) for claim in claims), node, where == self.all)

    def _course(self, granted: Sequence[_Change], one: _Change) -> list[Float]:
        """Course of a change beside all else that was granted, (3, stretches) of each recording: when, the size it has,
        and how much a stretch can tell.
        """
        fits, state = self.fits, (*_state([g for g in granted if g is not one]), *one.held)
        fits.weigh(state)
        step = fits.together(state)
        left, size = fits.left_by(state, [step, step]), step[-len(one.held) :]
        sigma = pooled_scale(list(zip(left, fits.use, strict=True)))
        out = []
        for k, (rows, recording) in enumerate(zip(fits.rows, self.now.prepared.all, strict=True)):
            weight = robust_weight(replace(fits.blocks[k], residual=left[k]), sigma, self.rules) / sigma[:, None] ** 2
            column = _turned(one, self.after) * sum(
                (rows[:, :, fits.place[h.claim]] @ h.claim.mix(h.node)) * x for h, x in zip(one.held, size, strict=True)
            )
            rest = left[k] + column * (k in self.after)
            starts = np.arange(0, rest.shape[1], max(1, round(STRETCH * recording.kept_rate)))
            power = np.add.reduceat(np.sum(weight * column**2, axis=0), starts)
            slope = np.add.reduceat(np.sum(weight * column * rest, axis=0), starts)
            middle = recording.t[np.minimum(starts + starts[1:2].sum() // 2, recording.t.size - 1)]
            out.append(np.array([middle, slope / np.maximum(power, 1e-300), power]))
        return out

    def _exceeds_scatter(self, granted: Sequence[_Change], found: _Change) -> bool:
        """True if the change is larger than what recordings made before differ by among themselves."""
        if len(self.before) < 3:
            return True
        course = self._course(granted, found)
        power = np.array([part[2].sum() for part in course])
        wants = np.array([part[1] @ part[2] for part in course]) / np.maximum(power, 1e-300)
        own, after = power[: len(self.before)], float(power[len(self.before) :].sum())
        usable = own > 0.1 * np.median(own[own > 0.0]) if own.any() else own > 0.0
        if usable.sum() < 3:
            return True
        # Relative to the change, which is 1 in these units; a recording that shows little of it scatters more.
        spread = float(np.sqrt(np.average(wants[: len(own)][usable] ** 2, weights=own[usable])))
        share = float(np.median(own[usable])) / max(after, 1e-300)
        return self.rules.clear * spread * np.sqrt(min(1.0, share) + 1.0 / usable.sum()) < 1.0

    def _written(self, granted: Sequence[_Change]) -> Differences:
        prepared, state, many = self.now.prepared, _state(granted), len(self.before)
        self.fits.weigh(state)
        old, left = self.now.residuals, self.fits.left(state)
        return Differences(
            found=tuple(self._difference(g, granted) for g in granted if not g.always),
            old=tuple(dict.fromkeys([*(g.asked.name for g in granted if g.always), *self.old])),
            before=tuple(p.name for p in prepared.train),
            after=tuple(p.name for p in prepared.verify),
            joints=self.now.model.joint_names,
            rms_before=tuple(map(float, pooled_rms(old[:many], prepared.train))),
            rms_after=tuple(map(float, pooled_rms(old[many:], prepared.verify))),
            rms_named=tuple(map(float, pooled_rms(left[many:], prepared.verify))),
            units=tuple(joint.unit("tau") for joint in self.now.model.joints),
            audit=prepared.findings,
        )

    def _difference(self, one: _Change, granted: Sequence[_Change]) -> ChangeFound:
        """One change with its numbers before and after, all that was granted fitted beside it."""
        fits, asked, own = self.fits, one.asked, one.held
        # What a load, a gain or a level of friction would be all along is in the model's own numbers.
        apart = asked.candidate is not None or asked.kind == "sensor"
        if apart:
            own = tuple(replace(h, groups=(self.before, self.after)) for h in own)
        state = (*_state([g for g in granted if g is not one]), *own)
        fits.weigh(state)
        step = fits.together(state)
        spread = spread_of(fits, state, step)
        step = np.append(step, np.zeros(len(spread.matrix) - len(step)))
        unit = np.eye(len(step))
        first, start = fits.count + sum(len(h.groups) for h in state[: -len(own)]), np.zeros(len(own))
        turned, claim = _turned(one, self.after), own[0].claim
        if apart:
            before = unit[first : first + 2 * len(own) : 2]
            change = unit[first + 1 : first + 2 * len(own) : 2] - before
        else:
            before, change = np.zeros((len(own), len(step))), turned * unit[first : first + len(own)]
            if asked.column is not None:
                before = unit[[asked.column]]
                start += np.concatenate([self.now.linear, self.now.shape])[asked.column]
            start += claim.usual if asked.kind == "number" else 0.0  # of an effect, its number says what it adds
        amount = change @ step
        if asked.candidate is not None and asked.candidate.change:  # a whole change at its value: a share of that
            before, change = (rows * one.node[0] for rows in (before, change))
        known = self.already.get(asked.name)
        start = start + known if known is not None and known.size == start.size else start

        def said(rows: Float, offset: Float) -> tuple[Estimate, ...]:
            middle = rows @ step + offset
            half = spread.critical * np.sqrt(np.maximum(np.einsum("kp,pq,kq->k", rows, spread.matrix, rows), 0.0))
            return tuple(
                Estimate(n, float(v), u, float(v - h), float(v + h))
                for (n, (u, *_)), v, h in zip(asked.numbers.items(), middle, half, strict=True)
            )

        place = spread.place(claim, own[0].node)[0] if claim in spread.places else None
        effect = asked.candidate.term.effect if asked.candidate is not None else None
        shape = zip(effect.shape, map(float, one.node), strict=True) if effect and effect.coefficients else ()
        return ChangeFound(
            name=asked.name,
            kind=asked.kind,
            before=said(before, start),
            after=said(before + change, start),
            change=said(change, np.zeros(len(change))),
            place=place if place is not None and np.isfinite(place.high) else None,
            acting=Acting(asked, one.node[None], amount),
            shape=dict(shape),
            look_alikes=one.alike,
            share=one.share,
            p_value=one.p_value,
            course=Course(*np.concatenate(self._course(granted, one), axis=1)),
        )


def _state(granted: Sequence[_Change]) -> State:
    return tuple(held for change in granted for held in change.held)


def _many(one: _Change) -> int:
    """Numbers that tell a change; a factor, which moves several numbers of the model together, is plainer than two."""
    factor = one.held[0].claim.factor
    return len(one.held) + factor + (one.asked.nodes.shape[1] if len(one.asked.nodes) > 1 else 0)


def _turned(one: _Change, after: tuple[int, ...]) -> float:
    """-1 for what those before have and those after have not."""
    return -1.0 if not one.always and one.held[0].groups[0] != after else 1.0
