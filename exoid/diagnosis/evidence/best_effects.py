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
from exoid.diagnosis.evidence.score import Score
from exoid.diagnosis.hypotheses.readings import readings_of
from exoid.diagnosis.own_numbers.found import belonging_to
from exoid.diagnosis.rules import Rules
from exoid.ground.ties import ascending, index_of_least
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
        leading = ascending(helping, lambda one: -one.share, 1.0)[: rules.refitted]
        if not leading or leading[0].share <= rules.unexplained_share:
            break
        # Linearised, what makes up for a late torque may lead, and be worth nothing once that is read in time.
        near = [score for score in leading if score.share >= rules.half * leading[0].share]
        refits = [_refitted(now, score) for score in near]
        now = refits[index_of_least([fitted.unseen_loss(now.unseen_scale, rules) for fitted in refits], 1.0)]
    return now


def _refitted(now: FittedModel, score: Score) -> FittedModel:
    """A model with one term more, fitted anew."""
    term = score.candidate.term
    model = now.model.with_effect(term.effect, term.joint)
    start = np.concatenate([now.shape, np.median(score.start, axis=0)]) if model.shapes else None
    return fitted_model(identify(model, now.prepared.train, optimisers=(), start=start), now.prepared)


def may_be_explained(base: FittedModel, rules: Rules) -> bool:
    """True if entries of the catalogue may leave about the noise, alone or beside what belongs to recordings."""
    last = most_effects(base, rules)
    if is_near_noise(last, rules):
        return True
    own = belonging_to(last, rules)
    return own is not None and is_near_noise(own.beside(last, base.prepared), rules)
