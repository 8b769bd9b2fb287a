"""The model and what may belong to recordings, fitted together to halves of them by Gram matrices."""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from exoid.diagnosis.evidence.curves import splines_along
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gain import pooled_scale
from exoid.diagnosis.evidence.gram import inverse_of
from exoid.diagnosis.hypotheses.recordings import Claim, Seen, claims_of, nothing
from exoid.diagnosis.own_numbers.compared import falls_clearly, total
from exoid.diagnosis.own_numbers.state import Claimed, Cuts, Part, State, grouped, of_part, parts_of, state_columns
from exoid.diagnosis.rules import Rules
from exoid.optimisation.linear.loss import huber_terms
from exoid.optimisation.preparation.filtering import PreparedRecording, driven_joints
from exoid.symbolic.motion import Float, Motion, slope_by

ALIKE = 1e-9
"""Part by which the cosine between two columns may be below one where they are the same but for rounding."""
REWEIGHTED = 3
"""Times that residuals are weighted anew for the last numbers."""
KEPT = 12
"""Weighings that are kept, since a search comes back to them soon."""
CLOSER, CLOSE = 12, 3e-3
"""Times at most where columns bend with numbers, as those of a gain do, and the change of what is left that ends them.
"""


def seen_before_filter(now: FittedModel, one: PreparedRecording, linear: Float, shape: Float) -> Seen:
    """A model at `linear` numbers (P,) and a shape (S,) on a recording, at all samples of its motion; its torque with
    that of a load that is known already.
    """

    def torque_on(motion: Motion) -> Float:
        torque = now.model.torque(motion, linear, shape)
        return (torque if motion.load is None else torque + motion.load).T

    columns, t = columns_on(now, one.motion, shape), one.motion.t
    return Seen(
        now.model, linear, columns, torque_on(one.motion), t, one.logged, float(t[0]),
        elsewhere=lambda times: torque_on(one.at(times)),
        by_angle=lambda joint: slope_by(torque_on, one.motion, "q", joint),
    )  # fmt: skip


def columns_on(now: FittedModel, motion: Motion, shape: Float) -> Float:
    """Columns (J, N, P) of a model on a motion, at a shape (S,)."""
    return now.model.columns(motion, shape, now.linear if now.model.needs_reference else None)


@dataclass(eq=False)
class Weighing:
    """Weights of halves, as robust as what a `state` leaves of each part (`left`, (J, K)) asks for; the numbers (Q,) at
    which it does; and Gram matrices (R, 2, D, D) of the columns that are `known`, zero for others.
    """

    state: State
    step: Float
    left: Sequence[Float]
    grams: Float | None = None
    known: frozenset[int] = frozenset()


class Fits:
    """All parts of recordings with a fitted model, ready to be fitted anew with claims.

    Rows and columns of a Gram matrix are those of the model and of what all recordings may have alike (an offset, which
    the model lacks or not: what differs is told from there), the pieces of all claims, and the residual. Where
    recordings are cut, a zero may also begin at the cut. What multiplies a torque of the model does so at the `linear`
    numbers (P,), which every weighing finds anew: another gain of half the recordings spoils those of the model given.
    `parts` are those at the cuts whose motion is another one by numbers that are known already.
    """

    def __init__(self, now: FittedModel, rules: Rules, cuts: Cuts, parts: Sequence[Part] = ()) -> None:
        evidence = now.evidence(seed=0, draws=0, rules=rules)
        self.now, self.rules, self.blocks, self.cuts = now, rules, evidence.blocks, cuts
        self.parts = tuple(parts) or parts_of(self.blocks, cuts)
        self.linear = now.linear
        self.torques = [now.torque(k) for k in range(len(self.blocks))]
        for k, recording in enumerate(now.prepared.all):
            if (load := recording.motion.load) is not None:
                self.torques[k] = self.torques[k] + recording.smooth(load)
        self.rising = [self._rising(k) for k in range(len(self.blocks))]
        self.claims = claims_of(now.model, driven_joints(now.prepared.all), state_columns(now))
        self.turning = [self._turning(k) for k in range(len(self.blocks))]
        self.seen: dict[int, Seen] = {}
        pieces = [[claim.pieces(self._seen(k)) for claim in self.claims] for k in range(len(self.blocks))]
        same = [k for k, claim in enumerate(self.claims) if claim.everyone]
        self.count = self.blocks[0].columns.shape[2] + len(same)
        self.prior = np.concatenate([evidence.prior, np.zeros(len(same))])
        ends = self.count + np.cumsum([0, *(item.shape[2] for item in pieces[0])])
        self.place = {claim: slice(a, b) for claim, a, b in zip(self.claims, ends[:-1], ends[1:], strict=True)}
        if cuts:
            late = {claim: replace(claim, everyone=False) for claim in self.claims if claim.everyone}
            self.place |= {claim: self.place[whole] for whole, claim in late.items()}
            self.claims = (*self.claims, *late.values())
        rows = [
            np.concatenate([block.columns, *(own[k] for k in same), *own, block.residual[:, :, None]], axis=2)
            * block.use[:, :, None]
            for block, own in zip(self.blocks, pieces, strict=True)
        ]
        self.rows = [rows[part.recording][:, part.kept] for part in self.parts]
        self.use = [self.blocks[part.recording].use[:, part.kept] for part in self.parts]
        self.alike = self._alike([claim for claim in self.claims if claim.everyone])
        every, seconds = now.prepared.all, rules.block_seconds
        self.starts = [every[p.recording].starts_within(seconds, p.start, p.stop) for p in self.parts]
        self.curves: dict[str | None, State] = {}
        self.weighed: dict[tuple[Any, ...], Weighing] = {}
        self.weighed_for: tuple[Any, ...] | None = None
        self.sigma = pooled_scale([(b.residual, b.use) for b in self.blocks])
        self.weigh(())

    @property
    def everyone(self) -> tuple[tuple[int, ...], ...]:
        """Groups of parts, those of each recording together."""
        parts = list(enumerate(self.parts))
        return tuple(tuple(j for j, part in parts if part.recording == k) for k in range(len(self.blocks)))

    def _alike(self, claims: Sequence[Claim]) -> dict[int, list[Claim]]:
        """Return the model's numbers that do what `claims` of everyone do, each at its own joint, with these: the
        constant of a spring, the pretension of one across two joints.
        """
        every = np.concatenate([rows[:, :, : self.count] for rows in self.rows], axis=1).reshape(-1, self.count)
        own = np.stack([np.concatenate([rows[:, :, self.place[c]] for rows in self.rows], axis=1) for c in claims])
        own = own.reshape(len(claims), -1)
        size = np.linalg.norm(own, axis=1)[:, None] * np.linalg.norm(every, axis=0)
        share = np.square((own @ every) / np.maximum(size, 1e-300))
        found = np.flatnonzero(share.sum(axis=0) >= 1.0 - ALIKE).tolist()
        return {k: [claims[c] for c in np.flatnonzero(share[:, k] > ALIKE).tolist()] for k in found}

    def _held(self, state: State) -> set[int]:
        """Return the model's numbers that are held where they are beside claims of everyone that do the same: nobody
        could tell the recordings' numbers from theirs.
        """
        known = [item.claim for item in state]
        return {k for k, claims in self.alike.items() if any(claim in known for claim in claims)}

    def mixed_with(self, claim: Claim) -> tuple[str, ...]:
        """Names of the model's numbers that do what a claim of everyone does: only how recordings differ is known."""
        names = [parameter.name for parameter in self.now.model.parameters]
        alike = ({item.place for item in claims if item.what == claim.what} for claims in self.alike.values())
        return tuple(names[k] for k, at in zip(self.alike, alike, strict=True) if k < len(names) and claim.place in at)

    def needless(self, state: State) -> tuple[str, ...]:
        """Terms of the model that do no more than what each recording has, such as an offset beside zeros."""
        model, held = self.now.model, self._held(state)
        bent = {entry.term for entry in model.shapes}
        own = {term.name: {k for k, p in enumerate(model.parameters) if p.term == term.name} for term in model.terms}
        return tuple(name for name, places in own.items() if places and places <= held and name not in bent)

    def moved(self, other: Fits, state: State) -> State:
        """Claims of other fits to these recordings, cut elsewhere or not at all, as claims of these fits."""
        out = []
        for held in state:
            claim = self.claims[other.claims.index(held.claim)]
            groups = [tuple(j for j in range(len(self.parts)) if self._is_in(j, other, group)) for group in held.groups]
            out.append(Claimed(claim, held.node, tuple(dict.fromkeys(groups))))
        return tuple(out)

    def _is_in(self, j: int, other: Fits, group: tuple[int, ...]) -> bool:
        """True where a part of a recording, or one like it, is among a group of parts of other fits."""
        own = self.parts[j]
        alike = [other.parts[i] for i in group if other.parts[i].recording == own.recording]
        return any(own.whole or item.whole or (own.start == 0) == (item.start == 0) for item in alike)

    def _seen(self, k: int) -> Seen:
        """Return the model on a recording as claims see it, made once for the numbers at which factors are placed."""
        if k in self.seen:
            return self.seen[k]
        now, columns = self.now, self.blocks[k].columns[:, :, : len(self.linear)]
        moved, recording = self.linear - now.linear, now.prepared.all[k]
        torque, rising = self.torques[k] + columns @ moved, self.rising[k] @ np.append(moved, 1.0)
        began = float(recording.motion.t[0])
        linear, turning = self.linear, self.turning[k]
        self.seen[k] = Seen(
            now.model, linear, columns, torque, recording.t, recording.logged, began, rising=rising,
            by_angle=lambda joint: turning[joint] @ linear,
        )  # fmt: skip
        return self.seen[k]

    def _turning(self, k: int) -> dict[int, Float]:
        """Return the filtered derivatives (J, K, P) of the model's columns by the angles of which claims ask."""
        recording, shape = self.now.prepared.all[k], self.now.shapes[k]
        joints = [claim.turns for claim in self.claims if claim.turns is not None]
        of = partial(columns_on, self.now, shape=shape)
        return {j: recording.smooth_columns(slope_by(of, recording.motion, "q", j)) for j in joints}

    def _rising(self, k: int) -> Float:
        """Return the filtered slopes (J, K, P + 1) over time of the model's columns on a recording, and of its torque:
        where friction turns its sign samples are hidden, and no slope of what passed the filter knows that.
        """
        recording = self.now.prepared.all[k]
        seen = seen_before_filter(self.now, recording, self.linear, self.now.shapes[k])
        both = np.concatenate([seen.columns, seen.torque[:, :, None]], axis=2)
        return recording.smooth_columns(np.gradient(both, seen.t, axis=1))

    def _place_factors(self, state: State, step: Float, claims: Iterable[Claim] | None = None) -> None:
        """Have `claims` that multiply a torque of the model, of each part those that are held of it unless they are
        given, do so at numbers (Q,) of it and of the state.
        """
        made: dict[tuple[Claim, int, float], Float] = {}  # parts of a recording that know no number have the same
        for j, (rows, part, use) in enumerate(zip(self.rows, self.parts, self.use, strict=True)):
            numbers = self.numbers_of(state, step, j)
            for claim in numbers if claims is None else claims:
                if claim.factor:
                    key = claim, part.recording, numbers.get(claim, 0.0)
                    if key not in made:
                        made[key] = self.pieces(*key)
                    rows[:, :, self.place[claim]] = made[key][:, part.kept] * use[:, :, None]

    def _linearise(self, step: Float) -> None:
        """Have the model's torque, which claims multiply, be that at other numbers (Q,) of it."""
        self.linear, self.seen = self.now.linear + step[: len(self.linear)], {}

    def _multiply(self, state: State, step: Float) -> None:
        """Have the model's columns be multiplied as the `state` multiplies its torque, about numbers (Q,): those of the
        model would not come to rest beside a large gain otherwise.
        """
        count = len(self.linear)
        for j, (rows, part, use) in enumerate(zip(self.rows, self.parts, self.use, strict=True)):
            own = {claim: x for claim, x in self.numbers_of(state, step, j).items() if claim.multiplies}
            if own:
                block, more = self.blocks[part.recording], self._multiplied(part, own)
                rows[:, :, :count] = (block.columns[:, part.kept, :count] + more) * use[:, :, None]
                rows[:, :, -1] = (block.residual[:, part.kept] + more @ step[:count]) * use

    def _multiplied(self, part: Part, numbers: Mapping[Claim, float]) -> Float:
        """Return by how much the model's columns (J, K, P) on a part change where claims multiply their torque."""
        out = np.zeros((*self.blocks[part.recording].use[:, part.kept].shape, len(self.linear)))
        for claim, number in numbers.items():
            for p in range(len(self.linear) if claim.multiplies and number else 0):
                out[:, :, p] += number * self.pieces(claim, part.recording, number, p)[:, part.kept, 0]
        return out

    def pieces(self, claim: Claim, k: int, number: float, alone: int | None = None) -> Float:
        """Pieces (J, K, m) of a claim on a recording, where its number is known already; of one number `alone` of the
        model. What moves a torque in time does so before the filter, which bridges samples where they are.
        """
        seen, recording = self._seen(k), self.now.prepared.all[k]
        early = claim.moves is not None and number != 0.0
        if early:
            seen = seen_before_filter(self.now, recording, self.linear, self.now.shapes[k])
        if alone is not None:
            alike, by_angle = np.eye(len(self.linear))[alone], self.turning[k]
            seen = replace(
                seen, linear=alike, torque=seen.columns[:, :, alone], by_angle=lambda joint: by_angle[joint] @ alike
            )
        pieces = claim.pieces(replace(seen, number=number) if number else seen)
        return recording.smooth_columns(pieces) if early else pieces

    def _moved(self, claim: Claim, k: int, number: float) -> Float:
        """Return by how much the model's columns (J, K, P) on a recording change where a claim moves them in time."""
        assert claim.moves is not None
        recording, shape = self.now.prepared.all[k], self.now.shapes[k]
        seen = seen_before_filter(self.now, recording, self.linear, shape)
        then = columns_on(self.now, recording.at(claim.moves(replace(seen, number=number))), shape) - seen.columns
        if claim.place is not None:  # of one joint alone
            then[np.array(self.now.model.joint_names) != claim.place] = 0.0
        return recording.smooth_columns(then)

    def numbers_of(self, state: State, step: Float, j: int) -> dict[Claim, float]:
        """Numbers of the claims that hold of a part (index), of those (Q,) of the model and of the state."""
        own = of_part(state, step[self.count :], j)
        return {held.claim: float(np.clip(x, *held.claim.bounds)) for held, x in own}

    def slopes(self, state: State, numbers: Float) -> list[Float]:
        """Derivatives (J, K, P) of what `state` adds to each part by the model's numbers, at its own `numbers` (C,)."""
        out = []
        for j, (part, use) in enumerate(zip(self.parts, self.use, strict=True)):
            own = {held.claim: number for held, number in of_part(state, numbers, j)}
            slope = self._multiplied(part, own)
            for claim, number in own.items():
                if claim.moves:
                    slope += self._moved(claim, part.recording, number)[:, part.kept]
            out.append(slope * use[:, :, None])
        return out

    def chosen(self, state: State) -> Float:
        """Matrices (R, D, Q + 1) from rows to the model's columns, those of `state`, and the residual."""
        width, groups = self.rows[0].shape[2], grouped(state)
        out = np.zeros((len(self.rows), width, self.count + len(groups) + 1))
        free = np.ones(self.count)
        free[list(self._held(state))] = 0.0
        out[:, : self.count, : self.count] = np.diag(free)
        for c, (held, group) in enumerate(groups, self.count):
            out[list(group), self.place[held.claim], c] = held.claim.mix(held.node)
            if held.claim.moves:
                out[list(group), self.place[held.claim].stop - 1, -1] = -1.0
        out[:, -1, -1] = 1.0
        return out

    def weigh(self, state: State) -> None:
        """Weigh halves as robust as what `state` leaves asks for, and have what multiplies a torque of the model do so
        at the numbers that are then found: whatever was asked before. Most that is asked then is about what is held:
        other claims follow as soon as one of them is asked about.
        """
        key = tuple((held.claim, held.node, held.groups) for held in state)
        if key == self.weighed_for:
            return
        if key in self.weighed:
            self.weighing = self.weighed[key]
            self._stand()
        else:
            if len(self.weighed) >= KEPT:
                del self.weighed[next(iter(self.weighed))]
            self.weighed[key] = self._weigh_anew(state)
        self.weighed_for = key

    def _weigh_anew(self, state: State) -> Weighing:
        whole, factors = range(self.rows[0].shape[2]), any(held.claim.factor for held in state)
        own = {*whole[: self.count], whole[-1], *(c for held in state for c in whole[self.place[held.claim]])}
        step, left = np.zeros(self.count + len(grouped(state))), [rows[:, :, -1] for rows in self.rows]
        self.weighing = Weighing(state, step, left)
        self._stand()  # where another weighing had them
        for k in range((CLOSER if factors else REWEIGHTED) if state else 0):
            self.weighing = Weighing(state, step, left)
            self._sum_up(own)
            step = self.together(state)
            if factors:
                self._linearise(step)
                self._place_factors(state, step)
                self._multiply(state, step)
            before, left = left, self.left_by(state, [step] * 2)
            moved = sum(float(np.sum((now - then) ** 2)) for now, then in zip(left, before, strict=True))
            if k + 1 >= REWEIGHTED and moved <= CLOSE**2 * sum(float(np.sum(now**2)) for now in left):
                break
        self._multiply(state, np.zeros(len(step)))  # columns are compared with and without them
        self.weighing = Weighing(state, step, left)
        self._stand()
        self._sum_up(own.union(c for claim in self.claims if claim.everyone for c in whole[self.place[claim]]))
        return self.weighing

    def _stand(self) -> None:
        """Have what the present weighing holds stand at its numbers, and what every recording has: other claims do once
        they are asked about.
        """
        self._linearise(self.weighing.step)
        self.standing = set[Claim]()
        every = (claim for claim in self.claims if claim.everyone)
        self._ask([*(held.claim for held in self.weighing.state), *every])

    def _ask(self, claims: Iterable[Claim]) -> None:
        """Have `claims` that multiply a torque of the model do so where the present weighing has it."""
        late = [claim for claim in claims if claim.factor and claim not in self.standing]
        self._place_factors(self.weighing.state, self.weighing.step, late)
        self.standing.update(late)

    def ask_all(self) -> None:
        """Have all claims stand where the present weighing has them, and be in its `grams`."""
        self._ask(self.claims)
        self._sum_up(range(self.rows[0].shape[2]))

    @property
    def grams(self) -> Float:
        """Weighted Gram matrices (R, 2, D, D) of halves; zero for columns that nobody asked about."""
        assert self.weighing.grams is not None
        return self.weighing.grams

    def _sum_up(self, columns: Collection[int]) -> None:
        """Make Gram matrices of some columns; what is known already stays the same to the last digit."""
        now, width = self.weighing, self.rows[0].shape[2]
        if len(now.known) == width:
            return
        grams, some = np.zeros((len(self.rows), 2, width, width)), sorted(columns)
        sigma = pooled_scale(list(zip(now.left, self.use, strict=True)))
        for halves, rows, r in zip(grams, self.rows, now.left, strict=True):
            size = np.maximum(np.abs(r), 1e-300)
            weight = np.minimum(1.0, self.rules.robust * sigma[:, None] / size) / sigma[:, None] ** 2
            half = rows.shape[1] // 2
            for gram, part in zip(halves, (slice(0, half), slice(half, None)), strict=True):
                own = rows[:, part] if len(some) == width else rows[:, part, some]
                gram[np.ix_(some, some)] = np.tensordot(own, own * weight[:, part, None], ((0, 1), (0, 1)))
        if now.grams is not None:
            down, across = np.ix_(sorted(now.known), sorted(now.known))
            grams[:, :, down, across] = now.grams[:, :, down, across]
        now.grams, now.known = grams, frozenset(some)

    def sums(self, state: State) -> Float:
        """Gram matrices (R, 2, Q + 1, Q + 1) of halves for model, state and residual."""
        known, whole = self.weighing.known, range(self.rows[0].shape[2])
        if len(known) < len(whole) and not known.issuperset(c for h in state for c in whole[self.place[h.claim]]):
            self.ask_all()
        chosen = self.chosen(state)[:, None]
        some = np.flatnonzero(chosen.any(axis=(0, 1, 3)))
        chosen = chosen[:, :, some]
        return np.asarray(np.swapaxes(chosen, 2, 3) @ self.grams[:, :, some[:, None], some] @ chosen)

    def together(self, state: State, without: tuple[int, ...] = ()) -> Float:
        """Numbers (Q,) of model and state fitted to all halves, or to all `without` one (part, half)."""
        which = np.ones((len(self.rows), 2))
        if without:
            which[without] = 0.0
        return self.solved(np.tensordot(which, self.sums(state), ((0, 1), (0, 1))))[0]

    def solved(self, whole: Float) -> tuple[Float, Float]:
        """Numbers (..., Q) that Gram matrices (..., Q + 1, Q + 1) ask for, and inverses (..., Q, Q) of their normal
        matrices.
        """
        prior = np.zeros(whole.shape[-1] - 1)
        prior[: self.count] = self.prior
        inverse = inverse_of(whole[..., :-1, :-1] + np.diag(prior))
        return (inverse @ whole[..., :-1, -1:])[..., 0], inverse

    def loss(self, state: State) -> float:
        """Weighted squared error of halves by numbers of the others; infinite where a number is none that can be."""
        sums, loss = self.sums(state).sum(axis=0), 0.0
        bounds = [held.claim.bounds for held, _ in grouped(state)]
        for step, other in zip(self.solved(sums)[0], sums[::-1], strict=True):
            if any(not low <= x <= high for x, (low, high) in zip(step[self.count :], bounds, strict=True)):
                return np.inf
            both = np.append(-step, 1.0)
            loss += float(both @ other @ both)
        return loss

    def squares(self, state: State) -> float:
        """Weighted squared error of all halves by the numbers that fit all of them best."""
        whole = self.sums(state).sum(axis=(0, 1))
        return float(whole[-1, -1] - whole[:-1, -1] @ self.solved(whole)[0])

    def place_step(self, state: State) -> Float:
        """Gauss-Newton step (D,) of the node of the last claim, taken with all numbers."""
        *_, held = state
        numbers, chosen = self.together(state)[-len(held.groups) :], self.chosen(state)
        turned = np.zeros((*chosen.shape[:2], len(held.node)))
        for group, number in zip(held.groups, numbers, strict=True):
            turned[list(group), self.place[held.claim]] = number * held.turn
        both = np.concatenate([chosen[:, :, :-1], turned, chosen[:, :, -1:]], axis=2)
        whole = (np.swapaxes(both, 1, 2) @ self.grams.sum(axis=1) @ both).sum(axis=0)
        return self.solved(whole)[0][-len(held.node) :]

    def rescale(self, state: State) -> None:
        """Count losses from here on in units of what `state` leaves: beside what is large, bursts would be nothing."""
        self.sigma = pooled_scale(list(zip(self.left(state), self.use, strict=True)))

    def left(self, state: State) -> list[Float]:
        """Residuals (J, K) of each part by the numbers that fit all halves best."""
        return self.left_by(state, [self.together(state)] * 2)

    def left_by(self, state: State, steps: Sequence[Float] | Float) -> list[Float]:
        """Residuals (J, K) of each part, its halves by the numbers `steps` (2, Q)."""
        self._ask(held.claim for held in state)
        out = []
        for rows, chosen in zip(self.rows, self.chosen(state), strict=True):
            half = rows.shape[1] // 2
            own = [chosen @ np.append(-step, 1.0) for step in steps]
            out.append(np.concatenate([rows[:, :half] @ own[0], rows[:, half:] @ own[1]], axis=1))
        return out

    def losses(self, state: State) -> list[Float]:
        """Huber loss in blocks of each part, each half judged by numbers of the other halves."""
        left = self.left_by(state, self.solved(self.sums(state).sum(axis=0))[0][::-1])
        out = []
        for r, starts in zip(left, self.starts, strict=True):
            size = huber_terms(np.abs(r) / self.sigma[:, None], self.rules.robust)
            out.append(np.add.reduceat(size.sum(axis=0), starts))
        return out

    def weighed_loss(self, state: State) -> float:
        """Loss of all recordings, the fit weighted for these claims; infinite where a number is none that can be."""
        self.weigh(state)
        return total(self.losses(state)) if np.isfinite(self.loss(state)) else np.inf

    def pays(self, before: State, after: State, clear: float) -> bool:
        """True if `after` predicts the other halves clearly better than `before`, and by a part worth telling."""
        clearly = falls_clearly(self.losses(before), self.losses(after), self.rules, clear)
        return clearly and bool(np.isfinite(self.loss(after)))

    def curve(self, joint: str | None) -> State:
        """A curve as claims of all recordings together, one for each spline; none where `joint` is no joint."""
        names = self.now.model.joint_names
        if joint in self.curves or joint not in names:
            return self.curves.get(joint, ())
        place = names.index(joint)
        everywhere = replace(self.now, prepared=replace(self.now.prepared, train=self.now.prepared.all, verify=()))
        splines = splines_along(everywhere, f"dq{place + 1}", place, "sign", self.rules.knots)
        if splines is None:
            return ()
        claims = [Claim("curve", joint, "N·m", nothing, (-np.inf, np.inf)) for _ in range(splines.basis.shape[1])]
        self.take(claims, [columns.full(0, len(names)) for columns in splines.columns])
        self.curves[joint] = tuple(Claimed(claim, (), (tuple(range(len(self.rows))),)) for claim in claims)
        return self.curves[joint]

    def take(self, claims: Sequence[Claim], columns: Sequence[Float]) -> None:
        """Take in further claims, each with a piece of the `columns` (J, K, m) on the recordings; then weigh anew."""
        first = self.rows[0].shape[2] - 1
        for k, (rows, part, use) in enumerate(zip(self.rows, self.parts, self.use, strict=True)):
            own = columns[part.recording][:, part.kept] * use[:, :, None]
            self.rows[k] = np.concatenate([rows[:, :, :-1], own, rows[:, :, -1:]], axis=2)
        self.place |= {claim: slice(first + k, first + k + 1) for k, claim in enumerate(claims)}
        self.weighed, self.weighed_for = {}, None
