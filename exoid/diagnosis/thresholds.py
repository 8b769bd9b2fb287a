"""All thresholds that decide, in the order in which a recording meets them; each is declared where it is used."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module

import exoid.diagnosis.evidence
import exoid.diagnosis.separation
import exoid.diagnosis.sureness
import exoid.diagnosis.where
import exoid.measurement.auditing
import exoid.measurement.noisy_copy
import exoid.measurement.reading
import exoid.measurement.signals
import exoid.measurement.stance
import exoid.optimisation.fitting
import exoid.optimisation.preparation
from exoid.diagnosis.rules import RULES
from exoid.ground.folder import APPS, apps
from exoid.ground.thresholds import Rule, thresholds_in


def every_threshold() -> Iterator[Rule]:
    """Yield all of them, those of apps last."""
    yield from thresholds_in(exoid.measurement.reading, "how columns are read")
    yield from thresholds_in(exoid.measurement.noisy_copy, "recordings that share samples")
    yield from thresholds_in(exoid.measurement.auditing, "the audit of a recording")
    yield from thresholds_in(exoid.measurement.stance, "rows that are left out")
    yield from thresholds_in(exoid.measurement.signals, "what of a signal counts")
    yield from thresholds_in(exoid.optimisation.preparation, "preparation: filter, cut-off, samples that are used")
    yield from thresholds_in(exoid.optimisation.fitting, "what is said of a fit")
    yield from thresholds_in(exoid.diagnosis.evidence, "measured forces")
    yield from RULES.table()
    yield from thresholds_in(exoid.diagnosis.where, "where the error sits")
    yield from thresholds_in(exoid.diagnosis.sureness, "how sure that is, in a word")
    yield from thresholds_in(exoid.diagnosis.separation, "the experiment that separates rivals")
    for app in apps():
        yield from thresholds_in(import_module(f"{APPS}.{app}"), f"the app {app}")
