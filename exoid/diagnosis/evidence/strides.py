"""Torque, model and error over the stride: strides of a walk, laid over one another by their phase, 0 to 1."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.plots import over_the_stride
from exoid.ground.plain import AsJson
from exoid.optimisation.preparation.strides import PHASES, over_phases
from exoid.symbolic.joints import Joint
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    from matplotlib.figure import Figure

FEWEST = 5
"""Strides of all recordings together."""


@dataclass(frozen=True, eq=False)
class Strides(AsJson):
    """Strides of the recordings that are shown, over which torque and error are laid.

    `seconds` each takes, from `shortest` to `longest`; they begin where the foot comes down, or, with a `joint`, where
    that passes `middle` (rad, m) forwards. `stance` is the part in which a foot is known to be on the ground, NaN where
    nobody measured it. `phase` (P,); over it the measured torque (J, P) and its standard deviation from stride to
    stride, that of the model, and the error with its own, N·m; NaN where nothing was used. `again` (J,) is the share of
    the error's power that comes again in every stride.
    """

    count: int
    seconds: float
    shortest: float
    longest: float
    joint: str | None
    middle: float
    stance: float
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
        """Sentence on the number of strides, and how far torque and error come again."""
        parts = [
            f"{joint.name}: the torque differs by {a:.3g} {joint.unit('tau')} from stride to stride, the error by "
            f"{e:.3g}, and {100 * s:.0f} % of the error come again in every stride"
            for joint, a, e, s in zip(self.joints, self.apart, self.error_apart, self.again, strict=True)
        ]
        length = f"{self.seconds:.2g} s ({self.shortest:.2g} to {self.longest:.2g})"
        return f"{self.count} strides of {length}, {self.begin}. {'; '.join(parts)}."

    @property
    def begin(self) -> str:
        """From where to where a stride goes, in words."""
        if self.joint is None:
            return f"from one step of the foot to its next, {100.0 * self.stance:.0f} % of each on the ground"
        unit = next(joint.unit("q") for joint in self.joints if joint.name == self.joint)
        return f"each from where the {self.joint} passes {self.middle:.2g} {unit} forwards"

    def plot(self) -> Figure:
        """Draw measured torque, model and error over the stride: means, and bands of one standard deviation."""
        lines = (self.measured, self.measured_band, self.model, self.error, self.error_band)
        return over_the_stride(self.phase, *lines, self.joints, self.stance)

    def _json(self) -> dict[str, Any]:
        told = {name: getattr(self, name) for name in ("apart", "error_apart", "sentence")}
        return {name: value for name, value in super()._json().items() if name != "joints"} | told


def strides_of(fitted: FittedModel) -> Strides | None:
    """Return the strides of the recordings that are held out, or of all; None where the motion has none."""
    prepared = fitted.prepared
    shown = range(len(prepared.train) if prepared.verify else 0, len(prepared.all))
    found = {index: cut for index in shown if (cut := prepared.all[index].strides) is not None}
    if not found:
        return None
    # All are cut alike, as most recordings are, so that phases mean the same.
    cut_by = [cut.joint for cut in found.values()]
    joint = max(cut_by, key=cut_by.count)
    found = {index: cut for index, cut in found.items() if cut.joint == joint}
    curves: list[list[Float]] = []
    for index, cut in found.items():
        recording = prepared.all[index]
        rows = [fitted.torque(index), fitted.residuals[index], recording.torque]
        for ends in cut.ends:
            used = over_phases(recording.used.astype(float), ends) > 0.99
            curves.append([np.where(used, over_phases(part, ends), np.nan) for part in rows])
    if len(curves) < FEWEST:
        return None
    model, rest, measured = np.array(curves).swapaxes(0, 1)
    lengths = np.concatenate([np.diff(cut.ends)[:, 0] / prepared.all[k].kept_rate for k, cut in found.items()])
    return Strides(
        count=len(curves),
        seconds=float(np.median(lengths)),
        shortest=float(lengths.min()),
        longest=float(lengths.max()),
        joint=None if joint is None else fitted.model.joint_names[joint],
        middle=float(np.mean([cut.middle for cut in found.values()])),
        stance=float(np.mean([cut.stance for cut in found.values()])),
        phase=np.arange(PHASES) / PHASES,
        measured=_mean(measured),
        measured_band=_deviation(measured),
        model=_mean(model),
        error=_mean(rest),
        error_band=_deviation(rest),
        again=_again(rest),
        joints=tuple(fitted.model.joints),
    )


def _mean(x: Float) -> Float:
    """Return the mean (J, P) of strides (S, J, P) where at least half of them have one, NaN elsewhere."""
    count = np.isfinite(x).sum(axis=0)
    return np.where(count >= 0.5 * max(len(x), 2), np.nansum(x, axis=0) / np.maximum(count, 1), np.nan)


def _deviation(x: Float) -> Float:
    return np.asarray(np.sqrt(_mean((x - _mean(x)) ** 2)))


def _over_phases(band: Float) -> Float:
    return np.asarray(np.sqrt(np.nansum(band**2, axis=1) / np.maximum(np.isfinite(band).sum(axis=1), 1)))


def _again(rest: Float) -> Float:
    """Return the share (J,) of the power of errors (S, J, P) that two strides have in common."""
    total, square, count = np.nansum(rest, axis=0), np.nansum(rest**2, axis=0), np.isfinite(rest).sum(axis=0)
    pairs = np.maximum(count * (count - 1), 1)
    common = np.where(count > 1, (total**2 - square) / pairs, 0.0).sum(axis=1)
    whole = np.where(count > 1, square / np.maximum(count, 1), 0.0).sum(axis=1)
    return np.asarray(np.clip(common / np.maximum(whole, 1e-300), 0.0, 1.0))
