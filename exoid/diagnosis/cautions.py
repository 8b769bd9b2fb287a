"""Warnings about a model that was only fitted, not searched: why it is no answer."""

from __future__ import annotations

import numpy as np

from exoid.diagnosis.evidence.best_effects import may_be_explained, most_effects
from exoid.diagnosis.evidence.channel_doubt import COLUMNS, Doubt, finite, left_share
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.intermittent import ADVICE, intermittent
from exoid.diagnosis.hypotheses.channels import doubts_before, doubts_first
from exoid.diagnosis.hypotheses.readings import reading_doubt
from exoid.diagnosis.rules import RULES, Rules
from exoid.diagnosis.search.doubt import on_bound
from exoid.measurement.finding import EVERY, Finding

OUTSIDE = "outside"
"""What the finding is called that something outside the machine acts: nothing is then said of the machine's numbers."""


def cautions(fitted: FittedModel, rules: Rules = RULES) -> tuple[Finding, ...]:
    """Return as a warning what makes the model no answer; () where nothing does."""
    if fitted.prepared.misread:
        return ()
    wrong = doubts_first(fitted, rules)
    outside = None if wrong is not None else intermittent(fitted, rules)
    if outside is not None and not may_be_explained(fitted, rules):
        return (Finding(OUTSIDE, "warning", outside.sentence(fitted.model.joints).rstrip("."), EVERY, remedy=ADVICE),)
    doubt = wrong or doubts_before(fitted, rules)
    share = left_share(fitted)
    most = np.nanmax(share, initial=0.0)
    if doubt is None and most > rules.worth_telling:
        last = most_effects(fitted, rules)
        names = [term.name for term in last.model.terms if not on_bound(last, term.name, rules)]
        doubt = reading_doubt(last.fit, names)
    if doubt is None and most > rules.unexplained_share:
        parts = ", ".join(f"{joint} {100 * x:.0f} %" for joint, x in finite(share, fitted.model.joint_names))
        text = f"This model leaves {parts} of the torque's variance: channels are wrong, or something large is missing"
        doubt = Doubt("unexplained", text, f"{COLUMNS}; `exoid discover` finds which of the two it is")
    if doubt is None:
        return ()
    return (Finding("channels", "warning", doubt.sentence.rstrip("."), EVERY, remedy=doubt.remedy),)
