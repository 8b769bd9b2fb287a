"""Findings and repairs of the audit of the recordings."""

from __future__ import annotations

from exoid.diagnosis.report.material import Context, Material
from exoid.measurement.finding import alike_findings, more_files

TITLE = "Recordings and their audit"
ORDER = 80
APPENDIX = True


def context(material: Material) -> Context:
    """Return one row per recording, and each kind of finding once."""
    if not material.recordings:
        return None
    rows = [
        (
            recording.name,
            use,
            len(recording),
            recording.duration,
            recording.rate,
            len(recording) - int(recording.complete.sum()),
            recording.source.sha256[:12] or "–",
        )
        for use, group in (("fitted", material.recordings), ("unseen", material.verify))
        for recording in group
    ]
    everything = (*material.recordings, *material.verify)
    findings = [
        (f.severity, (f"{f.where}: " if f.where else "") + f.what + more_files(others), f.remedy)
        for f, *others in alike_findings(f for item in everything for f in item.findings)
    ]
    return {
        "head": ("recording", "used as", "samples", "seconds", "Hz", "masked rows", "SHA-256"),
        "rows": rows,
        "findings": findings,
    }
