"""What belongs to recordings: numbers that one recording, or a group of them, has to itself.

Each hypothesis of `exoid.diagnosis.hypotheses` adds columns to the prediction. Its numbers are learnt on one half of
every recording and judged on the other half, by the loss in blocks that the search uses; that of a held-out recording
too, which has no other way to show its own. What every recording has (a zero) is tried first; then whatever lowers the
loss most, with as many recordings as it takes, again and again; and what is needless beside the rest is dropped.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Any

import numpy as np

from exoid.diagnosis.evidence.curves import splines_along
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gain import pooled_scale
from exoid.diagnosis.evidence.gram import inverse_of
from exoid.diagnosis.hypotheses import Claim, Seen, claims_of, hypotheses
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.plain import AsJson
from exoid.ground.ties import ascending, index_of_least, least_of
from exoid.optimisation.linear.loss import huber_terms
from exoid.optimisation.linear.uncertainty import covariance
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate

TRIED = 4
"""Claims that are looked at more closely in a round, those that promise most."""
REWEIGHTED = 3
"""Times that residuals are weighted anew for the last numbers."""
FINER = 3
"""Times that the grid of a place is made finer."""


@dataclass(frozen=True, eq=False)
class Belonging(AsJson):
    """What belongs to recordings: `values` {recording: its number} in `unit`, at a joint or link, as a `sentence`.

    Those that are not named are as usual. `place` is where a load is, m; None where it has none or nobody can tell.
    """

    what: str
    joint: str | None
    unit: str
    values: Mapping[str, Estimate]
    sentence: str
    place: Estimate | None = None

    def _json(self) -> dict[str, Any]:
        values = {name: {"value": e.value, "low": e.low, "high": e.high} for name, e in self.values.items()}
        out = {"what": self.what, "joint": self.joint, "unit": self.unit, "values": values, "sentence": self.sentence}
        return out | ({} if self.place is None else {"place": self.place})


@dataclass(frozen=True, eq=False)
class Claimed:
    """A claim that is held true, at a node; each of the `groups` of recordings (indices) has a number."""

    claim: Claim
    node: float
    groups: tuple[tuple[int, ...], ...]


State = tuple[Claimed, ...]


@dataclass(frozen=True, eq=False)
class Own:
    """What belongs to recordings beside the model `now`: the claims that are `held`, their `numbers` (C,), and for each
    recording those (2, C) by which its two halves are judged.
    """

    now: FittedModel
    held: State
    numbers: Float
    judged: Float
    told: tuple[Belonging, ...]

    def applied(self, prepared: Prepared) -> Prepared:
        """Return recordings without the torque that belongs to them alone; of held-out ones each half without what the
        other half says.
        """
        train = tuple(self._applied(one, unseen=False) for one in prepared.train)
        return replace(prepared, train=train, verify=tuple(self._applied(one, unseen=True) for one in prepared.verify))

    def _applied(self, one: PreparedRecording, *, unseen: bool) -> PreparedRecording:
        index = self._index.get(one.name)
        if index is None or not any(index in group for held in self.held for group in held.groups):
            return one
        early = (np.arange(len(one.motion)) < one.kept[len(one.kept) // 2])[:, None]
        numbers = self.judged[index] if unseen else np.stack([self.numbers, self.numbers])
        first, second = (self._torque(one, index, own) for own in numbers)
        return one.beside_own(np.where(early, first, second))

    @property
    def _index(self) -> dict[str, int]:
        return {one.name: k for k, one in enumerate(self.now.prepared.all)}

    def _torque(self, one: PreparedRecording, index: int, numbers: Float) -> Float:
        """Return the torque (N, J) that belongs to a recording, before the filter."""
        model, shape, linear = self.now.model, self.now.shapes[index], self.now.linear
        columns = model.columns(one.motion, shape, linear if model.needs_reference else None)
        seen = Seen(model, linear, columns, model.torque(one.motion, linear, shape).T, one.motion.t)
        out, at = np.zeros(seen.torque.shape), 0
        for held in self.held:
            column = held.claim.pieces(seen) @ held.claim.mix(held.node)
            for group in held.groups:
                out += numbers[at] * column * (index in group)
                at += 1
        return out.T

    def agrees(self, other: Own) -> bool:
        """Whether another look finds the same in the same recordings, within its intervals."""
        one, two = ({(b.what, b.joint, n): e for b in own.told for n, e in b.values.items()} for own in (self, other))
        return one.keys() == two.keys() and all(two[k].low <= e.value <= two[k].high for k, e in one.items())

    def without(self, names: Sequence[str]) -> tuple[Belonging, ...]:
        """Return what is told of the recordings that are not among `names`."""
        kept = (replace(b, values={n: e for n, e in b.values.items() if n not in names}) for b in self.told)
        return tuple(b for b in kept if b.values)


def belonging_to(now: FittedModel, rules: Rules = RULES) -> Own | None:
    """Return what belongs to recordings beside a model; None where nothing does, and where there is only one recording.
    """
    names = [one.name for one in now.prepared.all]
    if len(set(names)) < len(names) or not 2 <= len(names) <= rules.own_recordings:
        return None
    question = _Recordings(now, rules)
    held = question.found()
    return question.written(held) if held else None


def predicts_better(last: FittedModel, rival: FittedModel, rules: Rules) -> bool:
    """Whether a model beside what belongs to recordings predicts clearly better than the `last` one without."""
    once, then = (one.recording_losses(last.scale, rules) for one in (last, rival))
    return _total(then) <= (1.0 - rules.worth_telling) * _total(once) and clearer(once, then) >= rules.clear


def explained_by(last: FittedModel, rival: FittedModel) -> float:
    """Return by what share of itself the loss of all recordings falls from the `last` model to a rival."""
    once, then = (_total(one.recording_losses(last.scale)) for one in (last, rival))
    return 1.0 - then / once


def clearer(once: Sequence[Float], then: Sequence[Float]) -> float:
    """Return by how many standard errors losses `then`, blocks of each recording, are below `once`.

    What belongs to a recording shows there and nowhere else: blocks are compared with those of their own recording.
    """
    falls = [a - b for a, b in zip(once, then, strict=True)]
    fall = float(sum(one.sum() for one in falls))
    spread = float(np.sqrt(sum(np.sum((one - one.mean()) ** 2) for one in falls)))
    least = 1e-9 * float(sum(one.sum() for one in once))
    return fall / max(spread, least) if abs(fall) > least else 0.0


def _nothing(seen: Seen) -> Float:
    return np.zeros((*seen.torque.shape, 1))


def _total(losses: Sequence[Float]) -> float:
    return float(sum(one.sum() for one in losses))


class _Recordings:
    """All recordings with a fitted model, ready to be asked what belongs to them.

    Rows and columns of a Gram matrix are those of the model, the pieces of all claims, and the residual.
    """

    def __init__(self, now: FittedModel, rules: Rules) -> None:
        evidence = now.evidence(seed=0, draws=0, rules=rules)
        self.now, self.rules, self.blocks = now, rules, evidence.blocks
        self.count = self.blocks[0].columns.shape[2]
        self.prior = evidence.prior
        self.claims = claims_of(now.model)
        pieces = [[claim.pieces(self._seen(k)) for claim in self.claims] for k in range(len(self.blocks))]
        ends = self.count + np.cumsum([0, *(one.shape[2] for one in pieces[0])])
        self.place = {id(claim): slice(a, b) for claim, a, b in zip(self.claims, ends[:-1], ends[1:], strict=True)}
        self.rows = [
            np.concatenate([block.columns, *own, block.residual[:, :, None]], axis=2) * block.use[:, :, None]
            for block, own in zip(self.blocks, pieces, strict=True)
        ]
        self.curves: dict[str | None, State] = {}
        self.sigma = pooled_scale([(b.residual, b.use) for b in self.blocks])
        questions = sum(1 if one.everyone else len(self.blocks) for one in self.claims)
        self.clear = max(rules.clear, NormalDist().inv_cdf(1.0 - rules.strict_level / questions))
        """Standard errors by which one of so many claims is better, not by chance."""
        self.grams = self._weighted(())

    def _seen(self, k: int) -> Seen:
        now, block = self.now, self.blocks[k]
        own = len(now.model.parameters)
        return Seen(now.model, now.linear, block.columns[:, :, :own], now.torque(k), now.prepared.all[k].t)

    # -- fits -------------------------------------------------------------------------------------------------

    def _chosen(self, state: State) -> Float:
        """Return what makes the model's columns, those of `state` and the residual of all rows, (R, D, Q + 1)."""
        width, groups = self.rows[0].shape[2], [(held, group) for held in state for group in held.groups]
        out = np.zeros((len(self.rows), width, self.count + len(groups) + 1))
        out[:, : self.count, : self.count] = np.eye(self.count)
        for c, (held, group) in enumerate(groups, self.count):
            out[list(group), self.place[id(held.claim)], c] = held.claim.mix(held.node)
        out[:, -1, -1] = 1.0
        return out

    def _weighted(self, state: State) -> Float:
        """Return Gram matrices (R, 2, D, D) of halves, weighted as robust as what `state` leaves asks for."""
        left = [r[:, :, -1] for r in self.rows]
        for _ in range(REWEIGHTED if state else 1):
            sigma = pooled_scale([(r, b.use) for r, b in zip(left, self.blocks, strict=True)])
            out = []
            for rows, r in zip(self.rows, left, strict=True):
                size = np.maximum(np.abs(r), 1e-300)
                weight = np.minimum(1.0, self.rules.robust * sigma[:, None] / size) / sigma[:, None] ** 2
                half = rows.shape[1] // 2
                parts = [(rows[:, s], rows[:, s] * weight[:, s, None]) for s in (slice(0, half), slice(half, None))]
                out.append([np.tensordot(a, b, ((0, 1), (0, 1))) for a, b in parts])
            self.grams = np.array(out)
            if state:
                left = self._left(state, [self._fitted(state, np.ones((len(self.rows), 2)))] * 2)
        return self.grams

    def _sums(self, state: State) -> Float:
        chosen = self._chosen(state)[:, None]
        return np.asarray(np.swapaxes(chosen, 2, 3) @ self.grams @ chosen)

    def _fitted(self, state: State, which: Float) -> Float:
        """Return the numbers (Q,) of model and state fitted to the halves that are one in `which` (R, 2)."""
        return self._solved(np.tensordot(which, self._sums(state), ((0, 1), (0, 1))))[0]

    def _solved(self, whole: Float) -> tuple[Float, Float]:
        prior = np.zeros(len(whole) - 1)
        prior[: self.count] = self.prior
        inverse = inverse_of(whole[:-1, :-1] + np.diag(prior))
        return inverse @ whole[:-1, -1], inverse

    def loss(self, state: State) -> float:
        """Return the weighted squared error of every half, judged by numbers of the other halves; infinite where a
        number is none that can be.
        """
        sums, total = self._sums(state).sum(axis=0), 0.0
        for own, other in ((0, 1), (1, 0)):
            step = self._solved(sums[own])[0]
            if not self._possible(state, step):
                return np.inf
            both = np.append(-step, 1.0)
            total += float(both @ sums[other] @ both)
        return total

    def _possible(self, state: State, step: Float) -> bool:
        bounds = [held.claim.bounds for held in state for _ in held.groups]
        return all(low <= x <= high for x, (low, high) in zip(step[self.count :], bounds, strict=True))

    def _left(self, state: State, steps: Sequence[Float]) -> list[Float]:
        """Return what is left (J, K) of each recording, its halves by the numbers `steps` (2, Q)."""
        out = []
        for rows, chosen in zip(self.rows, self._chosen(state), strict=True):
            half = rows.shape[1] // 2
            own = [chosen @ np.append(-step, 1.0) for step in steps]
            out.append(np.concatenate([rows[:, :half] @ own[0], rows[:, half:] @ own[1]], axis=1))
        return out

    def losses(self, state: State) -> list[Float]:
        """Return the Huber loss in blocks of each recording, each half judged by numbers of the other halves."""
        sums = self._sums(state).sum(axis=0)
        left = self._left(state, [self._solved(sums[other])[0] for other in (1, 0)])
        out = []
        for r, block in zip(left, self.blocks, strict=True):
            size = huber_terms(np.abs(r) / self.sigma[:, None], self.rules.robust)
            out.append(np.add.reduceat(size.sum(axis=0), block.starts(self.rules.block_seconds)))
        return out

    def pays(self, before: State, after: State, clear: float) -> bool:
        """Whether `after` predicts the other halves clearly better than `before`, and by a part worth telling."""
        once, then = self.losses(before), self.losses(after)
        enough = _total(then) <= (1.0 - self.rules.worth_telling) * _total(once)
        return enough and bool(np.isfinite(self.loss(after))) and clearer(once, then) >= clear

    # -- the search -------------------------------------------------------------------------------------------

    def found(self) -> State:
        """Return the claims that hold."""
        state: State = ()
        every = tuple((k,) for k in range(len(self.blocks)))
        for claim in self.claims:
            own = Claimed(claim, claim.nodes[0], every)
            if claim.everyone and self.pays(self._needless(state, own), (*state, own), self.clear):
                state = (*state, own)
        while True:
            self._weighted(state)
            longer = [(*state, self._grown(state, held)) for held in self._promising(state)]
            best = least_of(longer, self.loss, 1.0) if longer else state
            if not self.pays(state, best, self.clear) or self._is_a_curve(state, best[-1]):
                break
            state = best
        self._weighted(state)
        return self._pruned(state)

    def _is_a_curve(self, rest: State, held: Claimed) -> bool:
        """Whether one curve in its joint's velocity, the same in all recordings, explains what a claim does: where each
        recording has a speed of its own, friction that depends on speed looks like friction that differs.
        """
        curve = self._curve(held.claim.place)
        if not curve:
            return False
        self._weighted((*rest, held))
        return not self.pays((*rest, *curve), (*rest, held), self.clear)

    def _curve(self, joint: str | None) -> State:
        """Return a curve as claims of all recordings together, one for each spline; none where `joint` is no joint."""
        names = self.now.model.joint_names
        if joint in self.curves or joint not in names:
            return self.curves.get(joint, ())
        place = names.index(joint)
        everywhere = replace(self.now, prepared=replace(self.now.prepared, train=self.now.prepared.all, verify=()))
        splines = splines_along(everywhere, f"dq{place + 1}", place, "sign", self.rules.knots)
        if splines is None:
            return ()
        first, many = self.rows[0].shape[2] - 1, splines.basis.shape[1]
        for k, (rows, one, block) in enumerate(zip(self.rows, splines.columns, self.blocks, strict=True)):
            columns = np.zeros((*rows.shape[:2], many))
            columns[place] = one.values[0, 0] * block.use[place][:, None]
            self.rows[k] = np.concatenate([rows[:, :, :-1], columns, rows[:, :, -1:]], axis=2)
        claims = [Claim("curve", joint, "N·m", _nothing, (-np.inf, np.inf)) for _ in range(many)]
        self.place |= {id(claim): slice(first + k, first + k + 1) for k, claim in enumerate(claims)}
        self.curves[joint] = tuple(Claimed(claim, 0.0, (tuple(range(len(self.rows))),)) for claim in claims)
        return self.curves[joint]

    def _promising(self, state: State) -> list[Claimed]:
        """Return of every claim that is not held the recording and node that promise most, the best few."""
        taken = {id(held.claim) for held in state}
        free = [one for one in self.claims if not one.everyone and id(one) not in taken]
        nodes = [(claim, node) for claim in free for node in claim.nodes]
        if not nodes:
            return []
        mixed = np.zeros((self.rows[0].shape[2], len(nodes)))
        for c, (claim, node) in enumerate(nodes):
            mixed[self.place[id(claim)], c] = claim.mix(node)
        low, high = np.array([claim.bounds for claim, _ in nodes]).T
        # What one recording has less of all others have more of, where the model's own numbers hold what all have.
        low = np.where([claim.shared for claim, _ in nodes], -high, low)
        sums, chosen = self._sums(state), self._chosen(state)
        total = sums.sum(axis=0)
        now = 0.0
        losses, numbers = np.zeros((2, len(self.blocks), len(nodes)))
        solved = [self._solved(total[own]) for own in (0, 1)]
        for own, other in ((0, 1), (1, 0)):
            step, inverse = solved[own]
            both = np.append(-step, 1.0)
            now += float(both @ total[other] @ both)
            for k in range(len(self.blocks)):
                fit, held = (chosen[k].T @ self.grams[k, h] @ mixed for h in (own, other))
                square = [np.einsum("dn,de,en->n", mixed, self.grams[k, h], mixed, optimize=True) for h in (own, other)]
                lean = inverse @ fit[:-1]
                power = square[0] - np.sum(fit[:-1] * lean, axis=0)
                seen = power > self.rules.negligible * square[0]
                number = np.where(seen, (fit[-1] - step @ fit[:-1]) / np.where(seen, power, 1.0), 0.0)
                moved = np.vstack([-(step[:, None] - lean * number), np.ones(len(nodes))])
                left = np.einsum("qn,qr,rn->n", moved, total[other], moved, optimize=True)
                left += number**2 * square[1] - 2.0 * number * np.sum(moved * held, axis=0)
                numbers[k] += number
                losses[k] += np.where((low <= number) & (number <= high), left, np.inf)
        best: list[tuple[float, Claimed]] = []
        for claim in free:
            mine = [c for c, (one, _) in enumerate(nodes) if one is claim]
            k, c = divmod(index_of_least(losses[:, mine].ravel()), len(mine))
            less = claim.shared and numbers[k, mine[c]] < 0.0
            group = tuple(j for j in range(len(self.blocks)) if (j == k) != less)
            best.append((float(losses[k, mine[c]]), Claimed(claim, claim.nodes[c], (group,))))
        useful = [one for one in best if one[0] <= (1.0 - self.rules.least_share) * now]
        return [held for _, held in ascending(useful, lambda one: one[0], 1.0)[:TRIED]]

    def _grown(self, state: State, held: Claimed) -> Claimed:
        """Return a claim with as many recordings as clearly have it."""
        held = self._placed(state, held)
        while True:
            others = self._others(held)
            if not others:
                return held
            best = self._placed(state, least_of(others, lambda one: self.loss((*state, one)), 1.0))
            clear = self.rules.clear if held.claim.shared else self.clear
            once, then = self.losses((*state, held)), self.losses((*state, best))
            if not np.isfinite(self.loss((*state, best))) or clearer(once, then) < clear:
                return held
            held = best

    def _others(self, held: Claimed) -> list[Claimed]:
        """Return a claim with one recording more; of a number that is shared, also with one less. One recording at
        least says what is usual.
        """
        every = range(len(self.blocks))
        if held.claim.shared:
            toggled = [tuple(j for j in every if (j in held.groups[0]) != (j == k)) for k in every]
            return [replace(held, groups=(one,)) for one in toggled if 0 < len(one) < len(every)]
        inside = {k for group in held.groups for k in group}
        longer = [tuple(sorted((*held.groups, (k,)))) for k in every if k not in inside]
        return [replace(held, groups=one) for one in longer if len(one) < len(every)]

    def _placed(self, state: State, held: Claimed) -> Claimed:
        """Return a claim at the node that fits best."""
        nodes = np.array(held.claim.nodes)
        if len(nodes) < 2:
            return held
        step = float(nodes[1] - nodes[0])
        best = held
        for _ in range(1 + FINER):
            tried = [replace(held, node=float(node)) for node in nodes]
            best = least_of(tried, lambda one: self.loss((*state, one)), 1.0)
            nodes = best.node + step * np.array([-0.5, -0.25, 0.0, 0.25, 0.5])
            nodes = nodes[nodes > 0.0]
            step *= 0.25
        return best

    def _pruned(self, state: State) -> State:
        """Return the claims that are not needless beside the others."""
        while len(state) > 1:
            rivals = [self._needless(tuple(one for one in state if one is not out), out) for out in state]
            best = index_of_least([_total(self.losses(one)) for one in rivals])
            if self.pays(rivals[best], state, self.clear):
                break
            state = rivals[best][: len(state) - 1]
        return state

    def _needless(self, rest: State, held: Claimed) -> State:
        """Return what explains as much where a claim is needless: nothing, or of what everyone has, the same number in
        all recordings; that is the machine's, and has its place in the catalogue.
        """
        same = tuple(range(len(self.blocks)))
        rest = (*rest, replace(held, groups=(same,))) if held.claim.everyone else rest
        for one in rest:
            others = tuple(other for other in rest if other is not one)
            rest = tuple(self._placed(others, other) if other is one else other for other in rest)
        return rest

    # -- numbers ----------------------------------------------------------------------------------------------

    def written(self, state: State) -> Own:
        """Return the claims with their numbers and intervals."""
        which = np.ones((len(self.rows), 2))
        step = self._fitted(state, which)
        judged = np.zeros((len(self.rows), 2, len(step) - self.count))
        for k, half in np.ndindex(len(self.rows), 2):
            if any(k in group for held in state for group in held.groups):
                others = which.copy()
                others[k, half] = 0.0
                judged[k, half] = self._fitted(state, others)[self.count :]
        numbers = step[self.count :]
        half_width = self._half_widths(state, step)
        told, at = [], 0
        for held in state:
            many = len(held.groups)
            told.append(self._told(held, numbers[at : at + many], half_width, at))
            at += many
        return Own(self.now, state, numbers, judged, tuple(told))

    def _half_widths(self, state: State, step: Float) -> _Spread:
        """Return how well numbers and places are known, valid under autocorrelation."""
        left = self._left(state, [step, step])
        sigma = pooled_scale([(r, b.use) for r, b in zip(left, self.blocks, strict=True)])
        groups = [(held, group) for held in state for group in held.groups]
        slopes = []
        for c, (held, group) in enumerate(groups):
            if len(held.claim.nodes) > 1:
                h = 1e-4 * held.node
                turn = (held.claim.mix(held.node + h) - held.claim.mix(held.node - h)) / (2.0 * h)
                slopes.append((held.claim, group, step[self.count + c] * turn))
        parts = []
        for k, (rows, chosen) in enumerate(zip(self.rows, self._chosen(state), strict=True)):
            own = [
                rows[:, :, self.place[id(claim)]] @ turn * (k in group) for claim, group, turn in slopes
            ]
            parts.append(np.concatenate([rows @ chosen[:, :-1], *(x[:, :, None] for x in own)], axis=2))
        recordings = np.repeat(np.arange(len(parts)), [part.shape[1] for part in parts])
        found = covariance(
            np.concatenate(parts, axis=1), np.concatenate(left, axis=1), self.rules.robust * sigma, recordings
        )
        width = found.half_widths()
        places = {id(claim): self.count + len(groups) + k for k, (claim, _, _) in enumerate(slopes)}
        return _Spread(found.matrix, found.critical, width, self.count, places)

    def _told(self, held: Claimed, numbers: Float, spread: _Spread, at: int) -> Belonging:
        claim, names = held.claim, [one.name for one in self.now.prepared.all]
        known = [spread.number(at + k) for k in range(len(numbers))]
        unit, place = claim.unit, None
        if len(claim.nodes) > 1:
            known, numbers, unit, place = spread.load(claim, held.node, float(numbers[0]), at, self.rules)
        found = {
            names[k]: Estimate(claim.what, x, unit, x - w, x + w)
            for group, x, w in zip(held.groups, claim.usual + numbers, known, strict=True)
            for k in group
        }
        values = {name: found[name] for name in sorted(found)}
        said = {name: _said(e) for name, e in values.items()}
        where = "" if place is None else f" at {_said(place)}"
        sentence = hypotheses()[claim.what].said(claim.place, said, where)
        return Belonging(claim.what, claim.place, unit, values, sentence, place)


@dataclass(frozen=True, eq=False)
class _Spread:
    """The covariance of all numbers, of which the first `count` are the model's; `places` {claim: its place's}."""

    matrix: Float
    critical: float
    width: Float
    count: int
    places: Mapping[int, int]

    def number(self, at: int) -> float:
        """Return the half-width of an own number."""
        return float(self.width[self.count + at])

    def load(
        self, claim: Claim, node: float, number: float, at: int, rules: Rules
    ) -> tuple[list[float], Float, str, Estimate | None]:
        """Return half-width, value and unit of a load and its place; where nobody can tell these apart, of its first
        moment or inertia, without a place.
        """
        rows = [self.count + at, self.places[id(claim)]]
        both, far = self.matrix[np.ix_(rows, rows)], self.width[rows]
        if np.all(far <= rules.half * np.array([number, node])):
            place = Estimate("place", node, "m", node - float(far[1]), node + float(far[1]))
            return [float(far[0])], np.array([number]), claim.unit, place
        told = []
        for power, unit in ((1, "kg·m"), (2, "kg·m²")):
            slope = np.array([node**power, power * number * node ** (power - 1)])
            width = self.critical * float(np.sqrt(max(slope @ both @ slope, 0.0)))
            told.append((width / (number * node**power), width, number * node**power, unit))
        _, width, value, unit = least_of(told, lambda one: one[0], 1.0)
        return [width], np.array([value]), unit, None


def _said(one: Estimate) -> str:
    """Return "0.91 ± 0.02 N·m"."""
    half = 0.5 * (one.high - one.low)
    digits = max(0, 1 - int(np.floor(np.log10(half)))) if half > 0.0 and np.isfinite(half) else 3
    unit = "" if one.unit == "1" else f" {one.unit}"
    return f"{one.value:.{digits}f} ± {half:.2g}{unit}"
