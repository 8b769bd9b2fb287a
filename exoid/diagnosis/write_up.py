"""Findings of a search, written down as a Diagnosis."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import TypeVar

from exoid.diagnosis.evidence.agreement import Agreement
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.model_error import times_noise
from exoid.diagnosis.evidence.power import DRAWS, Power, power_of, power_said
from exoid.diagnosis.evidence.remainder import Remainder
from exoid.diagnosis.evidence.score import Score, share_of_own_joints
from exoid.diagnosis.evidence.soft_drive import SoftDrive
from exoid.diagnosis.evidence.stretches import searched
from exoid.diagnosis.hypotheses.readings import is_reading
from exoid.diagnosis.outside import force_uses
from exoid.diagnosis.own_numbers.numbers import Belonging, OwnNumbers
from exoid.diagnosis.question import Searched, steps_of
from exoid.diagnosis.results import Accepted, Conclusion, Diagnosis, Possible, Step, Suspect
from exoid.diagnosis.rules import Rules
from exoid.diagnosis.search.context import SearchContext
from exoid.diagnosis.search.doubt import known_with_shape
from exoid.diagnosis.search.state import Extension
from exoid.diagnosis.verdict import biased_parameters, sentence_of
from exoid.ground.ties import ascending
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.fitting.thigh_length import wanted_thigh_length
from exoid.optimisation.preparation.prepare import Prepared
from exoid.optimisation.preparation.smoothed import ANGLES, FILTERED, TORQUES
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate

Ranked = TypeVar("Ranked")


def possible_beside(
    soft: SoftDrive, accepted: Sequence[Accepted], possible: Sequence[Possible], rules: Rules
) -> tuple[Possible, ...]:
    """Possible effects where a drive too soft for its encoder explains more than all that was accepted."""
    reason = f"{soft.name}, its link where the measured torque puts it, explains more than all that was accepted"
    given_up = [
        Possible(effect.effect, effect.joint, effect.agreement, effect.parameters, effect.fall, reason)
        for effect in accepted
        if effect.fall >= rules.least_share
    ]
    names = {item.name for item in accepted}
    every = [*given_up, *(entry for entry in possible if entry.name not in names)]
    return tuple(ascending(every, lambda item: -item.explained_share, 1.0)[: rules.most_possible])


def with_own(answer: Diagnosis, told: Sequence[Belonging], given: FittedModel, caution: str = "") -> Diagnosis:
    """Return an answer beside what belongs to recordings; `given` is the model without it, `caution` is said of all."""
    first, *rest = answer.steps
    step = Step("base", given.train_rms, given.verify_rms)
    names = " + ".join(dict.fromkeys(entry.what for entry in told))
    sentences = " ".join(f"{item.sentence}." for item in told) + caution
    return replace(
        answer,
        sentence=f"{sentences} Beside that: {answer.sentence}",
        steps=(step, replace(first, label=f"+ {names}", sentence=sentences), *rest),
        of_recordings=(*told, *answer.of_recordings),
        given=given,
    )


def with_loads(answer: Diagnosis, told: Sequence[Belonging]) -> Diagnosis:
    """Return an answer about recordings whose loads were weighed before, and what is `told` of these."""
    sentences = " ".join(f"{item.sentence}." for item in told)
    return replace(answer, sentence=f"{sentences} {answer.sentence}", of_recordings=(*told, *answer.of_recordings))


def estimates_in(fit: Fit, name: str) -> dict[str, Estimate]:
    """Return the estimates of a term under their names without that of the term."""
    prefix = f"{name}."
    return {e.name.removeprefix(prefix): e for e in fit.estimates if e.name.startswith(prefix)}


def accepted_of(
    extensions: Sequence[Extension],
    agreements: Mapping[str, Agreement],
    context: SearchContext,
    own: OwnNumbers | None = None,
) -> tuple[Accepted, ...]:
    """Return the effects that were added, with their numbers in the last model, which are not known where recordings
    have some of their `own` that do the same, and what splits of the recordings say of each.
    """
    last, rules = extensions[-1], context.rules
    times = times_noise(last.fitted)
    mixed = own.mixed_with(last.fitted, rules) if own is not None and len(extensions) > 1 else frozenset[str]()
    accepted = []
    for before, extension in pairwise(extensions):
        score = extension.score
        agreement = agreements.get(score.name, Agreement())
        term = next(item for item in last.fitted.model.terms if item.name == score.name)
        numbers, share = estimates_in(last.fitted.fit, term.name), before.explained(extension, rules)
        for name in mixed & {entry.name for entry in numbers.values()}:
            key = name.removeprefix(f"{term.name}.")
            numbers[key] = replace(numbers[key], low=-math.inf, high=math.inf)
        accepted.append(
            Accepted(
                effect=term.effect.id,
                joint=term.joint,
                parameters=numbers,
                look_alikes=extension.alike,
                never_separable=extension.never,
                p_value=float(score.p_value or 1.0),
                rms_before=before.fitted.evaluation_rms,
                rms_after=extension.fitted.evaluation_rms,
                sentence=sentence_of(term, numbers, known_with_shape(last.fitted, term.name) | mixed),
                agreement=agreement,
                against=tuple(context.prepared.all[k].name for k in agreement.against),
                doubted=context.prepared.angles_were_filtered,
                left=float(times[list(score.candidate.joints)].max()),
                share=share,
            )
        )
    return tuple(accepted)


def write_up(
    done: Searched,
    conclusion: Conclusion,
    began: float,
    extensions: Sequence[Extension] = (),
    accepted: tuple[Accepted, ...] = (),
    left: Remainder | None = None,
    possible: tuple[Possible, ...] = (),
    leading: Possible | None = None,
) -> Diagnosis:
    """Return the answer to a question, with everything that it rests on, of the model that was given where there are no
    `extensions`; `leading` says why what leads the suspects was not accepted.
    """
    extensions = extensions or (Extension(done.base),)
    prepared, last = done.prepared, extensions[-1]
    first = () if conclusion.verdict == "check_channels" else done.found.first
    first = tuple(score for score in first if not is_reading(score.name))
    steps = steps_of(extensions, [effect.sentence for effect in accepted])
    named = {a.name: a for a in accepted}
    silent = conclusion.verdict == "check_channels" or conclusion.outside  # what is compared is not the machine's
    told = conclusion.outside or any(map(is_reading, done.found.state.names))  # the answer says more than the audit can
    length = None if told else wanted_thigh_length(last.fitted.fit, prepared)
    power = _power(done) if conclusion.verdict == "adequate" else ()
    said = power_said(power, last.fitted.model.find_effect)
    before = steps[0].evaluation_rms
    suspects = [_suspect(s, named, before, prepared.noise_floor) for s in first if s.share > 0.0 or s.caution]
    if leading is not None:
        suspects = [replace(s, caution=leading.reason) if s.name == leading.name else s for s in suspects]
    sentence = " ".join(filter(None, (conclusion.sentence, said, "" if silent else _reserve(prepared))))
    return Diagnosis(
        **vars(conclusion) | {"sentence": sentence},
        accepted=accepted,
        suspects=tuple(best_first(suspects, lambda one: one.sureness, lambda one: one.explained_share)),
        steps=steps,
        noise_floor=prepared.noise_floor,
        unexplained=left,
        audit=(
            *prepared.findings,
            *searched(prepared, done.context.prepared),
            *(() if length is None else (length.finding(),)),
        ),
        thigh_length=length,
        seconds=time.perf_counter() - began,
        model=last.fitted.model,
        fit=last.fitted.fit,
        cutoff=prepared.choice.reason,
        biased=biased_parameters(extensions[0].fitted.fit, last.fitted.fit),
        possible=possible,
        rules=done.context.rules,
        given=done.base,
        last=last.fitted,
        forces=force_uses(last.fitted),
        power=power,
    )


def _reserve(prepared: Prepared) -> str:
    """Return with which reserve an answer is given where angles or torques were filtered before they were stored."""
    told = [finding for finding in prepared.findings if finding.check in (FILTERED, ANGLES, TORQUES)]
    return "".join(f"With one reserve: {item.what}; if they were filtered, {item.consequence}." for item in told[:1])


def _power(done: Searched) -> tuple[Power, ...]:
    """Power of the recordings that were searched to show each effect beside the last model."""
    context, last = done.context, done.found.state.last
    evidence = context.evidence(last, DRAWS)
    return power_of(last.fitted, evidence, context.library, context.simulated(last))


def best_first(
    suspects: Iterable[Ranked], word: Callable[[Ranked], str], share: Callable[[Ranked], float]
) -> list[Ranked]:
    """Return suspects in the order in which a person reads them: those with a `word` first, then larger shares."""
    ordered = ascending(suspects, lambda one: -share(one), 1.0)
    return sorted(ordered, key=lambda one: not word(one))


def _suspect(score: Score, accepted: dict[str, Accepted], before: Float, noise_floor: Float) -> Suspect:
    """Return a suspect with its share of the error of its own joints, which noise bounds.

    Of one that was added it is what the refit found at its step, on the motion that the steps show.
    """
    term, mine = score.candidate.term, accepted.get(score.name)
    share = share_of_own_joints(score, before, noise_floor) if mine is None else mine.share
    alike, sure = ((), "") if mine is None else (mine.look_alikes, mine.sureness)
    return Suspect(term.effect.id, term.joint, share, score.p_value, alike, score.caution, sure)
