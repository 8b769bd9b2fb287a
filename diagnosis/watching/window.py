"""A stretch of working samples as a prepared recording, so that fits and evidence take it as any other."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from diagnosis.watching.front import COMMON_ORDER, SIGN_WIDTH, Filters, Samples, poles
from optimisation.preparation.prepare import CutoffChoice, Prepared, PreparedRecording
from symbolic.motion import Float, Motion

LEAST_WEIGHT = 0.3
"""Part of the second filter's past that must have been usable for a sample to be fitted."""


@dataclass(frozen=True, eq=False)
class Window(PreparedRecording):
    """A prepared recording that the causal filters made; `weights` (N, J) are 1 where a sample can be used."""

    weights: Float
    common: float

    def smooth_rows(self, x: Float, joints: Sequence[int], axis: int) -> Float:
        """Filter `x` (..., N) exactly as the torque was; return the kept samples (..., K)."""
        shape = [1] * (x.ndim - 1) + [x.shape[-1]]
        shape[axis] = len(joints)
        return weighted(x, self.weights.T[list(joints)].reshape(shape), self.common)[..., self.kept]


def weighted(x: Float, weights: Float, common: float) -> Float:
    """Return the weighted mean over the past of `x` (..., N); zero where nothing of the past could be used."""
    done, _ = poles(x * weights, common, np.zeros((COMMON_ORDER, *x.shape[:-1])))
    total, _ = poles(weights, common, np.zeros((COMMON_ORDER, *weights.shape[:-1])))
    return np.where(total > 1e-6, done / np.maximum(total, 1e-6), 0.0)


def window(name: str, samples: Samples, lead: int, filters: Filters) -> Window:
    """Return the stretch `samples` as a prepared recording; its first `lead` samples only settle the filter."""
    joints = samples.q.shape[1]
    motion = Motion(samples.t, samples.q, samples.dq, samples.ddq, np.tanh(samples.dq / SIGN_WIDTH))
    total, _ = poles(samples.good.T, filters.common, np.zeros((COMMON_ORDER, joints)))
    kept = np.arange(lead, len(samples), filters.stride)
    idle = np.zeros(joints, dtype=bool)
    return Window(
        name=name,
        motion=motion,
        tau=weighted(samples.tau.T, samples.good.T, filters.common).T[kept],
        use=total.T[kept] > LEAST_WEIGHT,
        kept=kept,
        cutoff=filters.cutoff,
        rate=filters.working,
        outliers=np.zeros(joints),
        wide_tau=samples.tau,
        angle_noise=np.zeros(joints),
        band=filters.cutoff,
        stuck=samples.good == 0.0,
        standing=idle,
        driven=~idle,
        full_rate=filters.rate,
        reach=np.ones(joints),
        weights=samples.good,
        common=filters.common,
    )


def prepared(before: Sequence[Window], after: Sequence[Window] = ()) -> Prepared:
    """Return windows as the question of a diagnosis: `before` to be fitted, `after` compared with them."""
    joints = before[0].use.shape[1]
    choice = CutoffChoice(before[0].cutoff, "that of the causal filters", automatic=False)
    return Prepared(tuple(before), tuple(after), choice, np.zeros(joints), np.zeros(joints), 0.0)
