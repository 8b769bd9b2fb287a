"""The common cut-off, chosen from the data: the fastest that predicts unseen torque as well as any and keeps the noise
of accelerations out of the model.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from itertools import product

import numpy as np

from ground.thresholds import Threshold
from measurement.signals.conditioning import EvenSignals, acceleration_noise, acceleration_quality
from optimisation.fitting.assemble import assemble
from optimisation.fitting.plausibility import mass_matrix
from optimisation.linear.problem import LinearData
from optimisation.linear.solve import delta_rule, solve_huber, solve_sse
from optimisation.preparation.filtering import PreparedRecording, prepare_one
from optimisation.preparation.noise import noise_floor
from symbolic.model import Model
from symbolic.motion import Float

CUTOFFS = (3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0)
"""Cut-off frequencies tried, Hz."""
COMMON_BAND = 3.0
"""Every cut-off is assessed on the unseen torque below this frequency, Hz."""
BIAS_LIMIT = Threshold(0.005, "share of noise in the accelerations: about the relative bias of an inertia")
NOISE_LIMIT = Threshold(
    0.05,
    "noise power that accelerations carry into the model's torque, of the sensor's own: effects that smooth the "
    "model (a flexible drive) look real",
)
TOLERANCE = Threshold(
    0.03,
    "by which a faster cut-off may predict unseen torque worse than the best: information thrown away",
)
NOISE_SEEN = Threshold(
    1e-4,
    "share of noise in the accelerations at the fastest cut-off from which the encoders' noise is known: a guess "
    "at it would decide",
)
LOOSE_TOLERANCE = Threshold(
    0.25,
    "the same tolerance where the noise is known: friction near standstill, which faster motion shows, would "
    "slow the cut-off",
)
MOST_POSES = 64
"""Postures in which the mass matrix is looked at, at most."""


@dataclass(frozen=True)
class CutoffChoice:
    """The common cut-off in Hz and, in words, why it is that one. `table` holds (cut-off, error, noise share)."""

    cutoff: float
    reason: str
    automatic: bool = True
    table: tuple[tuple[float, float, float], ...] = field(default=())


def robust_base(base: Model, prepared: Sequence[PreparedRecording]) -> Float:
    """Return the parameters (P,) of the base model that a Huber fit gives."""
    return _fit(assemble(base, prepared))


def _fit(data: LinearData) -> Float:
    first = solve_sse(data)
    return solve_huber(data, delta_rule(data.residual(first), use=data.use), first)


def choose_cutoff(
    base: Model, names: Sequence[str], even: Sequence[EvenSignals], beta: Float, derivative: str
) -> CutoffChoice:
    """Choose the fastest cut-off that predicts unseen torque as well as any and keeps accelerations clean."""
    slowest = min(e.rate for e in even)
    tried = [c for c in CUTOFFS if c <= 0.25 * slowest] or [0.2 * slowest]
    inputs = list(zip(names, even, strict=True))
    slow = min(COMMON_BAND, tried[0])
    judge = assemble(base, [prepare_one(base, n, e, slow, beta, derivative=derivative) for n, e in inputs])
    masses = _largest_masses(base, beta, even)
    errors, shares, carried = [], [], []
    for cutoff in tried:
        # All on motion equally far from standstill: nearer to it friction is more than the base model knows, and a
        # faster cut-off, which gets nearer, would be blamed for that.
        prepared = [prepare_one(base, n, e, cutoff, beta, COMMON_BAND, derivative) for n, e in inputs]
        data = assemble(base, prepared)
        square = np.zeros(len(base.joints))
        for held, out in zip(_folds(data.groups), _folds(judge.groups), strict=True):
            square += np.sum(_part(judge, out).residual(_fit(_part(data, ~held))) ** 2, axis=1)
        errors.append(np.sqrt(square / np.maximum(judge.use.sum(axis=1), 1)))
        # The cleanest recording of each joint decides: a joint held still has no acceleration to get wrong.
        shares.append(noise_share(prepared, even, cutoff))
        carried.append(_carried_noise(masses, even, cutoff, noise_floor(prepared, cutoff)))
    least = np.min(errors, axis=0)
    relative = np.max(np.array(errors) / np.where(least > 0.0, least, 1.0), axis=1, where=least > 0.0, initial=1.0)
    tolerance = LOOSE_TOLERANCE if shares[-1] >= NOISE_SEEN else TOLERANCE
    predicts = relative <= 1.0 + tolerance
    clean = (np.array(shares) <= BIAS_LIMIT) & (np.array(carried) <= NOISE_LIMIT)
    good = [i for i in range(len(tried)) if predicts[i] and clean[i]]
    index = good[-1] if good else int(np.argmin(relative + np.array(shares)))
    table = tuple((c, float(r), s) for c, r, s in zip(tried, relative, shares, strict=True))
    return CutoffChoice(tried[index], _reason(tried, index, relative, shares, carried, tolerance), table=table)


def _part(data: LinearData, keep: np.ndarray) -> LinearData:
    return replace(
        data, columns=data.columns[:, keep], tau=data.tau[:, keep], groups=data.groups[keep], use=data.use[:, keep]
    )


def _folds(groups: np.ndarray) -> list[np.ndarray]:
    """Return masks of held-out samples: whole recordings, or four long blocks of a single one."""
    labels = np.unique(groups)
    if labels.size > 1:
        return [groups == label for label in labels]
    block = np.arange(groups.size) * 4 // groups.size
    return [block == b for b in range(4)]


def noise_share(prepared: Sequence[PreparedRecording], even: Sequence[EvenSignals], cutoff: float) -> float:
    """Return the share of noise in the accelerations, of the worse joint in its cleanest recording.

    A joint that is held still has no acceleration to get wrong.
    """
    quality = np.array([acceleration_quality(e, cutoff) for e in even])
    moves = ~np.array([one.standing for one in prepared])
    best = np.min(quality, axis=0, where=moves, initial=np.inf)
    return float(np.max(best[np.isfinite(best)], initial=0.0))


def _largest_masses(base: Model, beta: Float, even: Sequence[EvenSignals]) -> Float:
    """Return the largest size (J, J) that each entry of the mass matrix has with the links stretched out or folded,
    sliding joints at the ends of their range.
    """
    ends = [
        (0.0, np.pi) if joint.turns else (min(e.q[:, j].min() for e in even), max(e.q[:, j].max() for e in even))
        for j, joint in enumerate(base.joints)
    ]
    poses = np.array(list(product(*ends)))
    if len(poses) > MOST_POSES:
        poses = poses[np.random.default_rng(0).choice(len(poses), MOST_POSES, replace=False)]
    return np.asarray(np.abs(mass_matrix(base, beta, None, poses)).max(axis=0))


def _carried_noise(masses: Float, even: Sequence[EvenSignals], cutoff: float, floor: Float) -> float:
    """Return the noise power that accelerations carry into the model's torque, relative to the torque's own."""
    acceleration = np.median([acceleration_noise(e, cutoff) for e in even], axis=0)
    return float(np.max(masses**2 @ acceleration**2 / np.maximum(floor**2, 1e-300)))


def _reason(
    tried: Sequence[float],
    index: int,
    relative: Float,
    shares: Sequence[float],
    carried: Sequence[float],
    tolerance: float,
) -> str:
    text = f"{tried[index]:g} Hz: noise makes up {100 * shares[index]:.2g} % of the accelerations"
    if index + 1 == len(tried):
        return text + ", and no faster cut-off was tried"
    after = index + 1
    beyond = f"{text}; at {tried[after]:g} Hz"
    if relative[after] > 1.0 + tolerance:
        return f"{beyond} unseen torque is predicted {100 * (relative[after] - 1):.0f} % worse than at best"
    if shares[after] > BIAS_LIMIT:
        return f"{beyond} it would be {100 * shares[after]:.2g} %, a bias towards zero for every inertia"
    return f"{beyond} they would carry {100 * carried[after]:.0f} % of the torque sensor's noise power into the model"
