"""Findings and repairs of the audit of the recordings."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from exoid.diagnosis.report.material import Material

TITLE = "Recordings and their audit"
ORDER = 80
APPENDIX = True


def context(material: Material) -> Mapping[str, Any] | None:
    """Return one row per recording and every finding."""
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
    findings = [
        (f.severity, f"{f.where}: {f.what}" if f.where else f.what, f.remedy)
        for item in (*material.recordings, *material.verify)
        for f in item.findings
    ]
    return {
        "head": ("recording", "used as", "samples", "seconds", "Hz", "masked rows", "SHA-256"),
        "rows": rows,
        "findings": findings,
    }
