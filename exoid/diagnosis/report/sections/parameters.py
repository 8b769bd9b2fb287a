"""The identified parameters with their intervals, and what to be careful about."""

from __future__ import annotations

from exoid.diagnosis.report.material import Context, Material
from exoid.symbolic.wording import number_of

TITLE = "Parameters"
ORDER = 60
APPENDIX = True


def context(material: Material) -> Context:
    """Return the estimates and the findings on their plausibility."""
    fit = material.fit
    if fit is None:
        return None
    labels = {p.name: getattr(p, "label", "") for p in fit.model.parameters}
    rows = [
        (e.name, labels.get(e.name) or number_of(e.name), float(e.value), e.unit, float(e.low), float(e.high))
        for e in fit.estimates
    ]
    return {
        "head": ("parameter", "meaning", "value", "unit", "95 % from", "to"),
        "rows": rows,
        "findings": [(str(f.severity), ": ".join(filter(None, (f.where, f.what))), f.remedy) for f in fit.plausibility],
        "best_known": bool(fit.best_known),
    }
