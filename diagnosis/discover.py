"""Compare, diagnose, add, and again, until nothing that helps on unseen motion is left (`search`), and say so."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import cast

import numpy as np

from diagnosis.evidence.agreement import Agreement
from diagnosis.evidence.candidates import build_library
from diagnosis.evidence.channels import FilterOnTorque, doubts_after, doubts_before, filtered
from diagnosis.evidence.consistency import differing
from diagnosis.evidence.fitted import FittedModel, fitted_model
from diagnosis.evidence.remainder import Remainder
from diagnosis.evidence.score import Score
from diagnosis.evidence.soft_drive import SoftDrive, plainly_soft, soft_drive
from diagnosis.evidence.stability import splits_of
from diagnosis.evidence.stretches import searched, searched_stretches
from diagnosis.results import Accepted, Diagnosis, Possible, Step, Suspect
from diagnosis.rules import RULES, Rules
from diagnosis.search.context import Progress, SearchContext, silent
from diagnosis.search.doubt import DELAY, too_short
from diagnosis.search.engine import Found, run_search
from diagnosis.search.possible import agreements_of, possible_of
from diagnosis.search.state import Extension, State
from diagnosis.verdict import (
    Conclusion,
    behind,
    biased_parameters,
    check_channels,
    conclude,
    doubted,
    sentence_of,
    within_filter_error,
)
from ground.errors import ExoidError, NotEnoughDataError
from measurement.finding import Finding
from measurement.recording import Recording
from measurement.signals.derivatives import BUTTERWORTH
from optimisation.fitting.fit import Fit
from optimisation.fitting.identify import identify
from optimisation.fitting.thigh_length import wanted_thigh_length
from optimisation.preparation.prepare import Prepared, prepare
from symbolic.effect import Effect
from symbolic.model import Model
from symbolic.motion import Float
from symbolic.quantity import Estimate

LINEARISED, ALL = "linearised", "all"
"""Ways to repeat the decision over splits of the recordings."""


def discover(
    model: Model | Fit,
    recordings: Sequence[Recording],
    verify: Sequence[Recording] = (),
    *,
    seed: int = 0,
    cutoff: float | None = None,
    derivative: str = BUTTERWORTH,
    extra: Sequence[Effect] = (),
    progress: Progress | None = None,
    most: int | None = None,
    rules: Rules = RULES,
    splits: str = LINEARISED,
) -> Diagnosis:
    """Find which effects `model` (or the model of a Fit) is missing and add them, at most `most` of them (default: what
    `rules`, the thresholds that decide, say).

    `verify` are recordings that are never fitted and must improve; `extra` are effects beyond the catalogue and
    the model's own (`[[custom_effects]]` of its file), which are suspected anyway. Every random number comes
    from `seed`. `splits` is how the decision is repeated over splits of the recordings: "linearised", about the models
    that were found, or "all", the whole search from scratch in each split, which takes as many times as long as there
    are splits. Refuses recordings that are too short, too slow or do not determine the model.
    """
    if splits not in (LINEARISED, ALL):
        raise ExoidError(f"splits cannot be repeated as {splits!r}", remedy=f"use {LINEARISED} or {ALL}")
    model = cast("Model", model.model) if isinstance(model, Fit) else model
    rules = rules if most is None else replace(rules, most_terms=most)
    question = Question(model, seed, cutoff, derivative, tuple(extra), rules, splits)
    return answer_of(question, recordings, verify, progress or silent)


def answer_of(
    question: Question,
    recordings: Sequence[Recording],
    verify: Sequence[Recording],
    tick: Progress = silent,
    prepared: Prepared | None = None,
    found: Callable[[Sequence[Step]], None] | None = None,
) -> Diagnosis:
    """Return what `discover` finds; `prepared` are the recordings where they are prepared already, `found` is called
    with the steps so far whenever the search has another one.
    """
    began = time.perf_counter()
    rules, splits = question.rules, question.splits
    whole = _part(tick, 0.0, 0.5) if splits == ALL else tick
    done = question.search(recordings, verify, whole, prepared, found)
    prepared, state = done.prepared, done.found.state
    if done.answer is not None:
        return _write_up(done, (Extension(done.base),), (), None, (), done.answer, began)
    extensions = state.extensions
    if done.context.prepared is not prepared:
        whole(0.95, "fitting what was found to the whole of the recordings")
        extensions = _on_all_of(prepared, extensions)
    last = extensions[-1].fitted
    doubt = doubts_after(done.base, last, rules)
    if doubt is not None:
        return _write_up(done, (Extension(done.base),), (), None, (), doubted(doubt), began)
    several = len(recordings) + len(verify) > 1
    agreements = agreements_of(done.context, state) if several else {}
    possible = possible_of(done.context, state, several)
    if splits == ALL and several:
        agreements, possible = _from_scratch(question, recordings, verify, state.names, _part(tick, 0.5, 0.96))
    tick(0.97, "writing it down")
    # At the limit there may be more that the catalogue explains; nothing is called unexplained yet.
    left = None if len(extensions) > rules.most_terms else state.left
    names = [one.name for one in done.context.prepared.all]
    accepted = tuple(
        replace(one, agreement=found, against=tuple(names[k] for k in found.against))
        for one in _accepted(extensions)
        for found in (agreements.get(one.name, Agreement()),)
    )
    soft = done.soft
    if soft is None:
        begun = done.found.state.extensions[0].fitted
        soft = soft_drive(begun, state.last.fitted, done.context.noise(state.last), rules)
    if soft is not None:
        answer = behind(soft, last.model.joints)
        return _write_up(
            done, (Extension(done.base),), (), None, _beside(soft, accepted, possible, rules), answer, began
        )
    behind_filter = _filtered(done.context, state, rules)
    if behind_filter is not None and behind_filter.doubt is not None:
        return _write_up(done, (Extension(done.base),), (), None, (), doubted(behind_filter.doubt), began)
    if behind_filter is not None:
        accepted = tuple(
            replace(a, look_alikes=(*a.look_alikes, behind_filter.name)) if a.effect == DELAY else a for a in accepted
        )
    answer = conclude(accepted, left, done.base, last, bool(verify), len(recordings), rules, possible)
    return _write_up(done, extensions, accepted, left, possible, answer, began)


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
    model: Model | Fit,
    recordings: Sequence[Recording],
    verify: Sequence[Recording] = (),
    *,
    seed: int = 0,
    cutoff: float | None = None,
    derivative: str = BUTTERWORTH,
    extra: Sequence[Effect] = (),
    progress: Progress | None = None,
) -> Diagnosis:
    """Find the effect that `model` misses most: `discover` that stops after one step."""
    return discover(
        model, recordings, verify, seed=seed, cutoff=cutoff, derivative=derivative, extra=extra, progress=progress,
        most=1,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class _Searched:
    """A search that has ended: all recordings prepared, what was searched of them (`context`), and what was found.

    `base` is the model that was given, on all of them; `answer` is the conclusion where no search was needed, `soft`
    the drive that explains so much that none was made.
    """

    prepared: Prepared
    base: FittedModel
    context: SearchContext
    found: Found
    answer: Conclusion | None = None
    soft: SoftDrive | None = None


@dataclass(frozen=True, eq=False)
class Question:
    """What is asked of recordings, whichever of them are fitted; `extra` are the user's own effects."""

    model: Model
    seed: int
    cutoff: float | None
    derivative: str
    extra: tuple[Effect, ...] = ()
    rules: Rules = RULES
    splits: str = LINEARISED

    def search(
        self,
        recordings: Sequence[Recording],
        verify: Sequence[Recording],
        tick: Progress,
        prepared: Prepared | None = None,
        found: Callable[[Sequence[Step]], None] | None = None,
    ) -> _Searched:
        """Prepare the recordings, unless they are, and search; `found` hears of every step."""
        tick(0.02, "preparing the recordings")
        if prepared is None:
            prepared = prepare(self.model, recordings, verify, cutoff=self.cutoff, derivative=self.derivative)
        base = fitted_model(identify(self.model, prepared.train, optimisers=()), prepared)
        answer = _before_any_search(base, self.rules)
        part = prepared if answer is not None else searched_stretches(prepared, self.rules)
        library = build_library(self.model, part.all, own_effects(self.model, self.extra))
        context = SearchContext(part, library, self.seed, tick, self.rules)
        if found is not None:
            context = replace(context, grown=lambda state: found(_steps(state.extensions)))
        if answer is not None:
            return _Searched(prepared, base, context, Found(State((Extension(base),)), ()), answer)
        start = Extension(base) if part is prepared else context.fit(self.model)
        soft = plainly_soft(start.fitted, context.noise(start), self.rules)
        if soft is not None:
            nothing = Found(State((start,)), tuple(context.rank(start, 1)[1]))
            return _Searched(prepared, base, context, nothing, soft=soft)
        return _Searched(prepared, base, context, run_search(context, start))


def _part(tick: Progress, low: float, high: float) -> Progress:
    """Return a progress that moves `tick` from `low` to `high`."""
    return lambda fraction, text: tick(low + fraction * (high - low), text)


def _from_scratch(
    question: Question,
    recordings: Sequence[Recording],
    verify: Sequence[Recording],
    accepted: Sequence[str],
    tick: Progress,
) -> tuple[dict[str, Agreement], tuple[Possible, ...]]:
    """Search anew in every split; return how often each of the `accepted` was, and what else some splits accept."""
    everything = [*recordings, *verify]
    found: dict[str, list[tuple[Score, dict[str, Estimate]]]] = {}
    lost: dict[str, list[int]] = {}
    count = 0
    splits = splits_of(len(everything), len(verify), question.rules, question.seed)
    for number, held_out in enumerate(splits):
        tick(number / len(splits), f"split {number + 1} of {len(splits)}, from scratch")
        fitted = [r for k, r in enumerate(everything) if k not in held_out]
        try:
            state = question.search(fitted, [everything[k] for k in held_out], silent).found.state
        except NotEnoughDataError:  # these recordings alone do not determine the model: this split cannot tell
            continue
        count += 1
        for score in state.accepted:
            found.setdefault(score.name, []).append((score, _numbers_of(state.last.fitted.fit, score.name)))
        for name in set(accepted) - set(state.names):
            lost.setdefault(name, []).extend(held_out)
    agreements = {}
    for name, entries in found.items():
        values = [numbers for _, numbers in entries]
        ranges = {key: (min(v[key].value for v in values), max(v[key].value for v in values)) for key in values[0]}
        agreements[name] = Agreement(len(entries), count, ranges, tuple(dict.fromkeys(lost.get(name, ()))))
    possible = [
        Possible(
            score.candidate.term.effect.id,
            score.candidate.term.joint,
            agreements[name],
            {
                k: replace(e, low=agreements[name].ranges[k][0], high=agreements[name].ranges[k][1])
                for k, e in own.items()
            },
            score.share,
            f"accepted in {len(entries)} of {count} splits of the recordings, each searched from scratch",
        )
        for name, entries in found.items()
        for score, own in entries[:1]
        if name not in accepted
    ]
    never = {name: Agreement(0, count, {}, tuple(dict.fromkeys(lost[name]))) for name in accepted if name not in found}
    return agreements | never, tuple(sorted(possible, key=lambda p: -(p.agreement.share or 0.0)))


def _beside(
    soft: SoftDrive, accepted: Sequence[Accepted], possible: Sequence[Possible], rules: Rules
) -> tuple[Possible, ...]:
    """Return what is possible where a drive too soft for its encoder explains more than all that was accepted."""
    reason = f"{soft.name}, its link where the measured torque puts it, explains more than all that was accepted"
    given_up = [
        Possible(one.effect, one.joint, one.agreement, one.parameters, _fall(one), reason)
        for one in accepted
        if _fall(one) >= rules.least_share
    ]
    names = {one.name for one in accepted}
    both = [*given_up, *(one for one in possible if one.name not in names)]
    return tuple(sorted(both, key=lambda one: -one.explained_share)[: rules.most_possible])


def _fall(one: Accepted) -> float:
    """Return by what share of itself the squared error fell with an accepted effect, the joints' mean."""
    return float(1.0 - np.mean((one.rms_after / one.rms_before) ** 2))


def _numbers_of(fit: Fit, name: str) -> dict[str, Estimate]:
    """Return the estimates of a term under their names without that of the term."""
    prefix = f"{name}."
    return {e.name.removeprefix(prefix): e for e in fit.estimates if e.name.startswith(prefix)}


def own_effects(model: Model, extra: Sequence[Effect]) -> tuple[Effect, ...]:
    """Return `extra` and the user's own effects, each once: those the model declares and those it has already."""
    own = (*extra, *model.custom, *(term.effect for term in model.terms if term.effect.custom))
    return tuple({effect.id: effect for effect in reversed(own)}.values())[::-1]


def _before_any_search(base: FittedModel, rules: Rules) -> Conclusion | None:
    """Return the conclusion that needs no search: the channels cannot be right, or nothing is left but filter error."""
    if base.prepared.misread:
        return check_channels(base.prepared.misread)
    doubt = doubts_before(base, rules)
    if doubt is not None:
        return doubted(doubt)
    if np.all(base.judged_rms <= rules.filter_error * base.prepared.filter_error):
        return within_filter_error(base)
    return None


def _accepted(extensions: Sequence[Extension]) -> tuple[Accepted, ...]:
    """Return the effects that were added, with their numbers in the last model."""
    last = extensions[-1]
    accepted = []
    for before, extension in pairwise(extensions):
        score = extension.added
        assert score is not None
        term = score.candidate.term
        numbers = _numbers_of(last.fitted.fit, term.name)
        accepted.append(
            Accepted(
                effect=term.effect.id,
                joint=term.joint,
                parameters=numbers,
                look_alikes=extension.alike,
                never_separable=extension.never,
                p_value=float(score.p_value or 1.0),
                rms_before=before.fitted.judged_rms,
                rms_after=extension.fitted.judged_rms,
                sentence=sentence_of(term, numbers),
            )
        )
    return tuple(accepted)


def _write_up(
    done: _Searched,
    extensions: Sequence[Extension],
    accepted: tuple[Accepted, ...],
    left: Remainder | None,
    possible: tuple[Possible, ...],
    conclusion: Conclusion,
    began: float,
) -> Diagnosis:
    prepared, last = done.prepared, extensions[-1]
    first = () if conclusion.verdict == "check_channels" else done.found.first
    steps = _steps(extensions, [one.sentence for one in accepted])
    alike = {a.name: a.look_alikes for a in accepted}
    told_apart = (
        () if conclusion.verdict == "check_channels" else differing(last.fitted, last.fitted.evidence(seed=0, draws=0))
    )
    length = wanted_thigh_length(last.fitted.fit, prepared)
    return Diagnosis(
        verdict=conclusion.verdict,
        rule=conclusion.rule,
        sentence=conclusion.sentence,
        accepted=accepted,
        suspects=tuple(_suspect(s, alike, steps, prepared.noise_floor) for s in first if s.share > 0.0 or s.caution),
        steps=steps,
        noise_floor=prepared.noise_floor,
        unexplained=left,
        unexplained_significant=left is not None,
        audit=(
            *prepared.findings,
            *searched(prepared, done.context.prepared),
            *_short(prepared, done.context.rules),
            *(() if length is None else (length.finding(),)),
        ),
        thigh_length=length,
        seconds=time.perf_counter() - began,
        next_experiment=conclusion.next_experiment,
        model=last.fitted.model,
        fit=last.fitted.fit,
        cutoff=prepared.choice.reason,
        stopped_because=conclusion.stopped_because,
        biased=biased_parameters(extensions[0].fitted.fit, last.fitted.fit),
        differing=told_apart,
        error=conclusion.error,
        possible=possible,
        rules=done.context.rules,
    )


def _steps(extensions: Sequence[Extension], sentences: Sequence[str] = ()) -> tuple[Step, ...]:
    """Return the falling error; `sentences` are about those that were added."""
    said = ("", *sentences)
    return tuple(
        Step(
            "base" if s.added is None else f"+ {s.added.name}",
            s.fitted.train_rms,
            s.fitted.verify_rms,
            said[i] if i < len(said) else "",
        )
        for i, s in enumerate(extensions)
    )


def _short(prepared: Prepared, rules: Rules) -> tuple[Finding, ...]:
    """Return that the recordings are too short for anything to be accepted; nothing where they are not."""
    text = too_short(prepared, rules)
    if not text:
        return ()
    remedy = f"record at least {rules.least_seconds:g} s of motion to fit, in two recordings or more"
    return (Finding("too_short_to_diagnose", "warning", text, "fitted recordings", None, rules.least_seconds, remedy),)


def _on_all_of(prepared: Prepared, extensions: Sequence[Extension]) -> tuple[Extension, ...]:
    """Return the models refitted to recordings of which the search had seen only stretches."""
    out = []
    for extension in extensions:
        model = extension.fitted.model
        start = np.median(extension.fitted.fit.shapes, axis=0) if model.shapes else None
        fit = identify(model, prepared.train, optimisers=(), start=start)
        out.append(replace(extension, fitted=fitted_model(fit, prepared)))
    return tuple(out)


def _suspect(score: Score, alike: dict[str, tuple[str, ...]], steps: Sequence[Step], noise_floor: Float) -> Suspect:
    """Return a suspect with its share of the error of its own joints, which noise bounds.

    Of the one that was added first it is what the refit found, on the motion that the steps show.
    """
    term, likes = score.candidate.term, alike.get(score.name, ())
    names = [joint.name for joint in term.among]
    at = slice(None) if term.joint is None else [names.index(term.joint)]
    before, after = steps[0].judged_rms[at], noise_floor[at]
    first = next(iter(alike), None) == score.name
    if first:
        after = steps[1].judged_rms[at]
    most = max(0.0, 1.0 - float(np.sum(after**2) / max(float(np.sum(before**2)), 1e-300)))
    share = most if first else min(score.joint_share, most)
    return Suspect(term.effect.id, term.joint, share, score.p_value, likes, score.caution)
