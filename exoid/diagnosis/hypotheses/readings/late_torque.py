"""Torques that were logged much later, or earlier, than the motion that they belong to: no drive is as late."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

from exoid.diagnosis.evidence.channel_doubt import Doubt
from exoid.diagnosis.hypotheses.readings import only_in_part, unless_misread, wrong_torques
from exoid.diagnosis.hypotheses.recordings import listed
from exoid.diagnosis.rules import RULES
from exoid.optimisation.fitting.fit import Fit
from exoid.symbolic.effect import Effect, Shape

LATEST = 0.6
"""s by which a torque may be late: beyond, nobody would take its file for one of that motion."""

EFFECT = Effect(
    id="late_torque",
    title="A torque logged at another time",
    explains="The torque is logged long after, or before, the motion that belongs to it.",
    torque="delay(tau_model, side * d) - tau_model",
    shape={
        "d": Shape("s", RULES.late_delay, LATEST, spacing="log", points=13),
        "side": Shape("1", -1.0, 1.0, choices=(1.0, -1.0)),
    },
    family="reading",
    drive=True,
    custom=True,
)

entry = partial(unless_misread, EFFECT)
objection = only_in_part


def what_is_wrong(fit: Fit, names: Sequence[str]) -> Doubt:
    """Doubt about torques, with the times by which they are late."""
    seconds = {name: fit.estimate(f"{name}.d").value for name in names}
    sides = {name: fit.estimate(f"{name}.side").value for name in names}
    when = {name: "before" if side < 0.0 else "after" for name, side in sides.items()}
    what = {name: f"comes {late:.2g} s {when[name]} the motion it belongs to" for name, late in seconds.items()}
    times: dict[str, list[str]] = {}
    for name, late in seconds.items():
        times.setdefault(f"{late:.2g} s", []).append(name.partition(":")[2])
    shifts = " and ".join(f"the torque of the {listed(joints)} by {late}" for late, joints in times.items())
    return wrong_torques(what, f"shift {shifts}, or find out why the logger is late")
