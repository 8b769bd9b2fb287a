"""Compare, diagnose, add, and again, until nothing that helps on unseen motion is left (`search`), and say so."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Unpack

import numpy as np

from exoid.diagnosis.evidence.agreement import Agreement
from exoid.diagnosis.evidence.apart import OTHERS, left_out, odd_ones
from exoid.diagnosis.evidence.channels import doubts_after
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model
from exoid.diagnosis.evidence.own_sway import own_sway
from exoid.diagnosis.evidence.soft_drive import soft_drive
from exoid.diagnosis.evidence.timing import FilterOnTorque, filtered
from exoid.diagnosis.own_numbers.compared import explained_by, predicts_better
from exoid.diagnosis.own_numbers.found import belonging_to
from exoid.diagnosis.own_numbers.numbers import OwnNumbers
from exoid.diagnosis.question import Question, Searched
from exoid.diagnosis.readings import is_reading, reading_doubt, reading_said
from exoid.diagnosis.results import Accepted, Diagnosis, Possible, Step
from exoid.diagnosis.rules import Rules
from exoid.diagnosis.search.context import SearchContext
from exoid.diagnosis.search.doubt import DELAY, idle_terms
from exoid.diagnosis.search.possible import agreements_of, leading_of, possible_of
from exoid.diagnosis.search.state import Extension, State
from exoid.diagnosis.settings import ALL, DiagnosisOptions, DiagnosisSettings, DiscoveryOptions, DiscoverySettings
from exoid.diagnosis.splits import from_scratch
from exoid.diagnosis.verdict import Conclusion, behind, conclude, doubted, swayed
from exoid.diagnosis.write_up import accepted_of, possible_beside, possible_with, with_own, write_up
from exoid.ground.progress import Progress, silent
from exoid.ground.ties import ascending
from exoid.measurement.forces import pushed_model
from exoid.measurement.reading.conventions import read_as
from exoid.measurement.reading.given import Given, question_of
from exoid.measurement.recording import Recording
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.model import Model

ROUNDS = 2
"""Times that what belongs to recordings is looked for beside what was found with it."""
NEAREST = 3
"""Entries of the catalogue, those that explain most alone, that are compared with what belongs to recordings."""
OTHERS_TOO = " So many differences at once may also be those of another machine."
MORE_TOO = " More than noise is left beside that: such numbers may also stand for what the model lacks."


def discover(
    model: Model | Fit | Given | None = None,
    recordings: Given | None = None,
    verify: Given = (),
    settings: DiscoverySettings | None = None,
    *,
    progress: Progress | None = None,
    **changes: Unpack[DiscoveryOptions],
) -> Diagnosis:
    """Find which effects `model` (or the model of a Fit) is missing and add them.

    `verify` are recordings that are never fitted and must improve. The user's own effects that the model declares
    (`[[custom_effects]]` of its file) are suspected as those of the catalogue are. Recordings are what
    `exoid.measurement.reading.given` takes: recordings, paths, tables, one or many; alone they are of the standard
    leg. Refuses those that are too short,
    too slow or do not determine the model.
    """
    asked, recordings, verify = question_of(model, recordings, verify)
    machine = pushed_model(asked.model if isinstance(asked, Fit) else asked, (*recordings, *verify))
    question = Question(machine, DiscoverySettings.chosen(settings, changes))
    return answer_of(question, recordings, verify, progress or silent)


def answer_of(
    question: Question,
    recordings: Sequence[Recording],
    verify: Sequence[Recording],
    tick: Progress = silent,
    prepared: Prepared | None = None,
    found: Callable[[Sequence[Step]], None] | None = None,
) -> Diagnosis:
    """Answer of `discover`; `prepared` are the recordings where they are prepared already, `found` is called
    with the steps so far whenever the search has another one.

    What belongs to recordings (a zero of their own, a load) is a rival explanation of what the best model leaves: where
    it predicts clearly better, the answer is that beside it.
    """
    asking = _Asking(question, tick, found, time.perf_counter())
    base = question.fitted(recordings, verify, tick, prepared)
    answer = _of_machine(asking, base, recordings, verify)
    rival = None if base.prepared.misread else _beside_own(asking, base, answer, recordings, verify)
    return rival or answer


@dataclass(frozen=True, eq=False)
class _Asking:
    """A question, where its progress is told, what hears of every step of the search, and when it began."""

    question: Question
    tick: Progress
    found: Callable[[Sequence[Step]], None] | None
    began: float

    def part(self, low: float, high: float) -> _Asking:
        """The same, whose progress goes from `low` to `high`."""
        return replace(self, tick=_part(self.tick, low, high))


def _beside_own(
    asking: _Asking, base: FittedModel, answer: Diagnosis, recordings: Sequence[Recording], verify: Sequence[Recording]
) -> Diagnosis | None:
    """Return an answer beside what belongs to recordings; None where that does not predict clearly better."""
    question, given, rules = asking.question, base.prepared, asking.question.rules
    whole = _on(answer.fit, given)
    # An effect that was found and of which each recording has a number, as a delay, may be what belongs to some.
    own_too = [effect.name for effect in answer.accepted if answer.model.find_effect(effect.effect).has_own_numbers]
    last = _on(identify(answer.model.without(*own_too), given.train, optimisers=()), given) if own_too else whole
    found = _belonging_beside(last, rules)
    if found is None:
        return None
    machines = [(explained_by(last, machine), machine) for machine in _of_machine_alone(question, answer, last)]

    def is_worth(own: OwnNumbers, beside: FittedModel) -> bool:
        """True if they predict clearly better, beside an effect of the machine that explains nearly as much, too."""
        if own_too and explained_by(last, beside) < rules.practically * explained_by(last, whole):
            return False
        least = rules.most * explained_by(last, beside)
        return predicts_better(last, beside, rules, own.cuts) and all(
            share < least or predicts_better(machine, own.beside(machine.model, given), rules, own.cuts)
            for share, machine in machines
        )

    # What belongs to recordings beside the model as given may be what an effect took the place of, or its trace.
    alone = found if last.fit is base.fit else belonging_to(base, rules)
    asked = [own for own in dict.fromkeys((alone, found)) if own is not None]
    own = next((own for own in asked if is_worth(own, own.beside(last.model, given))), None)
    if own is None:
        return None
    rival, explained, own = _with_own(asking, given, own, recordings, verify)
    told = own.without([entry.recording for entry in rival.left_out])
    main = explained_by(last, explained) >= rules.half
    if not told or not _may_replace(answer, rival, own, main=main) or not is_worth(own, explained):
        return None
    caution = OTHERS_TOO if own.as_many_as(rules.half) else ""
    caution += MORE_TOO if rival.error is not None else ""
    return with_own(rival, told, base, caution)


def _may_replace(answer: Diagnosis, rival: Diagnosis, own: OwnNumbers, *, main: bool) -> bool:
    """True if a `rival` beside numbers of recordings may stand in place of an answer without; where more than noise is
    left beside these, only of one that leaves more, too, and of no effect unless they are the `main` explanation.
    """
    if rival.verdict == "check_channels" or rival.outside:
        return False
    if _leaves_more(rival):
        return _leaves_more(answer) and (main or bool(rival.accepted) or not answer.accepted)
    # What is another machine's is explained by as many numbers as a machine has.
    return answer.error is not None or not own.of_a_machine(answer.left_out)


def _leaves_more(answer: Diagnosis) -> bool:
    """True if a machine's answer leaves more than noise, or what follows a variable."""
    return not answer.outside and (answer.error is not None or answer.verdict == "unexplained")


def _with_own(
    asking: _Asking, given: Prepared, own: OwnNumbers, recordings: Sequence[Recording], verify: Sequence[Recording]
) -> tuple[Diagnosis, FittedModel, OwnNumbers]:
    """Return the answer beside numbers that belong to recordings, its model there, and these as they are beside it."""
    kept = None
    for _ in range(ROUNDS):
        again, without = replace(asking.question, own=own), own.applied(given)
        fitted = again.fitted(recordings, verify, asking.tick, without)
        rival = _of_machine(replace(asking, question=again), fitted, recordings, verify)
        if kept is not None and kept[0].verdict == "adequate" and rival.verdict != "adequate":
            break
        kept = rival, _on(rival.fit, without), own
        own = _belonging_beside(_on(rival.fit, given), again.rules) or own
        if own.agrees(kept[2]) and not own.needless:
            return *kept[:2], own
    assert kept is not None
    return kept


def _belonging_beside(last: FittedModel, rules: Rules) -> OwnNumbers | None:
    """Numbers that belong to recordings beside a model that was found, without its effects that do no more than these,
    which stay `needless`.
    """
    own = belonging_to(last, rules)
    if own is None or not own.needless:
        return own
    model, prepared = last.model.without(*own.needless), last.prepared
    without = belonging_to(_on(identify(model, prepared.train, optimisers=()), prepared), rules)
    return without and replace(without, needless=own.needless)


def _of_machine_alone(question: Question, answer: Diagnosis, last: FittedModel) -> Iterator[FittedModel]:
    """Yield the `last` model, that of an answer, then with each of the entries that come nearest to what it leaves,
    fitted to all recordings: a number of a recording's own has seen a part of that recording, too, held out or not.
    What has such numbers itself, as a drift that began at another time in each, is no plainer.
    """
    found, given, least = last.model, last.prepared, question.rules.worth_telling
    names = [term.name for term in found.terms]
    own = {effect.id: effect for effect in question.entries(given)}  # the model alone does not know these
    near = [
        (suspect, own.get(suspect.effect) or found.find_effect(suspect.effect))
        for suspect in answer.suspects
        if suspect.name not in names and suspect.explained_share >= least
    ]
    plain = [pair for pair in near if not pair[1].has_own_numbers]
    nearest = ascending(plain, lambda pair: -pair[0].explained_share, 1.0)[:NEAREST]
    for model in (found, *(found.with_effect(effect, suspect.joint) for suspect, effect in nearest)):
        yield _on(identify(model, given.all, optimisers=()), given)


def _on(fit: Fit, prepared: Prepared) -> FittedModel:
    """Return a model on all recordings, whichever of them it was fitted to."""
    return fitted_model(_as_of(fit, prepared), prepared)


def _as_of(fit: Fit, prepared: Prepared) -> Fit:
    """Return a fit to other recordings, or to stretches, as one of these: with the same shape values in each."""
    if len(fit.shapes) == len(prepared.train):
        return fit
    return replace(fit, shapes=np.broadcast_to(fit.shape, (len(prepared.train), len(fit.shape))))


def _of_machine(
    asking: _Asking, base: FittedModel, recordings: Sequence[Recording], verify: Sequence[Recording]
) -> Diagnosis:
    """Return the answer of these recordings, to which `base` is fitted; those that are not of what the others are of
    are left out, and the others are answered.
    """
    question = asking.question
    odd = odd_ones(base, question.rules) if len(base.prepared.all) > OTHERS else ()
    fitted = [recording for k, recording in enumerate(recordings) if k not in odd]
    held = [item for k, item in enumerate(verify, len(recordings)) if k not in odd]
    if not odd or not fitted or (verify and not held):
        return _answer(asking, base, recordings, verify)
    half = asking.part(0.0, 0.5)
    of_others = _answer(half, question.fitted(fitted, held, half.tick), fitted, held)
    apart, explained = left_out(base, of_others.fit, odd, question.rules)
    sentence = " ".join([of_others.sentence, *(f"{item.sentence}." for item in apart.values())])
    without = replace(of_others, sentence=sentence, left_out=tuple(apart.values()))
    if apart and of_others.accepted:
        return without
    whole = _answer(asking.part(0.5, 1.0), base, recordings, verify)
    if not apart or whole.accepted or of_others.verdict != "adequate":
        return whole
    # An effect that these alone show is one of the machine, unless numbers of their own explain far more.
    nearest = max((entry.explained_share for entry in whole.possible), default=0.0)
    return whole if nearest > max(question.rules.worth_telling, question.rules.half * explained) else without


def _answer(
    asking: _Asking, base: FittedModel, recordings: Sequence[Recording], verify: Sequence[Recording]
) -> Diagnosis:
    """Return the answer of all these recordings together, to which `base` is fitted."""
    question, tick = asking.question, asking.tick
    rules, splits = question.rules, question.asked.splits
    whole = _part(tick, 0.0, 0.5) if splits == ALL else tick

    def read(option: str) -> FittedModel:
        fitted, held = ([read_as(recording, option) for recording in group] for group in (recordings, verify))
        return question.fitted(fitted, held, whole)

    done = question.search(base, whole, asking.found, read)
    prepared, state = done.prepared, done.found.state

    def as_given(answer: Conclusion, possible: tuple[Possible, ...] = ()) -> Diagnosis:
        return write_up(done, (Extension(done.base),), (), None, possible, answer, asking.began)

    if done.answer is not None:
        return as_given(done.answer)
    extensions = state.extensions
    if wrong := next(filter(is_reading, state.names), None):
        return as_given(doubted(reading_doubt(extensions[-1].fitted.fit, wrong)))
    whole(0.95, "fitting what was found to the whole of the recordings")
    done, extensions = settle(done)
    state = done.found.state
    last = extensions[-1].fitted
    doubt = doubts_after(done.base, last, rules)
    if doubt is not None:
        return as_given(doubted(doubt))
    several = len(recordings) + len(verify) > 1
    agreements = agreements_of(done.context, state) if several else {}
    possible = possible_of(done.context, state, several)
    if splits == ALL and several:
        agreements, possible = from_scratch(question, recordings, verify, state.names, _part(tick, 0.5, 0.96))
    tick(0.97, "writing it down")
    # At the limit there may be more that the catalogue explains; nothing is called unexplained yet.
    left = None if len(extensions) > rules.most_terms else state.left
    accepted = _agreed(accepted_of(extensions, rules), agreements, done.context.prepared)
    if prepared.angles_were_filtered:
        accepted = tuple(replace(effect, doubted=True) for effect in accepted)
    soft = soft_drive(state.extensions[0].fitted, state.last.fitted, done.context.noise(state.last), rules)
    if soft is not None:
        return as_given(behind(soft, last.model.joints), possible_beside(soft, accepted, possible, rules))
    accepted = tuple(map(in_words, accepted))
    behind_filter = _filtered(done.context, state, rules)
    if behind_filter is not None and behind_filter.doubt is not None:
        return as_given(doubted(behind_filter.doubt))
    if behind_filter is not None:
        also = (behind_filter.name,)
        accepted = tuple(
            replace(a, look_alikes=(*a.look_alikes, *also), outside=(*a.outside, *also)) if a.effect == DELAY else a
            for a in accepted
        )
    sway = own_sway(state.last.fitted, done.context.noise(state.last), rules)
    if sway is not None:
        possible = possible_with(sway, possible, rules)
    first = () if accepted else done.found.first
    leading = leading_of(done.context, state, first, done.base.evaluation_rms)
    answer = conclude(accepted, left, done.base, last, bool(verify), len(recordings), rules, possible, leading)
    if sway is not None and not accepted:
        answer = swayed(sway, answer, last.model.joints)
    return write_up(done, extensions, accepted, left, possible, answer, asking.began, leading)


def _agreed(
    accepted: Sequence[Accepted], agreements: Mapping[str, Agreement], searched: Prepared
) -> tuple[Accepted, ...]:
    """Accepted effects, each with what splits of the recordings say of it."""
    names = [item.name for item in searched.all]
    pairs = [(effect, agreements.get(effect.name, Agreement())) for effect in accepted]
    return tuple(replace(entry, agreement=own, against=tuple(names[k] for k in own.against)) for entry, own in pairs)


def in_words(one: Accepted) -> Accepted:
    """The same accepted effect, with readings among its look-alikes named in words: no catalogue has them."""
    also = {name: reading_said(name) for name in one.look_alikes if is_reading(name)}
    if not also:
        return one
    alike, never = (tuple(also.get(n, n) for n in names) for names in (one.look_alikes, one.never_separable))
    return replace(one, look_alikes=alike, never_separable=never, outside=tuple(also.values()))


def _filtered(context: SearchContext, state: State, rules: Rules) -> FilterOnTorque | None:
    """Return the filter on the torque that may be what the accepted delays stand for; None where none may."""
    last = state.last.fitted
    shapes = [entry.term for entry in last.model.shapes]
    delays = [score for score in state.accepted if score.candidate.term.effect.id == DELAY]
    values = [last.fit.shapes[:, shapes.index(score.name)] for score in delays]
    late = [score for score, own in zip(delays, values, strict=True) if np.ptp(own) < np.median(own)]
    if not late:  # a torque that is early, or late by something else in every recording, is behind no filter
        return None
    joints = sorted({joint for score in late for joint in score.candidate.joints})
    return filtered(context.without(state.last, late).fitted, joints, rules)


def diagnose(
    model: Model | Fit | Given | None = None,
    recordings: Given | None = None,
    verify: Given = (),
    settings: DiagnosisSettings | None = None,
    *,
    progress: Progress | None = None,
    **changes: Unpack[DiagnosisOptions],
) -> Diagnosis:
    """Find the effect that `model` misses most: `discover` that stops after one step."""
    asked = vars(DiagnosisSettings.chosen(settings, changes))
    return discover(model, recordings, verify, DiscoverySettings(**asked | {"most": 1}), progress=progress)


def _part(tick: Progress, low: float, high: float) -> Progress:
    """Return a progress that moves `tick` from `low` to `high`."""
    return lambda fraction, text: tick(low + fraction * (high - low), text)


def settle(done: Searched) -> tuple[Searched, tuple[Extension, ...]]:
    """Return a search and its models on all of the recordings, with spikes judged anew; without effects that may be
    nothing there and explain nothing.
    """
    context, prepared, state = done.context, done.prepared, done.found.state
    on_all = context.prepared is prepared
    extensions = state.extensions
    last = extensions[-1].fitted if on_all else _on(extensions[-1].fitted.fit, prepared)
    judged = last.judged_anew() if len(extensions) > 1 else prepared
    if not (on_all and judged is prepared):
        extensions = _on_all_of(judged, extensions, anew=not on_all)
    if idle := idle_terms(extensions, context.rules):
        context.doubts |= {(context.key(state.extensions[0]), name): why for name, why in idle.items()}
        shorter = context.replay(state, [name for name in state.names if name not in idle])
        return settle(replace(done, found=replace(done.found, state=shorter)))
    return replace(done, prepared=judged, base=extensions[0].fitted), extensions


def _on_all_of(prepared: Prepared, extensions: Sequence[Extension], *, anew: bool) -> tuple[Extension, ...]:
    """Return the models on recordings of which the search had seen other spikes, the last fitted anew; all of them are,
    `anew`, where it had seen only stretches.
    """
    out = []
    for k, extension in enumerate(extensions, start=1):
        fit = _as_of(extension.fitted.fit, prepared)
        if anew or k == len(extensions):
            fit = identify(fit.model, prepared.train, optimisers=(), start=fit.start)
        out.append(replace(extension, fitted=fitted_model(fit, prepared)))
    return tuple(out)
