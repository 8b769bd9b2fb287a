"""Samples that a sensor certainly did not measure: torques that are rounding are read as zero, and stretches without a
measurement are masked like bad cells; both are said.

A frozen or saturated stretch is no outlier: its rows agree with each other, so no loss can tell them from the truth.
What is only likely stays in and is a warning of the audit (`checks/frozen.py`, `checks/saturated.py`). Where a force
was not measured no torque says anything.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from exoid.measurement.auditing.channels import Channel, channels, place
from exoid.measurement.auditing.checks import frozen, saturated
from exoid.measurement.auditing.checks.motion import NONE
from exoid.measurement.finding import Finding
from exoid.measurement.recording import Recording

MOST_MASKED = 0.3
"""Share of the rows that may be masked so; beyond, a person has to look at the recording first."""


def without_rounding(recording: Recording) -> Recording:
    """Read a torque that is nothing but rounding (1e-149 N·m) as the zero that it stands for, and say so."""
    largest = [float(np.max(np.abs(channel.values), initial=0.0)) for channel in channels(recording, "tau")]
    tau, findings = recording.tau.copy(), list(recording.findings)
    for k, (joint, most) in enumerate(zip(recording.joints, largest, strict=True)):
        if 0.0 < most <= NONE < max(largest):  # where all are, the audit refuses them as they stand
            tau[:, k] = 0.0
            what = f"tau{k + 1} never exceeds {most:.3g} {joint.unit('tau')}, which is rounding: it is read as zero"
            remedy = f"is this the right column? --map tau{k + 1}=COLUMN"
            findings.append(Finding("motion", "repaired", what, place(recording), remedy=remedy))
    if len(findings) == len(recording.findings):
        return recording
    return replace(recording, tau=tau, findings=tuple(findings))


def mask_unusable(recording: Recording) -> Recording:
    """Return `recording` without the samples of channels that are certainly frozen or at their end of scale."""
    valid = {"q": np.array(recording.angle_valid), "tau": np.array(recording.torque_valid)}
    findings: list[Finding] = []
    for channel, rows, certain in frozen.frozen_stretches(recording):
        if certain:
            _hide(valid, channel, rows)
            found = frozen.frozen_finding(recording, channel, rows)
            findings.append(_masked(found, "none: they do not enter the fit", "certain"))
    for channel, level, rows in saturated.saturated_stretches(recording):
        _hide(valid, channel, rows)
        found = saturated.saturated_finding(recording, channel, level, rows)
        what = "what happened at full scale is not known and does not enter the fit"
        findings.append(_masked(found, what, found.confidence))
    kept = valid["q"].all(axis=1) & valid["tau"].all(axis=1)
    if not findings or kept.sum() < (1.0 - MOST_MASKED) * recording.complete.sum():
        return recording
    findings = [*recording.findings, *findings]
    return replace(recording, angle_valid=valid["q"], torque_valid=valid["tau"], findings=tuple(findings))


def _hide(valid: dict[str, NDArray[np.bool_]], channel: Channel, rows: NDArray[np.int64]) -> None:
    """Mark `rows` of a channel as not measured; of a force the torques of all joints, which it was to explain."""
    if channel.outside:
        valid["tau"][rows] = False
        return
    quantity = channel.name.rstrip("0123456789")
    valid[quantity][rows, int(channel.name.removeprefix(quantity)) - 1] = False


def _masked(found: Finding, consequence: str, confidence: str) -> Finding:
    """Return a finding on rows that have been left out of the fit."""
    what, remedy = f"{found.what}; they are masked", found.remedy.partition(";")[0]
    return replace(
        found, severity="repaired", what=what, remedy=remedy, consequence=consequence, confidence=confidence
    )
