"""How much the catalogue could explain at best, asked without a search: what is said of the channels or of the world
outside has to beat it.
"""

from __future__ import annotations

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model
from exoid.diagnosis.evidence.library import build_library
from exoid.diagnosis.evidence.model_error import times_noise
from exoid.diagnosis.evidence.ranking import weigh_all
from exoid.diagnosis.rules import Rules
from exoid.ground.ties import least_of
from exoid.optimisation.fitting.identify import identify


def may_leave_noise(base: FittedModel, rules: Rules) -> bool:
    """Whether entries of the catalogue, the best one after the other, leave about the noise, as a search would have to:
    far cheaper than one. Each must explain much, or so few of them never get there.
    """
    library, now = build_library(base.model, base.prepared.all), base
    for _ in range(rules.most_terms):
        if np.all(times_noise(now) <= rules.near_noise):
            return True
        names = [term.name for term in now.model.terms]
        scores, _ = weigh_all(now.evidence(seed=0, draws=0, rules=rules), library, now, library.candidates)
        helping = [one for one in scores if one.helps and not one.caution and not one.candidate.tangent]
        rest = [one for one in helping if one.name not in names and one.share > rules.unexplained_share]
        if not rest:
            return False
        best = least_of(rest, lambda one: -one.share, 1.0)
        term = best.candidate.term
        model = now.model.with_effect(term.effect, term.joint)
        start = np.concatenate([now.shape, np.median(best.shape, axis=0)]) if model.shapes else None
        now = fitted_model(identify(model, base.prepared.train, optimisers=(), start=start), base.prepared)
    return bool(np.all(times_noise(now) <= rules.near_noise))
