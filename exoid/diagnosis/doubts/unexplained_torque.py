"""The best model leaves more of a torque than a third: wrong columns, or recordings of another machine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exoid.diagnosis.doubts import AFTER, Asked
from exoid.diagnosis.evidence.channel_doubt import COLUMNS, Doubt, finite, left_share
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.rules import Rules
from exoid.symbolic.joints import machine_word
from exoid.symbolic.motion import Float

WHEN, ORDER = AFTER, 10
NOTHING_EXPLAINED = 0.9
"""Share of a torque's variance left from which its joint may have no drive; it only adds to what is advised."""


def doubt(asked: Asked) -> Doubt | None:
    """Doubt with the joints, and with the recordings that cannot be explained even alone where others can."""
    last, rules = asked.last, asked.rules
    share = left_share(last)
    if not np.nanmax(share, initial=0.0) > rules.unexplained_share:
        return None
    parts = ", ".join(f"{joint} {100 * x:.0f} %" for joint, x in finite(share, last.model.joint_names))
    odd = _odd_recordings(asked.base, rules)
    files = " and ".join(odd)
    which = f" Fitted alone, {files} cannot be explained either, and the other recordings can." if odd else ""
    machine = machine_word(last.model.joints)
    return Doubt(
        f"the best model leaves more than {100 * rules.unexplained_share:.0f} % of the variance of a torque: {parts}",
        f"The torque is not that of this {machine} in this motion: the best model that was found leaves {parts} of "
        f"its variance unexplained.{which} Nothing is named on top of that.",
        (f"begin with {files}: {COLUMNS}" if odd else COLUMNS) + _undriven(share, last.model.joint_names),
    )


def _undriven(share: Float, joints: Sequence[str]) -> str:
    """Advice if the joints of which next to nothing is explained, unlike others, have no drive; "" where none is so."""
    idle = [joint for joint, x in finite(share, joints) if x > NOTHING_EXPLAINED]
    if not idle or len(idle) == len(joints):
        return ""
    options = " ".join(f"--passive {joint}" for joint in idle)
    return f"; if the {' and the '.join(idle)} had no drive in these recordings, say so: {options}"


def _odd_recordings(base: FittedModel, rules: Rules) -> list[str]:
    """Return the names of recordings of which the model leaves much of the torque even if it is fitted to one alone,
    where it explains the others so; [] where they are alike, or most of them odd.
    """
    evidence, odd, every = base.evidence(seed=0, draws=0, rules=rules), [], base.prepared.all
    for k, (item, step) in enumerate(zip(every, evidence.alone.step, strict=True)):
        own = replace(base.prepared, train=(item,), verify=())
        share = left_share(replace(base, residuals=(evidence.left(k, step),), prepared=own))
        if np.nanmax(share, initial=0.0) > rules.unexplained_share:
            odd.append(item.name)
    return odd if 2 * len(odd) < len(every) else []
