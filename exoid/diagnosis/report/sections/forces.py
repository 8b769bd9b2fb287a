"""The measured forces: where each acts, and how much of every torque it makes."""

from __future__ import annotations

from exoid.diagnosis.report.material import Context, Material

TITLE = "Measured forces"
ORDER = 32
APPENDIX = True


def context(material: Material) -> Context:
    """Return a row per force; None where the model has none."""
    found = material.comparison or material.diagnosis
    if found is None or not found.forces:
        return None
    model = found.fit.model
    head = ["force", "columns", "acts on the link after the", "m along it", "95 % from", "to", "gain"]
    head += [f"torque at the {joint} [{model.torque_unit}, RMS]" for joint in model.joint_names]
    rows = [
        (
            f.name, ", ".join(f.columns), f.link,
            ", ".join(f"{x:.3g}" for x in f.at) if isinstance(f.at, tuple) else f.at, f.low, f.high, f.gain, *f.torque,
        )
        for f in found.forces
    ]
    return {"head": head, "rows": rows}
