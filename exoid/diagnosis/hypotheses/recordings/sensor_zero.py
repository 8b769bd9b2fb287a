"""The torque sensor's zero is set anew before each recording.

Of a joint that weighs, or hangs on a spring, the zero of its encoder shifts the torque by nearly a constant, too.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exoid.diagnosis.hypotheses.recordings import OTHERS, Claim, StateColumn, at_joint, each_said, than_usual
from exoid.symbolic.model import Model


def claims(model: Model, columns: Sequence[StateColumn]) -> tuple[Claim, ...]:
    """Return a zero of each torque sensor in every recording."""
    return tuple(
        Claim("sensor_zero", joint.name, joint.unit("tau"), at_joint(k, lambda seen: np.ones(len(seen.t))),
              (-np.inf, np.inf), drive=True, everyone=True)
        for k, joint in enumerate(model.joints)
    )  # fmt: skip


def said(claim: Claim, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on the zeros {recording: words}."""
    another = f"{claim.place} torque sensor (or its encoder) has another zero"
    if when:
        return f"{than_usual(another, when)}: {each_said(values)}"
    if len(values) > 1 and len(set(values.values())) == 1:
        return f"The zero of the {claim.place} torque sensor is {next(iter(values.values()))} in all recordings"
    if len(values) == 1:
        return f"The {claim.place} torque sensor (or its encoder) has a zero of its own: {each_said(values)}"
    where = "than in the other recordings" if OTHERS in values else "in each recording"
    return f"The {another} {where}: {each_said(values)}"
