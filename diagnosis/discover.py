"""Compare, diagnose, add, and again, until nothing that helps on unseen motion is left (`search`), and say so."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from typing import cast

import numpy as np

from diagnosis.evidence.candidates import build_library
from diagnosis.evidence.channels import doubts_after, doubts_before
from diagnosis.evidence.consistency import differing
from diagnosis.evidence.fitted import FittedModel, fitted_model
from diagnosis.evidence.remainder import Remainder
from diagnosis.evidence.score import Score
from diagnosis.evidence.stretches import searched, stretches
from diagnosis.results import Accepted, Diagnosis, Step, Suspect
from diagnosis.rules import RULES, Rules
from diagnosis.search.context import Progress, SearchContext, silent
from diagnosis.search.engine import run
from diagnosis.search.state import Extension
from diagnosis.verdict import (
    Conclusion,
    biased_parameters,
    check_channels,
    conclude,
    doubted,
    sentence_of,
    within_filter_error,
)
from measurement.recording import Recording
from measurement.signals.derivatives import BUTTERWORTH
from optimisation.fitting.fit import Fit
from optimisation.fitting.identify import identify
from optimisation.preparation.prepare import Prepared, prepare
from symbolic.effect import Effect
from symbolic.model import Model


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
) -> Diagnosis:
    """Find which effects `model` (or the model of a Fit) is missing and add them, at most `most` of them (default: what
    `rules`, the thresholds that decide, say).

    `verify` are recordings that are never fitted and must improve; `extra` are effects beyond the catalogue and
    the model's own (`[[custom_effects]]` of its file), which are suspected anyway. Every random number comes
    from `seed`. Refuses recordings that are too short, too slow or do not determine the model.
    """
    began = time.perf_counter()
    model = cast("Model", model.model) if isinstance(model, Fit) else model
    tick = progress or silent
    most = rules.most_terms if most is None else most
    tick(0.02, "preparing the recordings")
    prepared = prepare(model, recordings, verify, cutoff=cutoff, derivative=derivative)
    base = fitted_model(identify(model, prepared.train, optimisers=()), prepared)
    answer = _before_any_search(base, rules)
    if answer is not None:
        return _write_up(prepared, prepared, (Extension(base),), (), None, answer, began)
    part = stretches(prepared, rules)
    library = build_library(model, part.all, own_effects(model, extra))
    context = SearchContext(part, library, seed, tick, most, rules)
    found = run(context, Extension(base) if part is prepared else context.fit(model))
    extensions = found.state.extensions
    if part is not prepared:
        tick(0.95, "fitting what was found to the whole of the recordings")
        extensions = _on_all_of(prepared, extensions)
    # At the limit there may be more that the catalogue explains; nothing is called unexplained yet.
    left = None if len(extensions) > most else found.state.left
    tick(0.97, "writing it down")
    last = extensions[-1].fitted
    doubt = doubts_after(base, last, rules)
    if doubt is not None:
        return _write_up(prepared, part, (Extension(base),), (), None, doubted(doubt), began)
    accepted = _accepted(extensions)
    answer = conclude(accepted, left, base, last, bool(verify), len(recordings), most, rules)
    return _write_up(prepared, part, extensions, found.first, left, answer, began)


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
        prefix = f"{term.name}."
        numbers = {e.name.removeprefix(prefix): e for e in last.fitted.fit.estimates if e.name.startswith(prefix)}
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
    prepared: Prepared,
    part: Prepared,
    extensions: Sequence[Extension],
    first: Sequence[Score],
    left: Remainder | None,
    conclusion: Conclusion,
    began: float,
) -> Diagnosis:
    last = extensions[-1]
    accepted = _accepted(extensions)
    steps = tuple(
        Step(
            "base" if s.added is None else f"+ {s.added.name}",
            s.fitted.train_rms,
            s.fitted.verify_rms,
            "" if s.added is None else accepted[i - 1].sentence,
        )
        for i, s in enumerate(extensions)
    )
    alike = {a.name: a.look_alikes for a in accepted}
    told_apart = (
        () if conclusion.verdict == "check_channels" else differing(last.fitted, last.fitted.evidence(seed=0, draws=0))
    )
    return Diagnosis(
        verdict=conclusion.verdict,
        rule=conclusion.rule,
        sentence=conclusion.sentence,
        accepted=accepted,
        suspects=tuple(_suspect(s, alike) for s in first if s.share > 0.0 or s.caution),
        steps=steps,
        noise_floor=prepared.noise_floor,
        unexplained=left,
        unexplained_significant=left is not None,
        audit=(*prepared.findings, *searched(prepared, part)),
        seconds=time.perf_counter() - began,
        next_experiment=conclusion.next_experiment,
        model=last.fitted.model,
        fit=last.fitted.fit,
        cutoff=prepared.choice.reason,
        stopped_because=conclusion.stopped_because,
        biased=biased_parameters(extensions[0].fitted.fit, last.fitted.fit),
        differing=told_apart,
        error=conclusion.error,
    )


def _on_all_of(prepared: Prepared, extensions: Sequence[Extension]) -> tuple[Extension, ...]:
    """Return the models refitted to recordings of which the search had seen only stretches."""
    out = []
    for extension in extensions:
        model = extension.fitted.model
        start = np.median(extension.fitted.fit.shapes, axis=0) if model.shapes else None
        fit = identify(model, prepared.train, optimisers=(), start=start)
        out.append(replace(extension, fitted=fitted_model(fit, prepared)))
    return tuple(out)


def _suspect(score: Score, alike: dict[str, tuple[str, ...]]) -> Suspect:
    term = score.candidate.term
    return Suspect(term.effect.id, term.joint, score.share, score.p_value, alike.get(term.name, ()), score.caution)
