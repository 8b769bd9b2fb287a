"""All thresholds that decide, in the order in which a recording meets them; each is declared where it is used."""

from __future__ import annotations

from collections.abc import Iterator

import diagnosis.evidence
import diagnosis.extend
import diagnosis.separation
import diagnosis.sureness
import diagnosis.watching
import diagnosis.where
import measurement.auditing
import measurement.reading.selection
import measurement.signals
import optimisation.fitting
import optimisation.preparation
from diagnosis.rules import RULES, Rules
from ground.thresholds import Rule, thresholds_in


def thresholds_of_a_diagnosis(rules: Rules = RULES) -> Iterator[Rule]:
    """Yield those that a recording meets on its way through `discover`."""
    yield from thresholds_in(measurement.auditing, "the audit of a recording")
    yield from thresholds_in(measurement.reading.selection, "rows that are left out")
    yield from thresholds_in(measurement.signals, "what of a signal counts")
    yield from thresholds_in(optimisation.preparation, "preparation: filter, cut-off, samples that are used")
    yield from thresholds_in(optimisation.fitting, "what is said of a fit")
    yield from thresholds_in(diagnosis.evidence, "measured forces")
    yield from rules.table()
    yield from thresholds_in(diagnosis.where, "where the error sits")
    yield from thresholds_in(diagnosis.sureness, "how sure that is, in a word")


def every_threshold() -> Iterator[Rule]:
    """Yield all of them, those of a machine that is watched included."""
    yield from thresholds_of_a_diagnosis()
    yield from thresholds_in(diagnosis.extend, "an effect that is added by hand")
    yield from thresholds_in(diagnosis.separation, "the experiment that separates rivals")
    yield from thresholds_in(diagnosis.watching, "before against after, and a machine while it runs")
