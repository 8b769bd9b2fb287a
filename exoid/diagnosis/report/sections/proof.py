"""Distance of each optimiser from the proven optimum."""

from __future__ import annotations

from exoid.diagnosis.report.material import Context, Material

TITLE = "Proof of the optimum"
ORDER = 70
APPENDIX = True


def context(material: Material) -> Context:
    """Return the certificate, and the gap of each optimiser and of IPOPT where they ran."""
    fit = material.fit
    if fit is None or not fit.runs:
        return None
    rows = [(name, run.gap, run.evaluations, float(run.seconds)) for name, run in fit.runs.items()]
    if fit.reference is not None:
        rows.append(("IPOPT", fit.reference.gap, fit.reference.iterations, float(fit.reference.seconds)))
    return {
        "certificate": str(fit.certificate),
        "head": ("method", "relative gap", "evaluations or iterations", "seconds"),
        "rows": rows,
    }
