"""The best model leaves more of a torque than a third: wrong columns, or recordings of another machine."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exoid.diagnosis.evidence.channel_doubt import COLUMNS, Doubt, finite, left_share
from exoid.diagnosis.hypotheses.channels import AFTER, Asked
from exoid.symbolic.joints import machine_word
from exoid.symbolic.motion import Float

WHEN, ORDER = AFTER, 10
NOTHING_EXPLAINED = 0.9
"""Share of a torque's variance left from which its joint may have no drive; it only adds to what is advised."""


def doubt(asked: Asked) -> Doubt | None:
    """Doubt with the joints of which so much is left; not of what a curve explains, which is of this motion."""
    last, rules, curve = asked.last, asked.rules, asked.curve
    share = left_share(last)
    if curve is not None:
        share[curve.index] *= 1.0 - curve.joint_share
    if not np.nanmax(share, initial=0.0) > rules.unexplained_share:
        return None
    parts = ", ".join(f"{joint} {100 * x:.0f} %" for joint, x in finite(share, last.model.joint_names))
    machine = machine_word(last.model.joints)
    return Doubt(
        f"the best model leaves more than {100 * rules.unexplained_share:.0f} % of the variance of a torque: {parts}",
        f"The torque is not that of this {machine} in this motion: the best model that was found leaves {parts} of "
        "its variance unexplained. Nothing is named on top of that.",
        COLUMNS + _undriven(share, last.model.joint_names),
    )


def _undriven(share: Float, joints: Sequence[str]) -> str:
    """Advice if the joints of which next to nothing is explained, unlike others, have no drive; "" where none is so."""
    idle = [joint for joint, x in finite(share, joints) if x > NOTHING_EXPLAINED]
    if not idle or len(idle) == len(joints):
        return ""
    options = " ".join(f"--passive {joint}" for joint in idle)
    return f"; if the {' and the '.join(idle)} had no drive in these recordings, say so: {options}"
