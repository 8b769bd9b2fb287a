"""Recordings that the present model makes itself: what a candidate gains there it gains from noise alone.

A motion a little smoother than the measured one plays the truth; the model's torque in it is filtered as the measured
one was, and the sensors' noise is added anew. Noise of the angles makes accelerations, and so the torque of any model,
rougher than the motion was, and so does noise of measured forces; whatever smooths it (a flexible drive, a delay) then
gains although nothing is missing.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from exoid.diagnosis.evidence.candidates import Candidate
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gain import Evidence
from exoid.diagnosis.evidence.look_alikes import columns_at
from exoid.diagnosis.evidence.score import weigh
from exoid.measurement.signals.conditioning import derivatives, low_pass
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.symbolic.motion import Float

SMOOTHER = 0.5
"""Part of a recording's band that the motion which plays the truth has: the rest of it may be noise already."""
LEAST_SENSOR = 0.1
"""Part of the noise that comes from the torque sensors at least."""


def made_by_itself(fitted: FittedModel, floor: Float, seed: int) -> FittedModel:
    """Return the model of `fitted`, fitted to recordings that it made itself, `floor` (J,) N·m of noise in them."""
    rng = np.random.default_rng([seed, len(fitted.residuals)])
    pairs = zip(fitted.prepared.all, fitted.shapes, strict=True)
    made = [_made(fitted, item, shape, np.maximum(floor, 1e-12), rng) for item, shape in pairs]
    prepared = fitted.prepared.with_recordings(made)
    fit = identify(fitted.model, prepared.train, optimisers=(), shape=fitted.fit.start)
    return replace(fitted, fit=fit).on(prepared)


Simulated = tuple[FittedModel, Evidence]
"""A model on recordings that it made itself, and the evidence against it there."""


def evidence_on(made: Sequence[FittedModel], evidence: Evidence) -> list[Simulated]:
    """Return models on recordings that they made themselves with the evidence there, in the units of `evidence`."""
    return [(item, item.evidence(seed=0, draws=0, sigma=evidence.sigma, rules=evidence.rules)) for item in made]


def needed_beyond_noise(
    candidate: Candidate, shape: Float, evidence: Evidence, simulated: Sequence[Simulated]
) -> float:
    """Return the share of the loss that a candidate at shape values (R, S) must gain beyond the least one, since noise
    of angles and forces makes so much of it.
    """
    single, gains = replace(candidate, nodes=shape[:, None, :]), []
    loss = float(evidence.fold_losses.sum())
    for fitted, theirs in simulated:
        share = weigh(theirs, single, columns_at(single, shape, fitted)).share
        gains.append(share * float(theirs.fold_losses.sum()) / loss)
    return evidence.rules.artefact * max(0.0, float(np.mean(gains)))


def noise_share(evidence: Evidence, floor: Float) -> float:
    """Share of the loss of the training recordings that noise of `floor` (J,) N·m makes."""
    samples = np.sum([block.use.sum(axis=1) for block in evidence.train], axis=0)
    return float(np.sum(samples * (floor / evidence.sigma) ** 2)) / max(float(evidence.fold_losses.sum()), 1e-300)


def _made(
    fitted: FittedModel, one: PreparedRecording, shape: Float, floor: Float, rng: np.random.Generator
) -> PreparedRecording:
    """Return a recording as the model would have made it."""
    model, linear = fitted.model, fitted.linear
    q = low_pass(one.motion.q, SMOOTHER * one.band, one.rate)
    dq, ddq = (np.where(one.standing, 0.0, part) for part in derivatives(q, one.rate))
    sign = np.where(one.standing, 0.0, np.sign(dq))
    told = one.direction and replace(one.direction, velocity=dq)
    true = one.changed(motion=replace(one.motion, q=q, dq=dq, ddq=ddq, sign=sign), direction=told)
    torque = true.smooth(model.torque(true.motion, linear, shape))
    seen = true.noisier(rng)
    away = np.where(one.used, torque - seen.smooth(model.torque(seen.motion, linear, shape)), 0.0)
    by_angles = np.sum(away**2, axis=1) / np.maximum(one.used.sum(axis=1), 1)
    sensor = np.sqrt(np.maximum(floor**2 - by_angles, (LEAST_SENSOR * floor) ** 2))
    return seen.changed(torque=torque + sensor[:, None] * rng.standard_normal(torque.shape))
