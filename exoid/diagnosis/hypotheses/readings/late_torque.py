"""Torques that were logged much later, or earlier, than the motion that they belong to: no drive is as late. Files of
two loggers that were started by hand have a time of their own each.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from exoid.diagnosis.evidence.channel_doubt import Doubt
from exoid.diagnosis.hypotheses.readings import only_in_part, unless_misread, wrong_torques
from exoid.diagnosis.hypotheses.recordings import listed
from exoid.diagnosis.rules import Rules
from exoid.optimisation.fitting.fit import Fit
from exoid.symbolic.effect import Effect, Shape
from exoid.symbolic.motion import Float

LATEST = 0.6
"""s by which a torque may be late: beyond, nobody would take its file for one of that motion."""

EFFECT = Effect(
    id="late_torque",
    title="A torque logged at another time",
    explains="The torque is logged long after, or before, the motion that belongs to it.",
    torque="delay(tau_model, d) - tau_model",
    shape={"d": Shape("s", -LATEST, LATEST, points=25, per_recording=True)},
    family="reading",
    drive=True,
    custom=True,
)

entry = partial(unless_misread, EFFECT)


def objection(fit: Fit, name: str, explained: float, rules: Rules) -> str:
    """Objection to delays that a drive may have, or that do not explain most of what is left."""
    latest = float(np.abs(_delays(fit, name)).max())
    if latest < rules.late_delay:
        return f"the torque would be late by {latest:.2g} s, as a drive or a bus may be"
    return only_in_part(fit, name, explained, rules)


def what_is_wrong(fit: Fit, names: Sequence[str]) -> Doubt:
    """Doubt about torques, with the times by which they are late in each recording."""
    logged, joints = {}, dict[str, list[str]]()
    for name in names:
        late = _delays(fit, name)
        first, last = np.sort(np.abs(late))[[0, -1]]
        when = "after" if late.min() >= 0.0 else "before" if late.max() <= 0.0 else "before or after"
        alike = first == last
        logged[name] = f"comes {last:g} s" if alike else f"comes {first:g} to {last:g} s"
        logged[name] += f" {when} the motion it belongs to"
        each = [f"{run} {x:g} s" for run, x in zip(fit.recordings, late, strict=True)]
        joints.setdefault(f"{last:g} s" if alike else ", ".join(each), []).append(name.partition(":")[2])
    shifts = " and ".join(f"the torque of the {listed(some)} by {late}" for late, some in joints.items())
    return wrong_torques(logged, f"shift {shifts}, or find out why the logger is late")


def _delays(fit: Fit, name: str) -> Float:
    """Times (R,) in s by which a torque is late in each recording, to a hundredth."""
    return np.round(fit.shapes[:, [entry.name for entry in fit.model.shapes].index(f"{name}.d")], 2)
