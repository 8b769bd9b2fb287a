"""Floor that no model can get below: noise of torque and angles, and what filter and derivatives get wrong."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exoid.measurement.signals.conditioning import derivatives, leaves_enough, low_pass, quiet_noise
from exoid.measurement.signals.masks import widen
from exoid.optimisation.linear.loss import Bool
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

BESIDE = 6, 2, 0
"""Samples on either side of hidden ones in which the bend of a bridge is no noise, and fewer in which most of it is: a
bridge itself has none.
"""
DRAWS, ENOUGH = 8, 24_000
"""Draws of white noise that are filtered, and samples of all recordings and draws from which on there are fewer."""


def torque_noise(prepared: Sequence[PreparedRecording]) -> Float:
    """Return the noise (J,) of the torques in N·m/√Hz, from the top of their spectrum.

    Estimated without a model, from recordings in which the joint is driven: a torque that is zero for certain has no
    noise. What is hidden is left out: where a joint may be sticking its controller chatters. A torque sensor whose
    noise is not white has a floor of its own; this one is then low.
    """
    square = np.array([_own_noise(p) ** 2 for p in prepared])
    driven = np.array([p.driven for p in prepared])
    return np.asarray(np.sqrt(np.sum(square, axis=0, where=driven) / np.maximum(driven.sum(axis=0), 1)))


def _own_noise(one: PreparedRecording) -> Float:
    left = one.wide_tau if one.pushed is None else one.wide_tau - one.pushed  # what jumps in both is no noise
    bridged = one.bridged(np.array(left.T, order="C")).T
    apart = _apart(one.hidden)
    return quiet_noise(bridged, one.rate, 1.0, apart, max(1, round(one.full_rate / one.rate)))


def _apart(hidden: Bool) -> Bool:
    """Return the samples (N, J) that do not tell the noise: hidden ones and as many beside them as leave enough others,
    for where most of a recording is hidden every bridge is near.
    """
    margins = [np.column_stack([widen(column, beside) for column in hidden.T]) for beside in BESIDE]
    enough = [leaves_enough(margin) for margin in margins[:-1]]
    return np.asarray(np.select(enough, margins[:-1], margins[-1]))


def noise_floor(prepared: Sequence[PreparedRecording]) -> Float:
    """Return the RMS (J,) in N·m that the torques' noise leaves in what is fitted: white noise of their size, hidden
    and filtered as they are.
    """
    square, count = 0.0, 0.0
    draws = max(1, min(DRAWS, ENOUGH // sum(len(recording.motion) for recording in prepared)))
    for index, item in enumerate(prepared):
        joints, samples = item.hidden.shape[1], len(item.motion)
        white = np.random.default_rng(index).standard_normal((draws, joints, samples))
        smooth = item.smooth_rows(white, range(joints), 1)
        square = square + np.mean(np.sum(np.where(item.used, smooth, 0.0) ** 2, axis=2), axis=0) * item.rate / 2.0
        count = count + item.used.sum(axis=1)
    return np.asarray(torque_noise(prepared) * np.sqrt(square / np.maximum(count, 1)))


def torque_of_filter(base: Model, beta: Float, prepared: Sequence[PreparedRecording]) -> list[Float]:
    """Return for each recording what the filter gets wrong, (J, K) N·m: the model's torque once more with the angles
    filtered twice.
    """
    out = []
    for item in prepared:
        q = low_pass(item.motion.q, item.band, item.rate)
        dq, ddq = derivatives(q, item.rate)
        out.append(
            _torque_change(base, beta, item, q, np.where(item.standing, 0.0, dq), np.where(item.standing, 0.0, ddq))
        )
    return out


def torque_of_noise(base: Model, beta: Float, prepared: Sequence[PreparedRecording]) -> list[Float]:
    """Return for each recording what noise of the angles makes in the model's torque, (J, K) N·m."""
    out = []
    for index, recording in enumerate(prepared):
        other = recording.noisier(np.random.default_rng(index)).motion
        out.append(_torque_change(base, beta, recording, other.q, other.dq, other.ddq))
    return out


def _torque_change(base: Model, beta: Float, one: PreparedRecording, q: Float, dq: Float, ddq: Float) -> Float:
    changed = replace(one.motion, q=q, dq=dq, ddq=ddq)
    return one.smooth(base.torque(changed, beta) - base.torque(one.motion, beta))


def mean_square(change: Sequence[Float], prepared: Sequence[PreparedRecording]) -> Float:
    """Return the mean square (J,) of changes (J, K) over the usable samples of all recordings."""
    square = np.sum(
        [np.sum(np.where(p.used, x, 0.0) ** 2, axis=1) for x, p in zip(change, prepared, strict=True)], axis=0
    )
    return np.asarray(square / np.maximum(np.sum([p.used.sum(axis=1) for p in prepared], axis=0), 1))
