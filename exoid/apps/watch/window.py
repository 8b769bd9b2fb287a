"""A stretch of working samples as a prepared recording, so that fits and evidence take it as any other."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from exoid.apps.watch.front import COMMON_ORDER, SIGN_WIDTH, Filters, Samples, poles
from exoid.ground.thresholds import Threshold
from exoid.optimisation.preparation.cutoff import CutoffChoice
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion

LEAST_WEIGHT: Threshold = 0.3
"""part of the filter's past that was usable: samples made of holes and sticking are fitted"""
STEADY: Threshold = 0.8
"""the same from which a sample tells the numbers: beside a reversal noise of the encoders is a third larger"""


@dataclass(frozen=True, eq=False)
class Window(PreparedRecording):
    """A prepared recording that the causal filters made; `weights` (N, J) are 1 where a sample can be used, `rough` (K,
    J) is the variance in (rad/s²)² that noise of the angles leaves in the accelerations of kept ones; `steady` (J, K)
    says which of these tell the numbers.
    """

    weights: Float
    rough: Float
    steady: np.ndarray
    common: float

    def smooth_rows(self, x: Float, joints: Sequence[int], axis: int, out: Float | None = None) -> Float:
        """Filter `x` (..., N) exactly as the torque was; return the kept samples (..., K), in `out` where it is given.
        """
        shape = [1] * (x.ndim - 1) + [x.shape[-1]]
        shape[axis] = len(joints)
        weights, totals = (each[list(joints)].reshape(shape) for each in (self.weights.T, self._totals))
        smooth = weighted(x, weights, self.common, totals)[..., self.kept]
        if out is None:
            return smooth
        out[:] = smooth
        return out

    @cached_property
    def _totals(self) -> Float:
        return filtered(self.weights.T, self.common)


def filtered(x: Float, common: float) -> Float:
    """Return `x` (..., N) after the filter that is common to all channels."""
    return poles(x, common, np.zeros((COMMON_ORDER, *x.shape[:-1])))[0]


def weighted(x: Float, weights: Float, common: float, totals: Float | None = None) -> Float:
    """Return the weighted mean over the past of `x` (..., N); zero where nothing of the past could be used. `totals`
    are the filtered weights, where they are known.
    """
    totals = filtered(weights, common) if totals is None else totals
    return np.where(totals > 1e-6, filtered(x * weights, common) / np.maximum(totals, 1e-6), 0.0)


def window(name: str, samples: Samples, lead: int, filters: Filters) -> Window:
    """Return the stretch `samples` as a prepared recording; its first `lead` samples only settle the filter."""
    joints = samples.q.shape[1]
    force = samples.force if samples.force.shape[1] else None
    motion = Motion(samples.t, samples.q, samples.dq, samples.ddq, np.tanh(samples.dq / SIGN_WIDTH), force=force)
    total = filtered(samples.good.T, filters.common)
    kept = np.arange(lead, len(samples), filters.stride)
    idle = np.zeros(joints, dtype=bool)
    return Window(
        name=name,
        motion=motion,
        torque=weighted(samples.tau.T, samples.good.T, filters.common, total)[:, kept],
        used=total[:, kept] > LEAST_WEIGHT,
        kept=kept,
        cutoff=filters.cutoff,
        rate=filters.working,
        outliers=np.zeros(joints),
        wide_tau=samples.tau,
        angle_noise=np.zeros(joints),
        band=filters.cutoff,
        stuck=samples.good == 0.0,
        hidden=samples.good == 0.0,
        standing=idle,
        driven=~idle,
        full_rate=filters.rate,
        reach=np.ones(joints),
        weights=samples.good,
        steady=total[:, kept] > STEADY,
        rough=filters.roughness * samples.noise[kept],
        common=filters.common,
    )


def joined_windows(windows: Sequence[Window], most: int) -> tuple[Window, ...]:
    """Return windows as longer ones, each of at most `most` that follow each other without a gap."""
    groups: list[list[Window]] = []
    for item in windows:
        gap = item.t[0] - groups[-1][-1].t[-1] if groups else np.inf
        if 0.0 < gap < 1.5 / item.kept_rate and len(groups[-1]) < most:
            groups[-1].append(item)
        else:
            groups.append([item])
    return tuple(_joined(group) for group in groups)


def _joined(group: Sequence[Window]) -> Window:
    first = group[0]
    if len(group) == 1:
        return first
    cuts = [0, *(int(recording.kept[0]) for recording in group[1:])]  # what only settles the filter is there already
    starts = np.cumsum([0, *(len(entry.motion) - cut for entry, cut in zip(group, cuts, strict=True))])

    def whole(parts: Iterable[Any]) -> Any:
        return np.concatenate([part[cut:] for part, cut in zip(parts, cuts, strict=True)])

    names = ("t", "q", "dq", "ddq", "sign", *(() if first.motion.force is None else ("force",)))
    moved = {n: whole(getattr(item.motion, n) for item in group) for n in names}
    return replace(
        first,
        motion=Motion(**moved),
        torque=np.concatenate([element.torque for element in group], axis=1),
        rough=np.concatenate([part.rough for part in group]),
        steady=np.concatenate([part.steady for part in group], axis=1),
        used=np.concatenate([part.used for part in group], axis=1),
        kept=np.concatenate([part.kept - cut + at for part, cut, at in zip(group, cuts, starts[:-1], strict=True)]),
        wide_tau=whole(part.wide_tau for part in group),
        stuck=whole(part.stuck for part in group),
        hidden=whole(part.hidden for part in group),
        weights=whole(part.weights for part in group),
    )


def prepared(joints: Sequence[Joint], before: Sequence[Window], after: Sequence[Window] = ()) -> Prepared:
    """Return windows as the question of a diagnosis: `before` to be fitted, `after` compared with them."""
    count = len(joints)
    choice = CutoffChoice(before[0].cutoff, "that of the causal filters")
    none = np.zeros(count)
    return Prepared(tuple(before), tuple(after), choice, none, none, 0.0, joints=tuple(joints))


def column_errors(model: Model, q: Float, rough: Float, shape: Float) -> Float:
    """Return the errors (K, J, J, P) that one standard deviation of the noise of each angle makes in the columns of a
    model through its acceleration, at angles `q` (K, J); of less than a hundredth of that, what it makes through angle
    and velocity, nothing is said.
    """
    still = np.zeros_like(q)

    def columns(ddq: Float) -> Float:
        motion = Motion(np.zeros(len(q)), q, still, ddq, still, force=np.zeros((len(q), len(model.channels))))
        none = np.zeros(len(model.parameters)) if model.needs_reference else None
        return np.array(model.columns(motion, shape, none))

    rest, unit = columns(still), np.eye(q.shape[1])
    parts = [np.sqrt(rough[:, a]) * np.moveaxis(columns(still + unit[a]) - rest, 1, 2) for a in range(q.shape[1])]
    return np.transpose(parts, (3, 1, 0, 2))
