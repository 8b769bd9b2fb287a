"""Stretches in which a sensor certainly did not measure: they are masked like bad cells, and said so.

A frozen or saturated stretch is no outlier: its rows agree with each other, so no loss can tell them from the truth.
What is only likely stays in and is a warning of the audit (`checks/frozen.py`, `checks/saturated.py`).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from measurement.auditing.checks import frozen, saturated
from measurement.finding import Finding
from measurement.recording import Recording

MOST = 0.3
"""Share of the rows that may be masked so; beyond, a person has to look at the recording first."""


def mask_unusable(recording: Recording) -> Recording:
    """Return `recording` without the rows in which a channel is certainly frozen or at its end of scale."""
    bad = np.zeros(len(recording), dtype=bool)
    findings: list[Finding] = []
    for channel, rows, certain in frozen.frozen_stretches(recording):
        if certain:
            bad[rows] = True
            found = frozen.frozen_finding(recording, channel, rows)
            findings.append(_masked(found, "none: the rows do not enter the fit", "certain"))
    for channel, level, rows in saturated.saturated_stretches(recording):
        bad[rows] = True
        found = saturated.saturated_finding(recording, channel, level, rows)
        what = "what happened at full scale is not known; the rows do not enter the fit"
        findings.append(_masked(found, what, found.confidence))
    bad &= recording.valid
    if not bad.any() or bad.sum() > MOST * recording.valid.sum():
        return recording
    return replace(recording, valid=recording.valid & ~bad, findings=(*recording.findings, *findings))


def _masked(found: Finding, consequence: str, confidence: str) -> Finding:
    """Return a finding on rows that have been left out of the fit."""
    what, remedy = f"{found.what}; they are masked", found.remedy.partition(";")[0]
    return replace(
        found, severity="repaired", what=what, remedy=remedy, consequence=consequence, confidence=confidence
    )
