"""The most that the catalogue and readings could explain, asked without a search: what is said of the world outside has
to beat it.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model
from exoid.diagnosis.evidence.library import build_library
from exoid.diagnosis.evidence.model_error import is_near_noise
from exoid.diagnosis.evidence.ranking import weigh_all
from exoid.diagnosis.hypotheses.readings import readings_of
from exoid.diagnosis.own_numbers.found import belonging_to
from exoid.diagnosis.rules import Rules
from exoid.ground.ties import least_of
from exoid.optimisation.fitting.identify import identify


def as_given(base: FittedModel) -> FittedModel:
    """Return a model on recordings that are taken as they were given, whatever reading of them fits better."""
    prepared = base.prepared
    rest = tuple(finding for finding in prepared.findings if finding not in prepared.misread)
    return replace(base, prepared=replace(prepared, findings=rest, misread=()))


@np.errstate(over="ignore", invalid="ignore", divide="ignore")  # angles that are misread may be of any size
def most_effects(base: FittedModel, rules: Rules) -> FittedModel:
    """Screening before a search: a model with entries of the catalogue, or readings, the best one after the other,
    until about the noise is left. Each must explain much, or so few of them never get there.
    """
    library, now = build_library(base.model, base.prepared.all, readings_of(base.model, base.prepared)), base
    while not is_near_noise(now, rules):
        if len(now.model.terms) - len(base.model.terms) == rules.most_terms:
            break
        present = {(term.effect.id, term.joint) for term in now.model.terms}
        todo = [item for item in library.candidates if (item.term.effect.id, item.term.joint) not in present]
        scores, _ = weigh_all(now.evidence(seed=0, draws=0, rules=rules), library, now, todo)
        helping = [score for score in scores if score.helps and not score.caution and not score.candidate.tangent]
        rest = [entry for entry in helping if entry.share > rules.unexplained_share]
        if not rest:
            break
        best = least_of(rest, lambda one: -one.share, 1.0)
        # What makes up for a late torque is worth nothing once that is read in time, and hides it.
        late = [s for s in rest if s.candidate.reads_torque and s.share >= rules.half * best.share]
        best = least_of(late, lambda one: -one.share, 1.0) if late else best
        term = best.candidate.term
        model = now.model.with_effect(term.effect, term.joint)
        start = np.concatenate([now.shape, np.median(best.shape, axis=0)]) if model.shapes else None
        now = fitted_model(identify(model, base.prepared.train, optimisers=(), start=start), base.prepared)
    return now


def may_be_explained(base: FittedModel, rules: Rules) -> bool:
    """True if entries of the catalogue may leave about the noise, alone or beside what belongs to recordings."""
    last = most_effects(base, rules)
    if is_near_noise(last, rules):
        return True
    own = belonging_to(last, rules)
    return own is not None and is_near_noise(own.beside(last, base.prepared), rules)
