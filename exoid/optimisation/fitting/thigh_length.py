"""Thigh length that the data want. The leg's equations contain it, so recordings of good motion can tell.

The weight of the shank and its coupling with the thigh have the ratio e = g / a_th. With a weight of its own for the
shank (one more column, sin(θ1 + θ2) on both joints) the torque stays linear, and the ratio of both numbers is the thigh
length, with Fieller's interval (Fieller 1954) from the covariance that is valid under autocorrelated residuals.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.ground.plain import AsJson
from exoid.ground.thresholds import Threshold
from exoid.measurement.finding import EVERY, Finding
from exoid.optimisation.linear.problem import LinearData
from exoid.optimisation.linear.solve import solve_huber
from exoid.optimisation.linear.uncertainty import covariance
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    from exoid.optimisation.fitting.fit import Fit
    from exoid.optimisation.preparation.filtering import PreparedRecording
    from exoid.optimisation.preparation.prepare import Prepared
    from exoid.symbolic.model import Model

COUPLING = "Phi3"
FAR: Threshold = 0.2
"""share by which a length is off: what else is missing moves it by a tenth (on two known rigs)"""
HELPS: Threshold = 0.1
"""part of a joint's squared error that the other length removes: one that explains nothing"""
VAGUE: Threshold = 2.0
"""factor between the ends of an interval: a length that the data do not know"""


@dataclass(frozen=True)
class ThighLength(AsJson):
    """The thigh length in m that was `assumed`, and the `value` that the data want with its 95 % interval.

    `high` is infinite where the data set no limit. `gain` (J,) is the share by which a free length lowers the squared
    error.
    """

    assumed: float
    value: float
    low: float
    high: float
    gain: tuple[float, ...]

    @property
    def told(self) -> bool:
        """True if these data can tell the length."""
        return math.isfinite(self.value) and 0.0 < self.high < VAGUE * self.low

    @property
    def wrong(self) -> bool:
        """True if the data contradict the length that was assumed."""
        outside = not self.low <= self.assumed <= self.high
        far = abs(self.value - self.assumed) > FAR * self.assumed
        return self.told and outside and far and max(self.gain) > HELPS

    @property
    def sentence(self) -> str:
        """The answer in words."""
        if not self.told:
            return f"these recordings cannot tell the thigh length; {self.assumed:g} m is assumed"
        text = f"these recordings want a thigh length of {self.value:.3g} m ({self.low:.3g} to {self.high:.3g})"
        if self.wrong:
            return f"{text}, not the {self.assumed:g} m of the model; the squared error falls by {max(self.gain):.0%}"
        inside = self.low <= self.assumed <= self.high
        return f"{text}; the {self.assumed:g} m of the model {'agree' if inside else 'are near enough'}"

    def finding(self) -> Finding:
        """Return the answer as a finding: a warning where the length seems to be wrong."""
        said = self.sentence, EVERY, self.value if self.told else None, self.assumed
        if not self.wrong:
            return Finding("thigh_length", "info", *said)
        remedy = f"measure it, and give it in a model file: [geometry] thigh_length = {self.value:.3g}"
        consequence = "Φ1 to Φ4 and every torque of weight are wrong"
        return Finding("thigh_length", "warning", *said, remedy, consequence, "likely")

    def _json(self) -> dict[str, Any]:
        return {
            "assumed": self.assumed, "value": self.value, "low": self.low, "high": self.high, "told": self.told,
            "wrong": self.wrong, "sentence": self.sentence,
        }  # fmt: skip


def has_a_length(model: Model, prepared: Prepared) -> bool:
    """True if a model has a thigh length that recordings may tell: the leg without a payload and without forces."""
    loaded = bool(model.forces) or any(recording.motion.payload is not None for recording in prepared.train)
    return not (prepared.misread or model.chain or loaded)


def wanted_thigh_length(fit: Fit, prepared: Prepared) -> ThighLength | None:
    """Return the thigh length that the fitted recordings of `prepared` want; None for models that have none to tell,
    for recordings that keep another convention, and for others than those that were fitted.

    The torque sensors may have offsets of their own meanwhile, which would otherwise pass for weight.
    """
    model, names = fit.model, list(fit.data.names)
    if not has_a_length(model, prepared) or COUPLING not in names:
        return None
    weight = np.concatenate([_weight(recording) for recording in prepared.train], axis=1)[:, :, None]
    recordings = tuple(recording.name for recording in prepared.train)
    if fit.recordings != recordings or fit.data.tau.shape != weight.shape[:2]:
        return None
    zeros = np.broadcast_to(np.eye(weight.shape[0])[:, None, :], (*weight.shape[:2], weight.shape[0]))
    with_zeros = _data(fit, zeros, "zero")
    data = _data(fit, np.concatenate([zeros, weight], axis=2), "zero")
    linear = solve_huber(data, fit.limits)
    left = with_zeros.rms(solve_huber(with_zeros, fit.limits))
    gain = 1.0 - (data.rms(linear) / np.maximum(left, 1e-300)) ** 2
    spread = covariance(data.columns, data.residual(linear), fit.limits, data.groups, factor=data.factor)
    pick = [names.index(COUPLING), linear.size - 1]
    value, low, high = math.nan, 0.0, math.inf
    if not set(pick) & set(spread.undetermined):
        e = model.gravity / model.thigh_length
        coupling, extra = linear[pick]
        area = spread.critical**2 * spread.matrix[np.ix_(pick, pick)]
        value = float(model.gravity / (e + extra / coupling)) if e * coupling + extra else math.nan
        low, high = _fieller(coupling, extra + e * coupling, _shifted(area, e), model.gravity)
    return ThighLength(model.thigh_length, value, low, high, tuple(float(x) for x in gain))


def _data(fit: Fit, extra: Float, name: str) -> LinearData:
    """Return the weighted data of `fit` with columns `extra` (J, K, E) more."""
    data, count = fit.data, extra.shape[2]
    names = (*data.names, *(f"{name} {k}" for k in range(count)))
    return LinearData(
        np.concatenate([data.columns, extra], axis=2), data.tau, data.groups, names, (*data.units, *("N·m",) * count),
        data.use,
    ).weighted(fit.weight)  # fmt: skip


def _shifted(area: Float, e: float) -> Float:
    """Return the covariance (2, 2) of (coupling, weight) from that of (coupling, weight - e coupling)."""
    turn = np.array([[1.0, 0.0], [e, 1.0]])
    return np.asarray(turn @ area @ turn.T)


def _fieller(coupling: float, weight: float, area: Float, gravity: float) -> tuple[float, float]:
    """Return the interval of gravity · coupling / weight; (0, inf) where it has no end."""
    # all lengths x with (coupling - x weight / g)² ≤ its variance
    a = weight**2 - area[1, 1]
    b = weight * coupling - area[0, 1]
    c = coupling**2 - area[0, 0]
    root = b * b - a * c
    if a <= 0.0 or root < 0.0:
        return 0.0, math.inf
    ends = sorted(float(gravity) * float((b + sign * math.sqrt(root)) / a) for sign in (-1.0, 1.0))
    return (max(ends[0], 0.0), ends[1]) if ends[1] > 0.0 else (0.0, math.inf)


def _weight(one: PreparedRecording) -> Float:
    """Return the column (J, K) of a weight at the shank, filtered like the torque."""
    column = np.sin(one.motion.q.sum(axis=1))
    return one.smooth(np.repeat(column[:, None], one.motion.q.shape[1], axis=1))
