"""The figures of the results, each with the sentence that stands for it."""

from __future__ import annotations

from exoid.diagnosis.report.material import Context, Material

TITLE = "Figures"
ORDER = 50
APPENDIX = True


def context(material: Material) -> Context:
    """Return the pictures that no other section shows, if there are any."""
    pictures = material.pictures_in("")
    return {"pictures": pictures} if pictures else None
