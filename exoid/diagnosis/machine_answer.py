"""The answer of a machine alone: the search for what its model lacks, judged on all of the recordings, in words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from exoid.diagnosis.evidence.apart import OTHERS, left_out, odd_ones
from exoid.diagnosis.evidence.fitted import FittedModel, fit_as_of, fitted_model, fitted_on
from exoid.diagnosis.evidence.soft_drive import soft_drive
from exoid.diagnosis.hypotheses.channels import doubts_after
from exoid.diagnosis.hypotheses.readings import is_reading, reading_doubt, reading_said
from exoid.diagnosis.question import Question, Searched
from exoid.diagnosis.results import Accepted, Diagnosis, Step
from exoid.diagnosis.search.doubt import refuted
from exoid.diagnosis.search.possible import agreements_of, leading_of, possible_of
from exoid.diagnosis.search.state import Extension
from exoid.diagnosis.verdict import behind, conclude, doubted
from exoid.diagnosis.write_up import accepted_of, possible_beside, write_up
from exoid.ground.progress import Progress, part_of
from exoid.measurement.reading.conventions import read_as
from exoid.measurement.recording import Recording
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import Prepared


@dataclass(frozen=True, eq=False)
class Asking:
    """A question asked of `recordings` that are fitted and others to `verify`, where its progress is told, what hears
    of every step of the search, and when it began.
    """

    question: Question
    recordings: Sequence[Recording]
    verify: Sequence[Recording]
    tick: Progress
    found: Callable[[Sequence[Step]], None] | None
    began: float

    def part(self, low: float, high: float) -> Asking:
        """The same, whose progress goes from `low` to `high`."""
        return replace(self, tick=part_of(self.tick, low, high))

    def fitted(self, prepared: Prepared | None = None) -> FittedModel:
        """Return the model as it was given, fitted to the recordings, which are prepared unless they are."""
        return self.question.fitted(self.recordings, self.verify, self.tick, prepared)


def answer_of_machine(asking: Asking, base: FittedModel) -> Diagnosis:
    """Return the answer of the recordings, to which `base` is fitted, without those that are of another machine."""
    rules, verify = asking.question.rules, asking.verify
    odd = odd_ones(base, rules) if len(base.prepared.all) > OTHERS else ()
    fitted = [recording for k, recording in enumerate(asking.recordings) if k not in odd]
    held = [item for k, item in enumerate(verify, len(asking.recordings)) if k not in odd]
    if not odd or not fitted or (verify and not held):
        return _answer(asking, base)
    half = replace(asking.part(0.0, 0.5), recordings=fitted, verify=held)
    of_others = _answer(half, half.fitted())
    apart, explained = left_out(base, of_others.fit, odd, rules)
    sentence = " ".join([of_others.sentence, *(f"{item.sentence}." for item in apart.values())])
    without = replace(of_others, sentence=sentence, left_out=tuple(apart.values()))
    if apart and of_others.accepted:
        return without
    whole = _answer(asking.part(0.5, 1.0), base)
    if not apart or whole.accepted or of_others.verdict != "adequate":
        return whole
    # An effect that these alone show is one of the machine, unless numbers of their own explain far more.
    nearest = max((entry.explained_share for entry in whole.possible), default=0.0)
    return whole if nearest > max(rules.worth_telling, rules.half * explained) else without


def _answer(asking: Asking, base: FittedModel) -> Diagnosis:
    """Return the answer of all the recordings together: that of the machine, unless something outside explains more."""
    done, answer = _inside(asking, base)
    outside = asking.question.pushed(done, asking.tick)
    if outside is None or outside.answer is None:
        return answer
    return replace(write_up(outside, outside.answer, asking.began), inside=answer)


def _inside(asking: Asking, base: FittedModel) -> tuple[Searched, Diagnosis]:
    """Return the search and the answer of a machine on which nothing acts but what is measured."""
    question, tick, recordings, verify = asking.question, asking.tick, asking.recordings, asking.verify
    rules = question.rules

    def read(option: str) -> FittedModel:
        fitted, held = ([read_as(recording, option) for recording in group] for group in (recordings, verify))
        return question.fitted(fitted, held, tick)

    done = question.search(base, tick, asking.found, read)
    if done.answer is not None:
        return done, write_up(done, done.answer, asking.began)
    if wrong := reading_doubt(done.found.state.last.fitted.fit, done.found.state.names):
        return done, write_up(done, doubted(wrong), asking.began)
    tick(0.95, "judging what was found on the whole of the recordings")
    done, extensions = settle(done)
    state = done.found.state
    last = extensions[-1].fitted
    doubt = doubts_after(done.base, last, rules, state.left)

    def unless_doubted(found: Diagnosis) -> tuple[Searched, Diagnosis]:
        return done, found if doubt is None else replace(write_up(done, doubted(doubt), asking.began), inside=found)

    several = len(recordings) + len(verify) > 1
    agreements = agreements_of(done.context, state) if several else {}
    possible = possible_of(done.context, state, several)
    tick(0.97, "writing it down")
    # At the limit there may be more that the catalogue explains; nothing is called unexplained yet.
    left = None if len(extensions) > rules.most_terms else state.left
    accepted = accepted_of(extensions, agreements, done.context, question.own)
    noise, follows = done.context.noise(state.last), None if state.left is None else state.left.joint
    soft = soft_drive(state.extensions[0].fitted, state.last.fitted, noise, rules, follows)
    if soft is not None:
        possible = possible_beside(soft, accepted, possible, rules)
        return unless_doubted(write_up(done, behind(soft, last.model.joints), asking.began, possible=possible))
    accepted = tuple(map(in_words, accepted))
    first = () if accepted else done.found.first
    leading = leading_of(done.context, state, first, done.base.evaluation_rms)
    answer = conclude(accepted, left, done.base, last, bool(verify), len(recordings), rules, possible, leading)
    return unless_doubted(write_up(done, answer, asking.began, extensions, accepted, left, possible, leading))


def in_words(one: Accepted) -> Accepted:
    """The same accepted effect, with readings among its look-alikes named in words: no catalogue has them."""
    also = {name: reading_said(name) for name in one.look_alikes if is_reading(name)}
    if not also:
        return one
    alike, never = (tuple(also.get(n, n) for n in names) for names in (one.look_alikes, one.never_separable))
    return replace(one, look_alikes=alike, never_separable=never, outside=tuple(also.values()))


def settle(done: Searched) -> tuple[Searched, tuple[Extension, ...]]:
    """Return a search and its models on all recordings, spikes judged anew, without effects to which numbers object."""
    context, prepared, state = done.context, done.prepared, done.found.state
    on_all = context.prepared is prepared
    extensions = state.extensions
    last = extensions[-1].fitted if on_all else fitted_on(extensions[-1].fitted.fit, prepared)
    judged = last.judged_anew() if len(extensions) > 1 else prepared
    if not (on_all and judged is prepared):
        extensions = _refitted(judged, extensions, anew=not on_all)
    if (wrong := refuted(extensions, context.rules)) is not None:
        name, objection = wrong
        context.doubts[context.key(state.extensions[0]), name] = objection
        shorter = context.replay(state, [other for other in state.names if other != name])
        return settle(replace(done, found=replace(done.found, state=shorter)))
    return replace(done, prepared=judged, base=extensions[0].fitted), extensions


def _refitted(prepared: Prepared, extensions: Sequence[Extension], *, anew: bool) -> tuple[Extension, ...]:
    """Return the models on recordings with other spikes than the search saw, the last refitted, or all (`anew`)."""
    out = []
    for k, extension in enumerate(extensions, start=1):
        fit = fit_as_of(extension.fitted.fit, prepared)
        if anew or k == len(extensions):
            fit = identify(fit.model, prepared.train, optimisers=(), start=fit.start)
        out.append(replace(extension, fitted=fitted_model(fit, prepared)))
    return tuple(out)
