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
from exoid.measurement.auditing.checks.frozen import frozen_stretches
from exoid.measurement.auditing.checks.motion import NONE
from exoid.measurement.auditing.checks.saturated import saturated_stretches
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
    angles, torques = np.array(recording.angle_valid), np.array(recording.torque_valid)
    findings: list[Finding] = []

    def mask(channel: Channel, rows: NDArray[np.int64], found: Finding, consequence: str, confidence: str) -> None:
        """Mark `rows` of a channel as not measured; of a force the torques of all joints, which it was to explain."""
        joint = slice(None) if channel.outside else recording.joints.index(channel.joint)
        (angles if channel.name.startswith("q") else torques)[rows, joint] = False
        found = replace(found, what=f"{found.what}; they are masked", remedy=found.remedy.partition(";")[0])
        findings.append(replace(found, severity="repaired", consequence=consequence, confidence=confidence))

    for channel, rows, found, certain in frozen_stretches(recording):
        if certain:
            mask(channel, rows, found, "none: they do not enter the fit", "certain")
    for channel, rows, found in saturated_stretches(recording):
        what = "what happened at full scale is not known and does not enter the fit"
        mask(channel, rows, found, what, found.confidence)
    kept = angles.all(axis=1) & torques.all(axis=1)
    if not findings or kept.sum() < (1.0 - MOST_MASKED) * recording.complete.sum():
        return recording
    return replace(recording, angle_valid=angles, torque_valid=torques, findings=(*recording.findings, *findings))
