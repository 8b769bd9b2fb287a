"""A measured force counts the other way round than its columns say."""

from __future__ import annotations

from exoid.diagnosis.evidence.channel_doubt import Doubt, turned_round
from exoid.diagnosis.evidence.pushes import wanted_gains
from exoid.diagnosis.hypotheses.channels import BEFORE, Asked
from exoid.measurement.recording import force_unit

WHEN, ORDER = BEFORE, 20


def doubt(asked: Asked) -> Doubt | None:
    """Doubt where the torques want a force multiplied by a negative number."""
    rules = asked.rules
    turned = [
        gain
        for gain in wanted_gains(asked.base)
        if gain.gain + rules.robust * gain.deviation < -rules.half
        and gain.share > rules.little
        and gain.force.gain is not None
    ]
    if not turned:
        return None
    names = " and ".join(entry.force.name for entry in turned)
    columns = [name for item in turned for name in item.force.columns]
    options = turned_round((name, force_unit(name)) for name in columns)
    space = any(element.force.in_space for element in turned)
    positive = "along the axes of their sensor or the base" if space else "forwards and upwards"
    gains = ", ".join(f"{entry.gain:.2g}" for entry in turned)
    return Doubt(
        f"the torques want the {names} multiplied by {gains}",
        f"The {names} counts the other way round: forces act on the machine and are positive {positive}, and "
        f"the torques agree with {', '.join(columns)} only when multiplied by {gains}.",
        f"--units {options}, or sign = -1 in [[forces]]; where only some columns are turned round, those alone",
    )
