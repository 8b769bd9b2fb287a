"""What no model can get below: noise of the torque and of the angles, and what filter and derivatives get wrong."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from measurement.signals.conditioning import fine_derivatives, low_pass, quiet_noise
from optimisation.preparation.filtering import PreparedRecording
from symbolic.model import Model
from symbolic.motion import Float, Motion


def noise_floor(prepared: Sequence[PreparedRecording], cutoff: float) -> Float:
    """Return the RMS (J,) in N·m that sensor noise leaves below the cut-off, from the top of the torque's spectrum.

    Estimated without a model, from recordings in which the joint is driven: a torque that is zero for certain has no
    noise. Where a joint may be sticking its controller chatters, and no model is fitted: that is left out. A torque
    sensor whose noise is not white has a floor of its own; this one is then low.
    """
    square = np.array([quiet_noise(p.wide_tau, p.rate, cutoff, p.stuck) ** 2 for p in prepared])
    driven = np.array([p.driven for p in prepared])
    return np.sqrt(np.sum(square, axis=0, where=driven) / np.maximum(driven.sum(axis=0), 1))


def torque_of_filter(base: Model, beta: Float, prepared: Sequence[PreparedRecording]) -> list[Float]:
    """Return for each recording what filter and derivatives get wrong, (J, K) N·m: the model's torque once more with
    the angles filtered twice and differentiated more exactly.
    """
    out = []
    for one in prepared:
        q = low_pass(one.motion.q, one.band, one.rate)
        dq, ddq = fine_derivatives(q, one.rate)
        out.append(
            _torque_change(base, beta, one, q, np.where(one.standing, 0.0, dq), np.where(one.standing, 0.0, ddq))
        )
    return out


def torque_of_noise(base: Model, beta: Float, prepared: Sequence[PreparedRecording]) -> list[Float]:
    """Return for each recording what noise of the angles makes in the model's torque, (J, K) N·m."""
    out = []
    for index, one in enumerate(prepared):
        other = one.noisier(np.random.default_rng(index)).motion
        out.append(_torque_change(base, beta, one, other.q, other.dq, other.ddq))
    return out


def _torque_change(base: Model, beta: Float, one: PreparedRecording, q: Float, dq: Float, ddq: Float) -> Float:
    old = one.motion
    changed = Motion(old.t, q, dq, ddq, old.sign, old.payload, old.base)
    return one.smooth(base.torque(changed, beta) - base.torque(old, beta))


def mean_square(change: Sequence[Float], prepared: Sequence[PreparedRecording]) -> Float:
    """Return the mean square (J,) of changes (J, K) over the usable samples of all recordings."""
    square = np.sum(
        [np.sum(np.where(p.used, x, 0.0) ** 2, axis=1) for x, p in zip(change, prepared, strict=True)], axis=0
    )
    return np.asarray(square / np.maximum(np.sum([p.used.sum(axis=1) for p in prepared], axis=0), 1))
