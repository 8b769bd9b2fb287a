"""The answer beside numbers that belong to recordings, a zero or a load of their own: a rival of the answer without."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel, fitted_on, refitted, shapes_from
from exoid.diagnosis.evidence.model_error import is_near_noise
from exoid.diagnosis.machine_answer import Asking, answer_of_machine
from exoid.diagnosis.own_numbers.changes import least_left
from exoid.diagnosis.own_numbers.compared import explained_by, predicts_better
from exoid.diagnosis.own_numbers.found import WAYS, belonging_to
from exoid.diagnosis.own_numbers.numbers import OwnNumbers
from exoid.diagnosis.own_numbers.state import UNCUT, Cuts
from exoid.diagnosis.question import Question
from exoid.diagnosis.results import Diagnosis
from exoid.diagnosis.rules import Rules
from exoid.diagnosis.write_up import with_own
from exoid.ground.progress import silent
from exoid.ground.ties import ascending, least_of
from exoid.optimisation.preparation.prepare import Prepared

ROUNDS = 4
"""Times at most that what belongs to recordings is looked for beside what was found with it."""
PLAIN = 2
"""What an answer may name at most to be taken without looking for a plainer one."""
NEAREST = 3
"""Entries of the catalogue, those that explain most alone, that are compared with what belongs to recordings."""
OTHERS_TOO = " So many differences at once may also be those of another machine."
MORE_TOO = " More than noise is left beside that: such numbers may also stand for what the model lacks."


def answer_beside_recordings(asking: Asking, base: FittedModel, answer: Diagnosis) -> Diagnosis | None:
    """Return the plainest answer beside what belongs to recordings that leaves about the noise; None for none."""
    doubted, answer = answer.inside is not None, answer.inside or answer
    whole = fitted_on(answer.fit, base.prepared)
    against = _Against(asking, base, answer, _common(whole, _names(answer)), whole)
    near: list[Diagnosis] = []
    far: list[Diagnosis] = []
    for own, ways in against.promising():
        if (rival := against.answer_beside(own, ways)) is not None:
            (far if _leaves_more(rival) else near).append(rival)
        if near and _statements(near[-1], len(base.prepared.all)) <= PLAIN:
            break
    if near:
        return least_of(near, _numbers)
    return far[0] if far and not doubted else None


@dataclass(frozen=True, eq=False)
class _Against:
    """Rivals of numbers of recordings: an `answer` and its model (`whole`), and that without numbers that each
    recording has (`last`). `base` is the model that was given.
    """

    asking: Asking
    base: FittedModel
    answer: Diagnosis
    last: FittedModel
    whole: FittedModel

    @property
    def rules(self) -> Rules:
        """The thresholds that decide."""
        return self.asking.question.rules

    @cached_property
    def machines(self) -> list[tuple[float, FittedModel]]:
        """The last model, and that with each entry nearest to what it leaves, with the share each explains."""
        models = _plain_models(self.asking.question, self.answer, self.last)
        return [(explained_by(self.last, machine), machine) for machine in models]

    @property
    def near(self) -> bool:
        """True if numbers of recordings may be hidden by one of the nearest entries, and that by them."""
        return len(self.base.prepared.all) > 1 and _leaves_more(self.answer)

    @cached_property
    def bounds(self) -> list[tuple[float, FittedModel]]:
        """Machines with the error that numbers of recordings could leave at least, as a multiple of the noise."""
        return [(float(np.max(least_left(machine))), machine) for _, machine in self.machines]

    @property
    def least_bound(self) -> float:
        """The bound up to which a machine with an entry is asked: near the noise, and less than without the entry."""
        return min(self.rules.near_noise, (1.0 - self.rules.worth_telling) * self.bounds[0][0])

    @property
    def ways(self) -> int:
        """Ways in which recordings may differ beside zeros: one where they leave more than noise anyhow."""
        return WAYS if not self.near or min(left for left, _ in self.bounds) <= self.rules.near_noise else 1

    def promising(self) -> Iterator[tuple[OwnNumbers, int]]:
        """Yield what may belong to recordings: beside the model as given, since an effect may be its trace, and beside
        the answer; where that leaves more than noise, beside one of the nearest entries of the catalogue with which it
        does not: each hides the other as long as it is missing. With each, in how many ways they may differ; where
        several leave more than noise, zeros stay.
        """
        found = _belonging_beside(self.last, self.rules, ways=self.ways)
        if found is None and not self.near:
            return
        alone = found if self.last.fit is self.base.fit else belonging_to(self.base, self.rules, ways=self.ways)
        given = self.base.prepared
        for own in dict.fromkeys((alone, found)):
            beside = None if own is None else own.beside(self.last, given)
            if own and beside and self.is_worth(own, beside) and self.may_stand(own, beside):
                yield own, self.ways
        for left, machine in ascending(self.bounds[1:] if self.near else (), lambda pair: pair[0], 1.0):
            own = _belonging_beside(machine, self.rules) if left <= self.least_bound else None
            if own is not None and is_near_noise(own.beside(machine, given), self.rules):
                yield own, self.ways
        zeros = _belonging_beside(self.last, self.rules, ways=0) if self.near and self.ways > 1 else None
        if zeros is not None and self.is_worth(zeros, zeros.beside(self.last, given)):
            yield zeros, 0

    def is_worth(self, own: OwnNumbers, beside: FittedModel) -> bool:
        """True if a model `beside` such numbers predicts clearly better, and than one with an effect nearly as good."""
        share = explained_by(self.last, beside)
        if self.last is not self.whole and share < self.rules.practically * explained_by(self.last, self.whole):
            return False
        return predicts_better(self.last, beside, self.rules, own.cuts) and all(
            alone < self.rules.most * share
            or predicts_better(machine, own.beside(machine, self.base.prepared), self.rules, own.cuts)
            for alone, machine in self.machines
        )

    def may_stand(self, own: OwnNumbers, beside: FittedModel) -> bool:
        """True if an answer with such numbers may stand in place of this one: where recordings differ in several ways,
        as a machine's error does from motion to motion, only if they are the main explanation or leave about the noise.
        """
        if len(own.ways) < 2 or self.is_main(own, beside) or is_near_noise(beside, self.rules):
            return True
        return is_near_noise(own.beside(self.base, self.base.prepared), self.rules)

    def is_main(self, own: OwnNumbers, beside: FittedModel) -> bool:
        """True if ways in which recordings differ explain most of what the last model leaves, several nearly all."""
        least = self.rules.half if len(own.ways) == 1 else self.rules.most
        return bool(own.ways) and explained_by(self.last, beside) >= least

    def answer_beside(self, own: OwnNumbers, ways: int) -> Diagnosis | None:
        """Return the answer beside numbers of recordings; None where it may not stand in place of the other."""
        rival, explained, own = _with_own(self.asking, self.base.prepared, own, ways)
        told = own.without([entry.recording for entry in rival.left_out])
        main = self.is_main(own, explained)
        may = told and self._leaves_as_little(rival) and _may_replace(self.answer, rival, own, main=main)
        if not may or not self.is_worth(own, explained):
            return None
        more = _leaves_more(rival)
        caution = OTHERS_TOO if own.as_many_as(self.rules.half) or (more and len(own.ways) >= WAYS) else ""
        caution += MORE_TOO if more else ""
        return with_own(rival, told, self.base, caution)

    def _leaves_as_little(self, rival: Diagnosis) -> bool:
        """True if a rival explains the others as well as an answer that leaves recordings out."""
        left, least = (item.steps[-1].evaluation_rms for item in (rival, self.answer))
        return not self.answer.left_out or bool(np.all(left <= self.rules.artefact * least))


def _statements(answer: Diagnosis, many: int) -> int:
    """Count of what an answer names: effects, what each of so `many` recordings has, and each number of only some."""
    own = answer.of_recordings
    some = {(s.what, s.joint, e.value) for s in own if len(s.values) < many for e in s.values.values()}
    return len({s.what for s in own if len(s.values) == many}) + len(some) + len(answer.accepted)


def _numbers(answer: Diagnosis) -> int:
    """Count of the numbers of an answer: of several that leave no more than noise the plainest is the likeliest."""
    own = sum(len(statement.values) for statement in answer.of_recordings)
    return own + sum(len(effect.parameters) for effect in answer.accepted)


def _common(whole: FittedModel, found: Collection[str]) -> FittedModel:
    """Return a model without numbers that each recording has, refitted: a term that was `found` with such, as a delay,
    may be what belongs to some, and places that differ may be its trace.
    """
    kept = [term for term in whole.model.terms if term.name not in found or not term.effect.has_own_numbers]
    moving = [term for term in kept if term.own_places and term.name in found]
    if not moving and len(kept) == len(whole.model.terms):
        return whole
    terms = tuple(replace(term, own_places=False) if term in moving else term for term in kept)
    return refitted(replace(whole.model, terms=terms), whole, whole.prepared)


def _may_replace(answer: Diagnosis, rival: Diagnosis, own: OwnNumbers, *, main: bool) -> bool:
    """True if a `rival` beside numbers of recordings may stand in place of an answer without; where more than noise is
    left beside these, only of one that leaves more, too, or has the same effects, and where they are the `main`
    explanation, or zeros, which are usual, and both.
    """
    if rival.verdict == "check_channels" or rival.outside:
        return False
    if _leaves_more(rival):
        kept, also = _names(answer) <= _names(rival), _leaves_more(answer)
        return (kept or also) if main else (kept and also and not own.ways)
    # What is another machine's is explained by as many numbers as a machine has.
    return answer.error is not None or not own.of_a_machine(answer.left_out)


def _names(answer: Diagnosis) -> frozenset[str]:
    """Names of the effects of an answer."""
    return frozenset(effect.name for effect in answer.accepted)


def _leaves_more(answer: Diagnosis) -> bool:
    """True if a machine's answer leaves more than noise, or what follows a variable."""
    return not answer.outside and (answer.verdict == "unexplained" or bool(answer.more_missing))


def _with_own(asking: Asking, given: Prepared, own: OwnNumbers, ways: int) -> tuple[Diagnosis, FittedModel, OwnNumbers]:
    """Return the answer beside numbers of recordings in so many `ways`, its model, and the numbers as found there."""
    kept = None
    for turn in range(ROUNDS):
        again, without = replace(asking, question=replace(asking.question, own=own)), own.applied(given)
        rival = answer_of_machine(again, again.fitted(without))
        worse = rival.verdict == "check_channels" or _leaves_more(rival)
        if kept is not None and worse and not _leaves_more(kept[0]):
            return *kept[:2], own if own.by_recording.keys() == kept[2].by_recording.keys() else kept[2]
        kept = rival, fitted_on(rival.fit, without), own
        last = fitted_on(_common(kept[1], _names(rival)).fit, own.carried(given))
        # Friction that grows with the load did not feel yet what is carried.
        unfelt = not turn and last.model.needs_reference and any(held.claim.borne for held in own.held)
        if own.now.model.effects == last.model.effects and not (own.needless or unfelt):
            return kept  # beside these it was found
        own = _belonging_beside(last, asking.question.rules, own.cuts, ways) or own
        if kept[2].agrees(own) and not own.needless:
            return *kept[:2], own
        if turn and _leaves_more(rival):  # beside that, numbers need not come to rest
            break
    assert kept is not None
    return kept


def _belonging_beside(last: FittedModel, rules: Rules, changed: Cuts = UNCUT, ways: int = WAYS) -> OwnNumbers | None:
    """Numbers that belong to recordings, some of which `changed`, beside a model that was found, without its effects
    that do no more than these, which stay `needless`.
    """
    own = belonging_to(last, rules, changed, ways)
    if own is None or not own.needless:
        return own
    without = belonging_to(refitted(last.model.without(*own.needless), last, last.prepared), rules, changed, ways)
    return without and replace(without, needless=own.needless)


def _plain_models(question: Question, answer: Diagnosis, last: FittedModel) -> Iterator[FittedModel]:
    """Yield the `last` model, that of an answer, then with each of the entries that come nearest to what it leaves,
    fitted to all recordings: a number of a recording's own has seen a part of that recording, too, held out or not.
    What has such numbers itself, as a drift that began at another time in each, is no plainer.
    """
    given, least = last.prepared, question.rules.worth_telling
    everything = replace(given, train=given.all, verify=())
    context = question.context(everything, everything, silent)
    start = context.fit(last.model, shapes_from(last, last.model, len(given.all)))
    yield fitted_on(start.fitted.fit, given)
    absent = (suspect for suspect in answer.suspects if suspect.name not in last.model.effects)
    near = [suspect for suspect in absent if suspect.explained_share >= least]
    known = {candidate.name: candidate for candidate in context.library.candidates}
    plain = [suspect for suspect in near if not known[suspect.name].term.effect.has_own_numbers]
    nearest = ascending(plain, lambda suspect: -suspect.explained_share, 1.0)[:NEAREST]
    for suspect in nearest:
        score = context.weighed(start, context.evidence(start, draws=0), known[suspect.name])
        yield _common(fitted_on(context.with_term(start, score).fitted.fit, given), [suspect.name])
