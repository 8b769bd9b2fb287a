"""The error that the true structure of a case would leave, and a check that what is hidden shows in the recordings at
all.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model
from exoid.measurement.bench.simulation import BenchRun
from exoid.measurement.recording import Recording
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import Model

SHOWN = 0.25
"""Part of the squared error on unseen motion, at some joint, that who knows what is hidden takes away."""


def true_fit(model: Model, runs: Sequence[BenchRun], recordings: Sequence[Recording]) -> FittedModel:
    """Return the true structure fitted to three recordings of a case, the fourth held out."""
    true = runs[0].true
    measured = {*true.model.channels} <= {*recordings[0].forces}
    forces = true.model.forces if measured else ()
    prepared = prepare(model.with_forces(*forces), recordings[:3], recordings[3:])
    start = true.shape if true.shape.size else None
    fit = identify(true.model.with_forces(*forces), prepared.train, optimisers=(), start=start)
    return fitted_model(fit, prepared)


def shows(model: Model, runs: Sequence[BenchRun], recordings: Sequence[Recording]) -> bool:
    """True if knowing what is hidden lowers the error of unseen motion by SHOWN of its square."""
    known = true_fit(model, runs, recordings)
    plain = identify(model.with_forces(*known.model.forces), known.prepared.train, optimisers=())
    before = fitted_model(plain, known.prepared).evaluation_rms
    return bool(np.any(known.evaluation_rms**2 < (1.0 - SHOWN) * before**2))
