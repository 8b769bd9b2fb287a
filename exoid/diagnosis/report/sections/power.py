"""Power of the recordings: the size from which on each effect of the catalogue would have been found."""

from __future__ import annotations

import math
from typing import Any

from exoid.diagnosis.evidence.power import Power
from exoid.diagnosis.report.material import Context, Material
from exoid.diagnosis.report.sections.verdict import title
from exoid.diagnosis.report.wording import effect_of
from exoid.symbolic.wording import number_called

TITLE = "What would have shown"
ORDER = 42
APPENDIX = True


def context(material: Material) -> Context:
    """Return one row per effect, those that these recordings say least about first; None where something was found."""
    found = material.diagnosis
    if found is None or not found.power:
        return None
    rows = [
        (
            title(power.name, material.model),
            _number(power, material.model),
            power.smallest if math.isfinite(power.smallest) else "not at any size",
            power.usual,
            "" if power.unit == "1" else power.unit,
            "yes" if power.would_show else "no",
            power.name,
        )
        for power in sorted(found.power, key=lambda power: (-power.smallest / power.usual, power.name))
    ]
    head = ("effect", "its size", "found from", "usual", "unit", "would have shown", "id")
    return {"head": head, "rows": rows}


def _number(one: Power, model: Any) -> str:
    effect = effect_of(one.name, model)
    return one.parameter if effect is None else number_called(effect, one.parameter)
