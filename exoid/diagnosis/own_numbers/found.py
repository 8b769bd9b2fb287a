"""The search for what belongs to recordings.

What every recording has (a zero) is tried first; then whatever lowers the loss most, with as many recordings as it
takes, again and again; and what is needless beside the rest is dropped. Where recordings then change midway they are
cut there, and the search goes on with their parts.
"""

from __future__ import annotations

from dataclasses import replace
from statistics import NormalDist

import numpy as np

from exoid.diagnosis.evidence.enough_motion import little_motion
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.own_numbers.changes import changes_of, sharpened
from exoid.diagnosis.own_numbers.compared import clearer, falls_clearly, total
from exoid.diagnosis.own_numbers.fits import Fits
from exoid.diagnosis.own_numbers.numbers import OwnNumbers, with_numbers
from exoid.diagnosis.own_numbers.state import UNCUT, Claimed, Cuts, State
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.ties import ascending, index_of_least, least_of

TRIED = 4
"""Claims that are looked at more closely in a round, those that promise most."""
WITHIN = 1e-3
"""Part of the distance between nodes to which the best place is found."""
WAYS = 2
"""Ways in which recordings are taken to differ at most: beyond, a machine's error has as many faces as motions."""
MOVED = 2
"""Times that recordings get the motion anew that was found: where friction reverses depends on clocks."""
MOVES, HALVINGS = 30, 6
"""Steps to it at most, and how often one that does not help is halved."""


def belonging_to(now: FittedModel, rules: Rules = RULES, changed: Cuts = UNCUT, ways: int = WAYS) -> OwnNumbers | None:
    """Numbers that belong to recordings, or to a part of them, beside a model, in so many `ways` beside zeros; None
    where none do.

    Recordings that `changed` are cut there first: what drives bear from then on bends other columns, too.
    """
    names = [item.name for item in now.prepared.all]
    if len(set(names)) < len(names) or len(names) > rules.own_recordings:
        return None
    fits = Fits(now, rules, {})
    held = _Search(fits, ways).found(())
    cuts: Cuts = {**changes_of(fits, held), **changed}
    if cuts:
        in_parts = Fits(now, rules, cuts)
        search = _Search(in_parts, ways)
        then = search.found(search.regrouped(in_parts.moved(fits, held)))
        if cuts := sharpened(in_parts, then):
            fits = Fits(now, rules, cuts)
            held = placed(fits, fits.moved(in_parts, then))
    own = with_numbers(fits, held) if held else None
    for _ in range(MOVED):
        if own is None or not (parts := own.moved):
            break
        known, fits = fits, Fits(now.on(own.on_motion(now.prepared)), rules, fits.cuts, parts)
        own = with_numbers(fits, _Search(fits).settled(fits.moved(known, own.held)))
    while own is not None and (clear := own.clear) != own.held:
        own = with_numbers(fits, clear) if clear else None
    return own


def placed(fits: Fits, state: State) -> State:
    """Claims that are known to hold, each at the node that fits best where the fit is weighted for them."""
    fits.weigh(state)
    return placed_anew(fits, state)


def placed_anew(fits: Fits, state: State) -> State:
    """Claims that are known to hold, each at the node that fits best where the fit is weighted already."""
    for item in state:
        others = tuple(other for other in state if other is not item)
        state = tuple(at_best_node(fits, others, other) if other is item else other for other in state)
    return state


def at_best_node(fits: Fits, rest: State, held: Claimed) -> Claimed:
    """Return a claim at the node that fits best beside the `rest`: among its own, then from there by Gauss-Newton steps
    with all numbers, none longer than the distance of nodes.
    """
    nodes = held.claim.nodes
    if len(nodes) < 2:
        return held
    best = least_of([replace(held, node=node) for node in nodes], lambda one: fits.loss((*rest, one)), 1.0)
    reach, squares = float(np.linalg.norm(np.diff(nodes[:2], axis=0))), fits.squares((*rest, best))
    for _ in range(MOVES):
        step = fits.place_step((*rest, best))
        step *= min(1.0, reach / max(float(np.linalg.norm(step)), 1e-300))
        for _ in range(HALVINGS):
            if np.linalg.norm(step) < WITHIN * reach:
                return best
            node = np.add(best.node, step)
            moved = replace(best, node=tuple((node if node.size > 1 else np.maximum(node, WITHIN * reach)).tolist()))
            if (reached := fits.squares((*rest, moved))) < squares:
                best, squares = moved, reached
                break
            step *= 0.5
    return best


class _Search:
    """The search among the claims of some fits."""

    def __init__(self, fits: Fits, ways: int = WAYS) -> None:
        self.fits, self.rules, self.many, self.ways = fits, fits.rules, len(fits.parts), ways
        # On little motion what single recordings have looks as real as any effect that is not there.
        little, cut = bool(little_motion(fits.now.prepared, self.rules)), bool(fits.cuts)
        self.claims = [
            claim for claim in fits.claims if claim.everyone or claim.common or not (little or (cut and claim.whole))
        ]
        self.all = (tuple(range(self.many)),)
        """The group of all parts."""
        questions = sum(1 if claim.everyone or claim.common else self.many for claim in self.claims)
        self.clear, self.clear_too = (
            max(self.rules.clear, NormalDist().inv_cdf(1.0 - self.rules.strict_level / asked))
            for asked in (questions, self.many)
        )
        """Standard errors by which one of so many claims is better, not by chance, and one recording more of one."""

    def found(self, state: State) -> State:
        """The claims that hold, of those that are held already and others."""
        while True:
            self.fits.weigh(state)
            if self.many > 1 and (more := self._of_everyone(state)) != state:
                state = more
                self.fits.weigh(state)
            if sum(not (held.claim.everyone or held.claim.common) for held in state) >= self.ways:
                break
            longer = self._longer(state)
            alike = [(*state, held) for held in self._common(state)]
            best = least_of([*alike, *longer], self.fits.weighed_loss, 1.0) if alike or longer else state
            # One number for all may explain as much, and so may the same on another link: a load at a pivot is on both.
            simpler = [least_of(alike, self.fits.weighed_loss, 1.0)] if alike and best not in alike else []
            alike_too = (item for item in longer if item[-1].claim.what == best[-1].claim.what)
            simpler += [item for item in alike_too if item[-1].count < best[-1].count]
            for simple in simpler:
                self.fits.weigh(best)
                if not self.fits.pays(simple, best, self.clear):
                    best = simple
                    break
            self.fits.weigh(best)
            if not self.fits.pays(state, best, self.clear) or self._is_the_machines(state, best[-1]):
                break
            state = best
        return self.settled(state)

    def settled(self, state: State) -> State:
        """The claims without those that are needless, each at the node that fits best; which recordings are usual is
        known only when all is found.
        """
        state = self._at_other_angles(state)
        self.fits.weigh(state)
        state = self._with_middles(placed_anew(self.fits, self._pruned(state)))
        turned = tuple(self._turned_round(tuple(other for other in state if other is not item), item) for item in state)
        return state if turned == state else placed(self.fits, turned)

    def _at_other_angles(self, state: State) -> State:
        """The claims with the zero of an encoder in place of those of torque sensors: of several where these explain no
        more, since it shifts the torques of all joints that weigh, and has one number; of one where they explain less.
        """
        rest = tuple(item for item in state if not item.claim.everyone)
        if len(rest) == len(state) or len(rest) >= self.ways:
            return state
        self.fits.weigh(rest)
        turning = [held for held, _ in self._promising(rest) if held.claim.turns is not None]
        turned = [(*rest, self._grown(rest, held)) for held in turning]
        if not turned:
            return state
        rival = least_of(turned, self.fits.weighed_loss, 1.0)
        self.fits.weigh(rival)
        if len(state) - len(rest) > 1:
            better = not self.fits.pays(rival, state, self.clear)
        else:
            better = total(self.fits.losses(rival)) < total(self.fits.losses(state))
        return rival if better and np.isfinite(self.fits.loss(rival)) else state

    def _of_everyone(self, state: State) -> State:
        """The state with whatever pays of what every recording has. What one joint's zeros leave hides those
        of another: they are asked again as long as there are more.
        """
        before: State | None = None
        while state != before:
            before = state
            for claim in self.claims:
                if claim.everyone and all(item.claim is not claim for item in state):
                    own = Claimed(claim, claim.nodes[0], self.fits.everyone)
                    if self.fits.pays(self._needless(state, own), (*state, own), self.clear):
                        state = (*state, own)
        return state

    def regrouped(self, state: State) -> State:
        """The same claims with those parts of recordings that have them, where whole recordings had them before."""
        for item in state:
            rest = tuple(other for other in state if other is not item)
            own = item.claim.everyone or item.claim.common or item.claim.whole
            state = state if own else (*rest, self._grown(rest, item))
        return state

    def _is_the_machines(self, rest: State, held: Claimed) -> bool:
        """True if what all recordings may have alike explains what a claim does: one curve in its joint's velocity, as
        where each recording has a speed of its own friction that depends on speed looks like friction that differs, to
        which the claim adds nothing; or what the claim is `unlike`, which it does not beat.
        """
        fits, alike = self.fits, [claim for claim in self.fits.claims if claim.what == held.claim.unlike]
        unlike = tuple(Claimed(claim, claim.nodes[0], self.all) for claim in alike)
        if curve := fits.curve(held.claim.place):
            fits.weigh((*rest, held))
            explains = total(fits.losses((*rest, *curve))) < total(fits.losses(rest))
            if explains and not fits.pays((*rest, *curve), (*rest, *curve, held), self.clear):
                return True
        if not unlike:
            return False
        fits.weigh((*rest, *unlike))  # each where the fit is weighted for it: of clocks columns bend with the number
        once, without = fits.losses((*rest, *unlike)), fits.losses(rest)
        fits.weigh((*rest, held))
        beaten = falls_clearly(once, fits.losses((*rest, held)), self.rules, self.clear)
        return total(once) < total(without) and not (beaten and bool(np.isfinite(fits.loss((*rest, held)))))

    def _common(self, state: State) -> list[Claimed]:
        """The claims that are not held of which all recordings have the same number, where that can be."""
        taken = {held.claim for held in state}
        free = [Claimed(c, c.nodes[0], self.all) for c in self.claims if c.common and c not in taken]
        most = (1.0 - self.rules.least_share) * self.fits.loss(state)
        return [item for item in free if self.fits.loss((*state, item)) <= most]

    def _longer(self, state: State) -> list[State]:
        """The claims with one more, each of those that promise most, unless another explains far more than that could:
        only how late a clock is shows step by step.
        """
        longer, now, explained = [], self.fits.loss(state), 0.0
        for held, most in self._promising(state):
            if held.claim.moves or most >= self.rules.half * explained:
                longer.append((*state, self._grown(state, held)))
                self.fits.weigh(state)
                explained = max(explained, now - self.fits.loss(longer[-1]))
        return longer

    def _promising(self, state: State) -> list[tuple[Claimed, float]]:
        """The most promising recording and node of claims that are not held, with what each could explain at most: the
        best few, and the best of each hypothesis.
        """
        taken = {held.claim for held in state}
        free = [item for item in self.claims if not (item.everyone or item.common or item in taken)]
        if self.many < 2 or not free:
            return []
        self.fits.ask_all()
        nodes = [(claim, node) for claim in free for node in claim.nodes]
        mixed = np.zeros((self.fits.rows[0].shape[2], len(nodes)))
        for c, (claim, node) in enumerate(nodes):
            mixed[self.fits.place[claim], c] = claim.mix(node)
        low, high = np.array([claim.bounds for claim, _ in nodes]).T
        # What one recording has less of all others have more of, where the model's own numbers hold what all have.
        low = np.where([claim.shared for claim, _ in nodes], -high, low)
        whole = self.fits.sums(state).sum(axis=0)
        columns = self.fits.grams @ mixed
        products = np.swapaxes(self.fits.chosen(state), 1, 2)[:, None] @ columns
        squares = np.sum(mixed * columns, axis=2)
        now = 0.0
        losses, numbers = np.zeros((2, self.many, len(nodes)))
        for own, other in ((0, 1), (1, 0)):
            step, inverse = self.fits.solved(whole[own])
            both = np.append(-step, 1.0)
            now += float(both @ whole[other] @ both)
            by_model, by_left, square = products[:, own, :-1], products[:, own, -1], squares[:, own]
            lean = inverse @ by_model
            power = square - np.sum(by_model * lean, axis=1)
            seen = power > self.rules.negligible * square
            number = np.where(seen, (by_left - step @ by_model) / np.where(seen, power, 1.0), 0.0)
            moved = np.insert(lean * number[:, None] - step[:, None], len(step), 1.0, axis=1)
            left = np.sum(moved * (whole[other] @ moved), axis=1)
            left += number**2 * squares[:, other] - 2.0 * number * np.sum(moved * products[:, other], axis=1)
            numbers += number
            losses += np.where((low <= number) & (number <= high), left, np.inf)
        best: list[tuple[float, Claimed, float]] = []
        for claim in free:
            mine = [c for c, (element, _) in enumerate(nodes) if element is claim]
            # What all explain that differ is no more than what each explains alone: the model is between them.
            alone = float(np.maximum(now - losses[:, mine].min(axis=1), 0.0).sum())
            if alone < self.rules.worth_telling * now and not claim.bends:
                continue
            k, c = divmod(index_of_least(losses[:, mine].ravel()), len(mine))
            less = claim.shared and numbers[k, mine[c]] < 0.0
            group = tuple(j for j in range(self.many) if (j == k) != less)
            best.append((float(losses[k, mine[c]]), Claimed(claim, claim.nodes[c], (group,)), alone))
        useful = [entry for entry in best if entry[0] <= (1.0 - self.rules.least_share) * now]
        ordered = [(held, most) for _, held, most in ascending(useful, lambda one: one[0], 1.0)]
        kinds = [held.claim.what for held, _ in ordered]
        return [entry for k, entry in enumerate(ordered) if k < TRIED or kinds[k] not in kinds[:k]]

    def _grown(self, state: State, held: Claimed) -> Claimed:
        """A claim with as many recordings as clearly have it, and no more. No choice of them is asked about twice: the
        weights change, and the best one might turn in circles.
        """
        held, tried = at_best_node(self.fits, state, held), {held.groups}
        while True:
            now, best = self.fits.weighed_loss((*state, held)), held
            others = [other for other in self._others(held) if other.groups not in tried]
            tried.update(other.groups for other in others)
            for more in (False, True):
                if some := [other for other in others if (len(other.groups) > len(held.groups)) == more]:
                    rival = least_of(some, lambda one: self.fits.loss((*state, one)), 1.0)
                    rival = at_best_node(self.fits, state, rival)
                    if self._is_worth((*state, best), (*state, rival), more=more):
                        best = rival
            if best is held or not self.fits.weighed_loss((*state, best)) < now:
                break
            held = best
        return held if held.claim.shared else self._fewest(state, held)

    def _is_worth(self, before: State, after: State, *, more: bool) -> bool:
        """True if the last claim is worth `more` numbers; a recording more that shares one costs none: what fits better
        is as likely as it fits.
        """
        if more and after[-1].claim.shared:
            return self.fits.pays(before, after, self.clear)
        once, then = self.fits.losses(before), self.fits.losses(after)
        return clearer(once, then) >= (self.clear_too if more else 0.0)

    def _fewest(self, state: State, held: Claimed) -> Claimed:
        """A claim without recordings that need no number, or turned to those that have none where these are fewer."""
        while len(held.groups) > 1:
            self.fits.weigh((*state, held))
            shorter = [tuple(group for group in held.groups if group is not out) for out in held.groups]
            other = self._others(held)[-1].groups
            tried = [replace(held, groups=item) for item in (*shorter, other) if len(item) < len(held.groups)]
            best = least_of(tried, lambda one: self.fits.loss((*state, one)), 1.0)
            once, then = self.fits.losses((*state, best)), self.fits.losses((*state, held))
            if not np.isfinite(self.fits.loss((*state, best))) or clearer(once, then) >= self.rules.clear:
                break
            held = best
        return held

    def _turned_round(self, state: State, held: Claimed) -> Claimed:
        """A claim, turned to those recordings that have no number where these are fewer and it predicts no worse so."""
        if held.claim.everyone or held.claim.common or held.claim.shared:
            return held
        other = self._others(held)[-1]
        if len(other.groups) >= len(held.groups) or not np.isfinite(self.fits.loss((*state, other))):
            return held
        now, then = (total(self.fits.losses((*state, item))) for item in (held, other))
        return other if then <= now else held

    def _others(self, held: Claimed) -> list[Claimed]:
        """A claim with one recording more, which has a number of its own; of a number that may be shared also one that
        does, and with one recording less; of others also with both parts of a recording together and, last, the
        recordings that have none in place of those that have. One recording at least says what is usual.
        """
        inside = {k for group in held.groups for k in group}
        outside = tuple((k,) for k in range(self.many) if k not in inside)
        tried = [tuple(sorted((*held.groups, item))) for item in outside]
        if held.claim.shared:
            for group in held.groups:
                rest = tuple(other for other in held.groups if other is not group)
                joined = [tuple(sorted((*group, *item))) for item in outside]
                fewer = [tuple(k for k in group if k != out) for out in group if len(group) > 1]
                tried += [tuple(sorted((*rest, item))) for item in (*joined, *fewer)]
        else:
            for parts in self.fits.everyone:
                own = [group for group in held.groups if group != parts and set(group) <= set(parts)]
                others = (group for group in held.groups if group not in own)
                tried += [tuple(sorted((*others, parts)))] if own else []
            tried.append(outside)
        return [replace(held, groups=groups) for groups in tried if sum(map(len, groups)) < self.many]

    def _pruned(self, state: State) -> State:
        """The claims that are not needless beside the others; of motions that recordings were given, little is left."""
        given = any(part.known for part in self.fits.parts)
        while len(state) > 1 and (asked := [item for item in state if not (given and item.claim.of_motion)]):
            rivals = [self._needless(tuple(item for item in state if item is not out), out) for out in asked]
            best = index_of_least([total(self.fits.losses(rival)) for rival in rivals])
            if self.fits.pays(rivals[best], state, self.clear):
                break
            state = rivals[best]
        return state

    def _with_middles(self, state: State) -> State:
        """The claims, with the zero that all recordings have where a further column is as in the middle: only so is one
        known that goes with the column.
        """
        known = {held.claim for held in state}
        places = {held.claim.place for held in state if held.claim.common and not held.claim.factor}
        zeros = [claim for claim in self.fits.claims if claim.everyone and claim.place in places and claim not in known]
        return (*state, *(Claimed(claim, claim.nodes[0], self.all) for claim in zeros))

    def _needless(self, rest: State, held: Claimed) -> State:
        """Claims that explain as much where a claim is needless: the others; beside a zero that is the same in all
        recordings what was another number until a change is one from there on.
        """
        if not held.claim.everyone:
            return placed_anew(self.fits, rest)
        alike = (held.claim.what, held.claim.place)
        turned = tuple(self._turned(item) if (item.claim.what, item.claim.place) == alike else item for item in rest)
        rivals = [placed_anew(self.fits, some) for some in dict.fromkeys((rest, turned))]
        return least_of(rivals, self.fits.loss, 1.0)

    def _turned(self, held: Claimed) -> Claimed:
        """The same of the other parts of its recordings."""
        other = {a: b for parts in self.fits.everyone for a, b in zip(parts, reversed(parts), strict=True)}
        return replace(held, groups=tuple(tuple(other[j] for j in group) for group in held.groups))
