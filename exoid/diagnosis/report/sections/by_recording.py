"""Trust in numbers: every parameter from every recording alone."""

from __future__ import annotations

from exoid.diagnosis.report.material import Context, Material

TITLE = "Which numbers can I trust?"
ORDER = 62
APPENDIX = True


def context(material: Material) -> Context:
    """Return parameter times recording, and what to record where they contradict each other."""
    found = material.by_recording
    if found is None or len(found.recordings) < 2:
        return None
    return {
        "head": ("parameter", "unit", "together", *found.recordings, "verdict"),
        "rows": [found.cells(row) for row in found.rows],
        "advice": [f"{row.name}: {row.verdict}; {row.advice}" for row in found.rows if row.advice],
    }
