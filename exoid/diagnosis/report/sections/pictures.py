"""The figures of the results, each with the sentence that stands for it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from exoid.diagnosis.report.material import Material

TITLE = "Figures"
ORDER = 50
APPENDIX = True


def context(material: Material) -> Mapping[str, Any] | None:
    """Return the pictures that no other section shows, if there are any."""
    pictures = material.pictures_in("")
    return {"pictures": pictures} if pictures else None
