"""The figures of the results, each with the sentence that stands for it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from workbench.report.material import Material

TITLE = "Figures"
ORDER = 50


def context(material: Material) -> Mapping[str, Any] | None:
    """Return the pictures, if there are any."""
    return {"pictures": material.pictures} if material.pictures else None
