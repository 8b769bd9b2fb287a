"""Strides: a motion that comes again and again, cut where one joint passes its middle; torque and error over each.

A stride is one turn of the joint that turns most evenly. Strides differ in length and size, and are laid over one
another by their phase, 0 to 1. Motions whose turns are not alike have none.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.plots import over_the_stride
from exoid.ground.plain import AsJson
from exoid.ground.thresholds import Threshold
from exoid.ground.ties import index_of_least
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.symbolic.joints import Joint
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ALIKE = Threshold(
    0.4,
    "part of the standard deviation of the mean stride, RMS, by which strides differ from it in any angle: motions "
    "that come again in another size every time would be laid over one another",
)
SHORTEST, LONGEST = 0.4, 6.0
"""s, of a stride."""
FEWEST = 5
"""Strides of all recordings together."""
COVERED = 0.6
"""Part of the time that strides take at least."""
PHASES = 50
"""Points of a stride."""
STILL = 0.02
"""rad, or tenths of a metre: standard deviation below which a joint does not move."""


@dataclass(frozen=True, eq=False)
class Strides(AsJson):
    """Strides of the recordings that are shown, over which torque and error are laid.

    `seconds` each takes, from `shortest` to `longest`; they begin where `joint` passes `middle` (rad, m) forwards.
    `phase` (P,); over it the measured torque (J, P) and its standard deviation from stride to stride, that of the
    model, and the error with its own, N·m; NaN where nothing was used. `again` (J,) is the share of the error's power
    that comes again in every stride.
    """

    JSON = (
        "count seconds shortest longest joint middle again apart error_apart phase measured measured_band model error "
        "error_band sentence"
    )

    count: int
    seconds: float
    shortest: float
    longest: float
    joint: str
    middle: float
    phase: Float
    measured: Float
    measured_band: Float
    model: Float
    error: Float
    error_band: Float
    again: Float
    joints: tuple[Joint, ...] = field(repr=False)

    @property
    def apart(self) -> Float:
        """RMS (J,) of how far the measured torque is from its mean stride, N·m."""
        return _over_phases(self.measured_band)

    @property
    def error_apart(self) -> Float:
        """The same of the error."""
        return _over_phases(self.error_band)

    @property
    def sentence(self) -> str:
        """How many strides, and how far torque and error come again, in words."""
        parts = [
            f"{joint.name}: the torque differs by {a:.3g} {joint.unit('tau')} from stride to stride, the error by "
            f"{e:.3g}, and {100 * s:.0f} % of the error come again in every stride"
            for joint, a, e, s in zip(self.joints, self.apart, self.error_apart, self.again, strict=True)
        ]
        length = f"{self.seconds:.2g} s ({self.shortest:.2g} to {self.longest:.2g})"
        return f"{self.count} strides of {length}. {'; '.join(parts)}."

    def plot(self) -> Figure:
        """Draw measured torque, model and error over the stride: means, and bands of one standard deviation."""
        lines = (self.measured, self.measured_band, self.model, self.error, self.error_band)
        return over_the_stride(self.phase, *lines, self.joints)


def strides_of(fitted: FittedModel) -> Strides | None:
    """Return the strides of the recordings that are held out, or of all; None where the motion has none."""
    prepared = fitted.prepared
    shown = range(len(prepared.train) if prepared.verify else 0, len(prepared.all))
    cuts = [cut(prepared.all[index]) for index in shown]
    found = [one for one in cuts if one is not None]
    if not found:
        return None
    # One joint cuts them all, that of most recordings, so that phases mean the same.
    joints = [one[0] for one in found]
    joint = max(sorted({*joints}), key=joints.count)
    torques: list[Float] = []
    models: list[Float] = []
    rests: list[Float] = []
    lengths: list[float] = []
    middles = []
    for index, one in zip(shown, cuts, strict=True):
        if one is None or one[0] != joint:
            continue
        recording = prepared.all[index]
        middles.append(one[1])
        used = recording.used
        for begin, end in one[2]:
            at = np.linspace(begin, end, PHASES, endpoint=False)
            whole = [fitted.torque(index), fitted.residuals[index], recording.torque]
            rows = [np.where(_at(used.astype(float), at) > 0.99, _at(part, at), np.nan) for part in whole]
            models.append(rows[0])
            rests.append(rows[1])
            torques.append(rows[2])
            lengths.append((end - begin) / recording.kept_rate)
    if len(lengths) < FEWEST:
        return None
    measured, rest, model = (np.array(part) for part in (torques, rests, models))
    return Strides(
        count=len(lengths),
        seconds=float(np.median(lengths)),
        shortest=min(lengths),
        longest=max(lengths),
        joint=fitted.model.joint_names[joint],
        middle=float(np.mean(middles)),
        phase=np.arange(PHASES) / PHASES,
        measured=_mean(measured),
        measured_band=_deviation(measured),
        model=_mean(model),
        error=_mean(rest),
        error_band=_deviation(rest),
        again=_again(rest),
        joints=tuple(fitted.model.joints),
    )


def cut(one: PreparedRecording) -> tuple[int, float, list[tuple[float, float]]] | None:
    """Return by which joint a prepared recording is cut, where that has its middle, and begin and end of every stride
    in kept samples; None where it has no strides.
    """
    q, rate = one.motion.q[one.kept], one.kept_rate
    moving = np.flatnonzero(q.std(axis=0) > STILL * np.asarray(one.reach))
    period = _period(q[:, moving], rate) if moving.size else None
    if period is None:
        return None
    tried = [(joint, _passes(q[:, joint], period)) for joint in moving]
    uneven = [np.std(np.diff(at)) / np.mean(np.diff(at)) if len(at) > 3 else np.inf for _, at in tried]
    joint, at = tried[index_of_least([float(x) for x in uneven], 1.0)]
    usual = float(np.median(np.diff(at))) if len(at) > 1 else 0.0
    pairs = [(a, b) for a, b in pairwise(at) if 0.7 * usual < b - a < 1.4 * usual]
    if len(pairs) < 2 or sum(b - a for a, b in pairs) < COVERED * len(q):
        return None
    curves = np.array([_at(q[:, moving].T, np.linspace(a, b, PHASES, endpoint=False)) for a, b in pairs])
    usual_curve = curves.mean(axis=0)
    away = np.sqrt(np.mean((curves - usual_curve) ** 2, axis=(0, 2))) / np.maximum(usual_curve.std(axis=1), 1e-12)
    return (int(joint), float(q[:, joint].mean()), pairs) if np.all(away < ALIKE) else None


def _period(q: Float, rate: float) -> float | None:
    """Return after how many samples angles (N, J) come again first; None where they do not."""
    x = (q - q.mean(axis=0)) / q.std(axis=0)
    size = 2 * len(x)
    alike = np.fft.irfft(np.abs(np.fft.rfft(x, size, axis=0)) ** 2, size, axis=0)[: len(x)].mean(axis=1)
    alike = alike / (len(x) - np.arange(len(x)))
    first, last = int(SHORTEST * rate), min(int(LONGEST * rate), len(x) // 3)
    peaks = [k for k in range(max(first, 1), last) if alike[k - 1] <= alike[k] > alike[k + 1]]
    best = max((alike[k] for k in peaks), default=0.0)
    return next((float(k) for k in peaks if alike[k] > 0.8 * best), None) if best > 0.3 else None


def _passes(x: Float, period: float) -> list[float]:
    """Return at which samples (fractions) an angle (N,) passes its middle forwards, once in a period."""
    width = max(1, round(period / 4.0))
    smooth = np.convolve(x - x.mean(), np.ones(width) / width, mode="same")
    before = np.flatnonzero((smooth[:-1] < 0.0) & (smooth[1:] >= 0.0))
    at = before + smooth[before] / (smooth[before] - smooth[before + 1])
    kept: list[float] = []
    for place in at:
        if not kept or place - kept[-1] > 0.5 * period:
            kept.append(float(place))
    return kept


def _at(rows: Float, at: Float) -> Float:
    """Return rows (J, K) at the samples `at` (P,), between them along straight lines."""
    places = np.arange(rows.shape[1])
    return np.array([np.interp(at, places, row) for row in rows])


def _mean(x: Float) -> Float:
    """Return the mean (J, P) of strides (S, J, P) where at least half of them have one, NaN elsewhere."""
    known = np.isfinite(x)
    count = known.sum(axis=0)
    total = np.where(known, x, 0.0).sum(axis=0)
    return np.where(count >= 0.5 * max(len(x), 2), total / np.maximum(count, 1), np.nan)


def _deviation(x: Float) -> Float:
    """Return the standard deviation (J, P) of strides (S, J, P)."""
    return np.asarray(np.sqrt(_mean((x - _mean(x)) ** 2)))


def _over_phases(band: Float) -> Float:
    known = np.isfinite(band)
    square = np.where(known, band, 0.0) ** 2
    return np.asarray(np.sqrt(square.sum(axis=1) / np.maximum(known.sum(axis=1), 1)))


def _again(rest: Float) -> Float:
    """Return the share (J,) of the power of errors (S, J, P) that two strides have in common."""
    known = np.isfinite(rest)
    x = np.where(known, rest, 0.0)
    total, count = x.sum(axis=0), known.sum(axis=0)
    square = (x**2).sum(axis=0)
    pairs = np.maximum(count * (count - 1), 1)
    common = np.where(count > 1, (total**2 - square) / pairs, 0.0).sum(axis=1)
    whole = np.where(count > 1, square / np.maximum(count, 1), 0.0).sum(axis=1)
    return np.asarray(np.clip(common / np.maximum(whole, 1e-300), 0.0, 1.0))
