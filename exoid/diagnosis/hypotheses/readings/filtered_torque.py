"""Torques behind a slow filter of first order, while the angles are not."""

from __future__ import annotations

import math
from collections.abc import Sequence
from functools import partial

from exoid.diagnosis.evidence.channel_doubt import Doubt
from exoid.diagnosis.hypotheses.readings import only_in_part, unless_misread, wrong_torques
from exoid.optimisation.fitting.fit import Fit
from exoid.symbolic.effect import Effect, Shape

EFFECT = Effect(
    id="filtered_torque",
    title="A filter of first order on the torque",
    explains="The torque was filtered before it was logged, and the angles were not.",
    torque="lag(tau_model, T) - tau_model",
    shape={"T": Shape("s", 0.003, 0.6, spacing="log", points=13)},
    family="reading",
    drive=True,
    custom=True,
)

entry = partial(unless_misread, EFFECT)
objection = only_in_part


def what_is_wrong(fit: Fit, names: Sequence[str]) -> Doubt:
    """Doubt about torques, with the frequencies of their filters."""
    hertz = {name: 1.0 / (2.0 * math.pi * fit.estimate(f"{name}.T").value) for name in names}
    what = {k: f"is what a filter of first order with {f:.2g} Hz leaves of the true one" for k, f in hertz.items()}
    remedy = "log the torque before this filter, or take the filter off the sensor's or drive's settings"
    return wrong_torques(what, remedy)
