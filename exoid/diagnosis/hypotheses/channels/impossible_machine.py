"""An effect had to rescue a rigid machine that explains little and could not exist."""

from __future__ import annotations

import numpy as np

from exoid.diagnosis.evidence.channel_doubt import COLUMNS, Doubt, finite, left_share
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.hypotheses.channels import AFTER, Asked
from exoid.measurement.finding import Finding
from exoid.symbolic.joints import machine_word

WHEN, ORDER = AFTER, 20


def doubt(asked: Asked) -> Doubt | None:
    """Doubt where that is so. One that leaves next to the noise, or little of the torque, with numbers that are
    possible, was not rescued: a strong spring is no wrong channel.
    """
    base, last, rules = asked.base, asked.last, asked.rules
    share, wrong = left_share(base), _impossible(base)
    if not np.nanmax(share, initial=0.0) > rules.half or not wrong:
        return None
    near = np.all(last.evaluation_rms <= rules.near_noise * last.prepared.noise_floor)
    if not _impossible(last) and (near or np.nanmax(left_share(last), initial=0.0) <= rules.worth_telling):
        return None
    parts = ", ".join(f"{joint} {100 * x:.0f} %" for joint, x in finite(share, base.model.joint_names))
    machine = machine_word(base.model.joints)
    return Doubt(
        f"the rigid {machine} leaves {parts} of the torque's variance, and its numbers are impossible "
        f"({wrong[0].what})",
        f"The channels do not fit a {machine}: weight, inertia and friction together leave {parts} of the torque's "
        f"variance unexplained, with numbers that no {machine} has. What then explains the rest only makes up for a "
        "wrong sign, zero or column.",
        COLUMNS,
    )


def _impossible(fitted: FittedModel) -> list[Finding]:
    """Findings that the numbers are those of no machine."""
    wrong = ("bounds", "inertia", "realisable")
    return [f for f in fitted.fit.plausibility if f.severity == "warning" and f.check in wrong]
