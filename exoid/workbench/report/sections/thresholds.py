"""The thresholds that decided, each with what it is for, from the record itself."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from exoid.diagnosis.rules import RULES
from exoid.diagnosis.thresholds import thresholds_of_a_diagnosis
from exoid.workbench.report.material import Material

TITLE = "Thresholds of the diagnosis"
ORDER = 85
APPENDIX = True


def context(material: Material) -> Mapping[str, Any] | None:
    """Return one row per threshold; None where nothing was diagnosed."""
    if material.diagnosis is None:
        return None
    rules = getattr(material.diagnosis, "rules", RULES)
    found = thresholds_of_a_diagnosis(rules)
    return {"rows": [(rule.group, rule.name, f"{rule.value:g}", rule.prevents) for rule in found]}
