"""Does a torque fit far better read earlier, or as what a filter of first order made of it?"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from types import MappingProxyType

import numpy as np

from exoid.diagnosis.evidence.channel_doubt import Doubt, left_share
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gram import inverse_of
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.ties import least_of
from exoid.measurement.signals.masks import Mask, straight_columns
from exoid.measurement.signals.spikes import spikes
from exoid.symbolic.language.torque import is_transform
from exoid.symbolic.motion import Float

DELAYS = (-0.5, -0.35, -0.25, -0.18, -0.13, -0.1, -0.06, -0.03, 0.03, 0.06, 0.1, 0.13, 0.18, 0.25, 0.35, 0.5)
"""Delays of the torque that are tried, s."""
LAGS = (0.03, 0.05, 0.08, 0.12, 0.18, 0.28, 0.45)
"""Time constants of a filter of first order on the torque that are tried, s."""
FAST = (0.003, 0.0045, 0.0065, 0.009, 0.013, 0.018, 0.025, 0.035, 0.05)
"""Delays and time constants in s that are tried where a delay was found."""
SLOW = 0.1
"""Time constant in s by which spikes that a filter smeared are told: whatever it was, its inverse steepens much."""


def late_torque(base: FittedModel, rules: Rules) -> Doubt | None:
    """Doubt where a torque is late, early, or behind a slow filter, by more than a drive can be."""
    share = left_share(base)
    if not np.nanmax(share, initial=0.0) > rules.least_share or np.all(
        base.evaluation_rms < rules.near_noise * base.prepared.noise_floor
    ):
        return None
    readings, joints = _Readings(base, rules), np.isfinite(share)
    alone = np.eye(len(share), dtype=bool)[np.nan_to_num(share) > rules.least_share]
    best = (readings.best(which) for which in (joints, *alone))  # all channels, or that of one joint
    found = next((item for item in best if item is not None), None)
    if found is None or (found.kind == "delay" and abs(found.value) < rules.late_delay):
        return None
    return _wrong_timing(base, found, int(joints.sum()))


def _wrong_timing(base: FittedModel, found: _Reading, joints: int) -> Doubt:
    """Return the doubt that another reading of the torque makes; `joints` of them have one."""
    kind, value, after, which = found.kind, found.value, found.share, found.which
    named = [joint for joint, x in zip(base.model.joint_names, which, strict=True) if x]
    whose = "The torque does" if which.sum() == joints else f"The torque of the {named[0]} does"
    what = (
        f"comes {abs(value):.2g} s {'after' if value > 0 else 'before'} the motion it belongs to"
        if kind == "delay"
        else f"is what a filter of first order with {1.0 / (2.0 * np.pi * value):.2g} Hz leaves of the true one"
    )
    mend = (
        f"shift the torque columns by {abs(value):.2g} s, or find out why the logger is late"
        if kind == "delay"
        else "log the torque before this filter, or take the filter off the sensor's or drive's settings"
    )
    return Doubt(
        f"the squared error falls to {100 * after:.0f} % of itself if the torque {what}",
        f"{whose} not belong to the motion as it is logged: it looks as if it {what}; read so, the model "
        f"leaves {100 * after:.0f} % of the squared error it leaves now.",
        mend,
        after,
    )


def _shifted(tau: Float, samples: float) -> Float:
    """Return `tau` (N, J) as it was logged so many samples later, its ends held."""
    at, places = np.arange(len(tau)) + samples, np.arange(len(tau))
    return np.column_stack([np.interp(at, places, column) for column in tau.T])


def _without_lag(tau: Float, samples: float) -> Float:
    """Torque (N, J) of which a filter of first order with a time constant of so many samples has made `tau`."""
    pole = np.exp(-1.0 / samples)
    return np.concatenate([tau[:1], (tau[1:] - pole * tau[:-1]) / (1.0 - pole)])


@dataclass(frozen=True)
class FilterOnTorque:
    """A torque behind a filter of first order with `hertz`, which explains what a delay does; `doubt` where it explains
    clearly more.
    """

    hertz: float
    doubt: Doubt | None

    @property
    def name(self) -> str:
        """The filter and its frequency in words."""
        return f"a filter of first order on the torque ({self.hertz:.2g} Hz)"


def filtered(without: FittedModel, late: Sequence[int], rules: Rules = RULES) -> FilterOnTorque | None:
    """Return the filter that explains as much as the delays of the torques of the joints `late`, or more.

    `without` is the model that has all but these delays. None where the delays explain clearly more.
    """
    if any(is_transform(term) for term in without.model.terms):
        return None
    readings = _Readings(without, rules)
    seen = readings.now > 0.0
    own = np.isin(np.arange(len(seen)), late)

    def at(kind: str, value: float, which: np.ndarray) -> _Reading:
        share = readings.left(kind, value, which)[seen] / readings.now[seen]
        return _Reading(kind, value, float(np.mean(share)), which)

    def least(kind: str) -> _Reading:
        whose = (seen, own) if (seen & ~own).any() else (own,)
        best = least_of((at(kind, value, which) for value in FAST for which in whose), lambda one: one.share, 1.0)
        finer = [best, *(at(kind, factor * best.value, best.which) for factor in (0.85, 1.18))]
        return least_of(finer, lambda one: one.share, 1.0)

    delay, lag = least("delay"), least("lag")
    if lag.share > delay.share / rules.most or 1.0 - lag.share < rules.half * (1.0 - delay.share):
        return None
    sure = lag.share <= rules.most * min(delay.share, 1.0)
    doubt = _wrong_timing(without, lag, int(seen.sum())) if sure else None
    return FilterOnTorque(1.0 / (2.0 * np.pi * lag.value), doubt)


@dataclass(frozen=True, eq=False)
class _Reading:
    """Another reading of the torques of the joints `which` (J,), with `value` s; it leaves `share` of their error."""

    kind: str
    value: float
    share: float
    which: np.ndarray


CHANGES: Mapping[str, tuple[Callable[[Float, float], Float], tuple[float, ...]]] = MappingProxyType(
    {"delay": (_shifted, DELAYS), "lag": (_without_lag, LAGS)}
)
"""What undoes each kind of wrong timing, and the seconds that are tried."""


class _Readings:
    """The torque of the fitted recordings as it was logged, to be read otherwise and explained anew.

    It is the torque that is changed, not the model: what dry friction does while a joint sticks stays where it is.
    Spikes that a filter smeared are whole again where its inverse was applied, and taken out then.
    """

    def __init__(self, base: FittedModel, rules: Rules) -> None:
        self.train, self.rules = base.prepared.train, rules
        raw, known = zip(*map(base.unfiltered, range(len(self.train))), strict=True)
        self.known = [each.T for each in known]
        parts = [p.smooth_columns(x) for p, x in zip(self.train, raw, strict=True)]
        self.use = np.concatenate([p.used for p in self.train], axis=1)
        self.columns = np.concatenate(parts, axis=1) * self.use[:, :, None]
        flat = self.columns.reshape(-1, self.columns.shape[2])
        self.solve = inverse_of(flat.T @ flat) @ flat.T

    @cached_property
    def smeared(self) -> list[Mask]:
        """Spikes (N, J) of the torques of each recording before a filter."""
        return [spikes(_without_lag(p.wide_tau, SLOW * p.rate), p.rate) for p in self.train]

    @cached_property
    def now(self) -> Float:
        """Share left (J,) of the torques as they are, at most all: numbers of another joint can be worse than none."""
        return np.minimum(self.left(), 1.0)

    @cached_property
    def coarse(self) -> dict[str, dict[float, Float]]:
        """Share left (J,) with all torques changed, by kind and by the seconds that are tried: filters where a delay
        explains a little, too, as it does of what a filter made late.
        """
        found: dict[str, dict[float, Float]] = {}
        for kind, (_, tried) in CHANGES.items():
            left = [each for seconds, each in found.get("delay", {}).items() if seconds > 0.0]
            if kind == "delay" or np.any(np.min(left, axis=0) < self.rules.most * self.now):
                found[kind] = {value: self.left(kind, value) for value in tried}
        return found

    def best(self, which: np.ndarray) -> _Reading | None:
        """Return the reading of the joints `which` that leaves least; None where it leaves much of any of them, or
        where no fitted torque shows them.
        """
        now, little = self.now[which], self.rules.little
        near = [
            (kind, *least_of(tried.items(), lambda item: item[1][which].sum())) for kind, tried in self.coarse.items()
        ]
        fine = {
            (kind, factor * value): self.left(kind, factor * value, which)[which]
            for kind, value, left in near
            for factor in (0.8, 0.9, 1.0, 1.12, 1.25)
            if left[which].sum() <= 2.0 * little * now.sum()
        }
        if not now.sum() > 0.0 or not fine:
            return None
        (kind, value), left = least_of(fine.items(), lambda item: item[1].sum())
        if left.sum() > little * now.sum() or np.any(left > 2.0 * little * now):
            return None
        return _Reading(kind, value, float(left.sum() / now.sum()), which)

    def left(self, kind: str = "", seconds: float = 0.0, which: np.ndarray | None = None) -> Float:
        """Return the share (J,) of its variance that a fit leaves of each torque if those of `which` are changed."""
        tau = np.concatenate([self._read(k, kind, seconds, which) for k in range(len(self.train))], axis=1)
        linear = self.solve @ (tau * self.use).ravel()
        square = np.sum(((tau - self.columns @ linear) * self.use) ** 2, axis=1)
        size = np.array([t[u].var() * u.sum() if u.any() else 0.0 for t, u in zip(tau, self.use, strict=True)])
        return np.divide(square, size, out=np.zeros(len(size)), where=size > 0.0)

    def _read(self, index: int, kind: str, seconds: float, which: np.ndarray | None) -> Float:
        recording = self.train[index]
        if not kind:
            return recording.torque - recording.smooth(self.known[index])
        changed = CHANGES[kind][0](recording.wide_tau, seconds * recording.rate)
        if kind == "lag":
            changed = straight_columns(changed, self.smeared[index])
        changed = changed if which is None else np.where(which, changed, recording.wide_tau)
        return recording.smooth(changed - self.known[index])
