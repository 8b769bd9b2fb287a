"""The common cut-off, chosen from the data: the fastest that predicts unseen torque as well as any and keeps the noise
of accelerations out of the model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
PARTS, PART = 12, 100.0
"""A recording longer than so many stretches of so many s is judged by as many of them."""
MOST_POSES = 64
"""Postures in which the mass matrix is looked at, at most."""


def typical(even: EvenSignals) -> list[EvenSignals]:
    """Return stretches that stand for a long recording, of each part of it the one in which the angles move most; a
    shorter one as it is.
    """
    length = round(PART * even.rate)
    if len(even.t) <= PARTS * length:
        return [even]
    edges = np.linspace(0, len(even.t), PARTS + 1).astype(int)
    thin = max(1, length // 400)

    def motion(first: int) -> float:
        part = slice(first, first + length, thin)
        return float(np.sum(even.q[part].std(axis=0)) * np.mean(~even.gap[part]))

    starts = [
        max(range(first, last - length + 1, max(1, length // 2)), key=motion)
        for first, last in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)
    ]
    return [even.stretch(first, first + length) for first in starts]


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


def choose_cutoff(base: Model, inputs: Sequence[tuple[str, EvenSignals]], beta: Float, derivative: str) -> CutoffChoice:
    """Choose the fastest cut-off that predicts unseen torque as well as any and keeps accelerations clean.

    What is too noisy is told by the spectra; only cut-offs that are not are tried, from the fastest on.
    """
    even = [one for _, one in inputs]
    slowest = min(e.rate for e in even)
    tried = [c for c in CUTOFFS if c <= 0.25 * slowest] or [0.2 * slowest]
    trial = _Trial(base, inputs, beta, derivative, min(COMMON_BAND, tried[0]))
    masses = _largest_masses(base, beta, even)
    # The cleanest recording of each joint decides: a joint held still has no acceleration to get wrong.
    shares = [noise_share(trial.slow, even, cutoff) for cutoff in tried]
    carried = [_carried_noise(masses, even, cutoff, noise_floor(trial.slow, cutoff)) for cutoff in tried]
    clean = (np.array(shares) <= BIAS_LIMIT) & (np.array(carried) <= NOISE_LIMIT)
    tolerance = LOOSE_TOLERANCE if shares[-1] >= NOISE_SEEN else TOLERANCE
    errors: dict[int, Float] = {}
    index = None
    for k in sorted({0, *np.flatnonzero(clean).tolist()[-2:]}):
        errors[k] = trial.error(tried[k])
    fastest = max(errors)
    if clean[fastest] and _relative(errors)[fastest] <= 1.0 + tolerance:
        index = fastest
    else:
        errors |= {k: trial.error(cutoff) for k, cutoff in enumerate(tried) if k not in errors}
        good = [k for k, worse in _relative(errors).items() if worse <= 1.0 + tolerance and clean[k]]
        index = good[-1] if good else int(np.argmin([_relative(errors)[k] + shares[k] for k in range(len(tried))]))
    relative = _relative(errors)
    table = tuple((tried[k], worse, shares[k]) for k, worse in relative.items())
    return CutoffChoice(tried[index], _reason(tried, index, relative, shares, carried, tolerance), table=table)


def _relative(errors: Mapping[int, Float]) -> dict[int, float]:
    """Return by how much each of the `errors` (J,) is larger than the least, of the worst joint, in their order."""
    least = np.min(list(errors.values()), axis=0)
    seen = least > 0.0
    return {k: float(np.max(errors[k][seen] / least[seen], initial=1.0)) for k in sorted(errors)}


class _Trial:
    """What a cut-off predicts of unseen torque below the band `slow`; recordings prepared at `slow` are kept."""

    def __init__(
        self, base: Model, inputs: Sequence[tuple[str, EvenSignals]], beta: Float, derivative: str, slow: float
    ) -> None:
        self.base, self.inputs, self.beta, self.derivative = base, inputs, beta, derivative
        self.band = slow
        self.slow = self._prepared(slow)
        self.judge = assemble(base, self.slow)

    def _prepared(self, cutoff: float) -> list[PreparedRecording]:
        # All on motion equally far from standstill: nearer to it friction is more than the base model knows, and a
        # faster cut-off, which gets nearer, would be blamed for that.
        return [
            prepare_one(self.base, name, even, cutoff, self.beta, COMMON_BAND, self.derivative)
            for name, even in self.inputs
        ]

    def error(self, cutoff: float) -> Float:
        """Return the RMS (J,) in N·m that fits at `cutoff` leave on recordings, or blocks, they have not seen."""
        data = self.judge if cutoff == self.band else assemble(self.base, self._prepared(cutoff))
        square = np.zeros(len(self.base.joints))
        for held, out in zip(_folds(data.groups), _folds(self.judge.groups), strict=True):
            square += np.sum(_part(self.judge, out).residual(_fit(_part(data, ~held))) ** 2, axis=1)
        return np.sqrt(square / np.maximum(self.judge.use.sum(axis=1), 1))


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
    relative: Mapping[int, float],
    shares: Sequence[float],
    carried: Sequence[float],
    tolerance: float,
) -> str:
    text = f"{tried[index]:g} Hz: noise makes up {100 * shares[index]:.2g} % of the accelerations"
    if index + 1 == len(tried):
        return text + ", and no faster cut-off was tried"
    after = index + 1
    beyond = f"{text}; at {tried[after]:g} Hz"
    if relative.get(after, 0.0) > 1.0 + tolerance:
        return f"{beyond} unseen torque is predicted {100 * (relative[after] - 1):.0f} % worse than at best"
    if shares[after] > BIAS_LIMIT:
        return f"{beyond} it would be {100 * shares[after]:.2g} %, a bias towards zero for every inertia"
    return f"{beyond} they would carry {100 * carried[after]:.0f} % of the torque sensor's noise power into the model"
