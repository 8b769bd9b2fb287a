"""Power of the recordings: the size from which on each effect of the catalogue would have been found."""

from __future__ import annotations

import math

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
            power.parameter if effect is None else number_called(effect, power.parameter),
            power.smallest if math.isfinite(power.smallest) else "not at any size",
            power.usual,
            "" if power.unit == "1" else power.unit,
            "yes" if power.would_show else "no",
            power.name,
        )
        for power in sorted(found.power, key=lambda power: (-power.smallest / power.usual, power.name))
        for effect in (effect_of(power.name, material.model),)
    ]
    head = ("effect", "its size", "found from", "usual", "unit", "would have shown", "id")
    return {"head": head, "rows": rows}
