"""The common cut-off, chosen from the data: the fastest that predicts unseen torque as well as any and keeps the noise
of accelerations out of the model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache

import numpy as np

from exoid.ground.thresholds import Threshold
from exoid.ground.ties import least_of
from exoid.measurement.signals.conditioning import UniformSignals, acceleration_quality
from exoid.optimisation.fitting.assemble import assemble
from exoid.optimisation.linear.problem import LinearData
from exoid.optimisation.linear.solve import delta_rule, solve_huber, solve_sse
from exoid.optimisation.preparation.filtering import PreparedRecording, prepare_one
from exoid.optimisation.preparation.noise import mean_square, noise_floor, torque_of_filter, torque_of_noise
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

CUTOFFS = (3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0)
"""Cut-off frequencies tried, Hz."""
COMMON_BAND = 3.0
"""Every cut-off is assessed on the unseen torque below this frequency, Hz."""
BIAS_LIMIT: Threshold = 0.005
"""share of noise in the accelerations: about the relative bias of an inertia"""
NOISE_LIMIT: Threshold = 0.05
"""noise power that accelerations carry into the model's torque, of the sensor's own: effects that smooth the model (a
flexible drive) look real
"""
TOLERANCE: Threshold = 0.03
"""by which a faster cut-off may predict unseen torque worse than the best: information thrown away"""
NOISE_SEEN: Threshold = 1e-4
"""share of noise in the accelerations at the fastest cut-off from which the encoders' noise is known: a guess at it
would decide
"""
LOOSE_TOLERANCE: Threshold = 0.25
"""the same tolerance where the noise is known: friction near standstill, which faster motion shows, would slow the
cut-off
"""
FILTER: Threshold = 1 / 3
"""part of the error at the slowest cut-off that its filter makes, from which the loose tolerance holds too: numbers
that make up for a slow filter would be preferred to right ones
"""
PARTS, PART = 12, 100.0
"""A recording longer than so many stretches of so many s is judged by as many of them."""
RESOLVED = 1e-5
"""Part of a torque below which its noise is none of a sensor: that of a simulation is what the filter gets wrong."""


def typical(even: UniformSignals) -> list[UniformSignals]:
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
        least_of(range(first, last - length + 1, max(1, length // 2)), lambda start: -motion(start))
        for first, last in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True)
    ]
    return [even.stretch(first, first + length) for first in starts]


@dataclass(frozen=True)
class CutoffChoice:
    """The common cut-off in Hz and, in words, why it is that one. `table` holds (cut-off, error, noise share)."""

    cutoff: float
    reason: str
    table: tuple[tuple[float, float, float], ...] = field(default=())


def robust_base(base: Model, prepared: Sequence[PreparedRecording]) -> Float:
    """Return the parameters (P,) of the base model that a Huber fit gives."""
    return _fit(assemble(base, prepared))


def _fit(data: LinearData) -> Float:
    first = solve_sse(data)
    return solve_huber(data, delta_rule(data.residual(first), use=data.use), first)


def choose_cutoff(
    base: Model, inputs: Sequence[tuple[str, UniformSignals]], beta: Float, derivative: str
) -> CutoffChoice:
    """Choose the fastest cut-off that predicts unseen torque as well as any and keeps accelerations clean.

    The torque's noise is much the same at every cut-off, so that the slowest tells which is about the fastest that is
    clean. The others are only tried where that predicts badly.
    """
    slowest = min(e.rate for _, e in inputs)
    tried = [c for c in CUTOFFS if c <= 0.25 * slowest] or [0.2 * slowest]
    trials = _Trials(base, inputs, beta, derivative, tried)
    guesses = [trials.noise(k, 0) for k in range(len(tried))]
    tolerance = LOOSE_TOLERANCE if guesses[-1].share >= NOISE_SEEN else TOLERANCE
    fastest = max((k for k, guess in enumerate(guesses) if guess.clean), default=0)
    while fastest + 1 < len(tried) and trials.noise(fastest + 1).clean:
        fastest += 1
    while fastest > 0 and not trials.noise(fastest).clean:
        fastest -= 1
    weighed = sorted({0, fastest})
    relative = trials.relative(weighed)
    index = fastest
    if relative[fastest] > 1.0 + tolerance and trials.filter_decides(fastest):
        tolerance = LOOSE_TOLERANCE
    if not trials.noise(fastest).clean or relative[fastest] > 1.0 + tolerance:
        weighed = list(range(len(tried)))
        relative = trials.relative(weighed)
        # Each joint may be predicted best at another cut-off: then none is as good as any at all joints.
        alike = [k for k in weighed if relative[k] <= min(relative.values()) * (1.0 + tolerance)]
        good = [k for k in alike if trials.noise(k).clean]
        index = good[-1] if good else alike[0]  # where none is clean, the slowest carries the least noise
    table = tuple((tried[k], relative[k], trials.noise(k).share) for k in weighed)
    return CutoffChoice(tried[index], _reason(trials, index, relative, tolerance), table=table)


@dataclass(frozen=True)
class _Noise:
    """The `share` of noise in the accelerations at a cut-off, and the noise power that they carry into the model's
    torque, relative to the torque's own.
    """

    share: float
    carried: float

    @property
    def clean(self) -> bool:
        return self.share <= BIAS_LIMIT and self.carried <= NOISE_LIMIT


class _Trials:
    """Recordings prepared at the cut-offs `tried`, as far as somebody asks."""

    def __init__(
        self,
        base: Model,
        inputs: Sequence[tuple[str, UniformSignals]],
        beta: Float,
        derivative: str,
        tried: Sequence[float],
    ) -> None:
        self.tried = tried
        even = [item for _, item in inputs]

        @cache
        def prepared(k: int) -> list[PreparedRecording]:
            # All on motion equally far from standstill: nearer to it friction is more than the base model knows, and a
            # faster cut-off, which gets nearer, would be blamed for that.
            return [prepare_one(base, name, e, tried[k], beta, COMMON_BAND, derivative) for name, e in inputs]

        @cache
        def sensors() -> Float:
            size = np.max([recording.wide_tau.std(axis=0) for recording in prepared(0)], axis=0)
            return np.asarray(np.maximum(noise_floor(prepared(0)), RESOLVED * size) ** 2)

        @cache
        def carried(k: int) -> float:
            angles = mean_square(torque_of_noise(base, beta, prepared(k)), prepared(k))
            sensor = sensors() * (tried[k] / tried[0])
            # A joint without a drive has no torque sensor: there it is relative to the noise of the others.
            return float(np.max(angles / np.where(sensor > 0.0, sensor, sensor.max()))) if sensor.any() else 0.0

        @cache
        def noise(k: int, of: int) -> _Noise:
            # The cleanest recording of each joint decides: a joint held still has no acceleration to get wrong. That of
            # accelerations grows with the fifth power of a cut-off, the sensor's with the first.
            share = noise_share(prepared(of), even, tried[k])
            return _Noise(share, carried(of) * (tried[k] / tried[of]) ** 4)

        @cache
        def data(k: int) -> LinearData:
            return assemble(base, prepared(k))

        @cache
        def error(k: int) -> Float:
            judge = data(0)
            square = np.zeros(len(base.joints))
            for held, out in zip(_folds(data(k).groups), _folds(judge.groups), strict=True):
                square += np.sum(_part(judge, out).residual(_fit(_part(data(k), ~held))) ** 2, axis=1)
            return np.asarray(np.sqrt(square / np.maximum(judge.use.sum(axis=1), 1)))

        def filter_decides(fastest: int) -> bool:
            wrong = torque_of_filter(base, beta, prepared(0))
            slower = _torque_of_slower(base, beta, prepared(0), prepared(fastest))
            most = np.max([np.sqrt(mean_square(each, prepared(0))) for each in (wrong, slower)], axis=0)
            return bool(np.any(most > FILTER * error(0)))

        self._noise, self._error, self.filter_decides = noise, error, filter_decides

    def noise(self, k: int, of: int | None = None) -> _Noise:
        """Effect of noise at one cut-off, that of the torque taken from another where one is named."""
        return self._noise(k, k if of is None else of)

    def relative(self, weighed: Sequence[int]) -> dict[int, float]:
        """Return by how much worse than the best of them each cut-off predicts unseen torque at the slowest, 1 for not
        at all, of the worst joint.
        """
        least = np.min([self._error(k) for k in weighed], axis=0)
        seen = least > 0.0
        return {k: float(np.max(self._error(k)[seen] / least[seen], initial=1.0)) for k in weighed}


def _torque_of_slower(
    base: Model, beta: Float, slow: Sequence[PreparedRecording], fast: Sequence[PreparedRecording]
) -> list[Float]:
    """Return for each recording what slower angles get wrong of the model's torque, (J, K) N·m: faster ones show it."""
    out = []
    for item, other in zip(slow, fast, strict=True):
        right, own = base.torque(other.motion, beta), base.torque(item.motion, beta)
        at = [np.interp(item.motion.t, other.motion.t, column) for column in right.T]
        out.append(item.smooth(np.column_stack(at) - own))
    return out


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


def noise_share(prepared: Sequence[PreparedRecording], even: Sequence[UniformSignals], cutoff: float) -> float:
    """Return the share of noise in the accelerations, of the worse joint in its cleanest recording.

    A joint that is held still has no acceleration to get wrong.
    """
    quality = np.array([acceleration_quality(e, cutoff) for e in even])
    moves = ~np.array([recording.standing for recording in prepared])
    best = np.min(quality, axis=0, where=moves, initial=np.inf)
    return float(np.max(best[np.isfinite(best)], initial=0.0))


def _reason(trials: _Trials, index: int, relative: Mapping[int, float], tolerance: float) -> str:
    tried = trials.tried
    text = f"{tried[index]:g} Hz: noise makes up {100 * trials.noise(index).share:.2g} % of the accelerations"
    if index + 1 == len(tried):
        return text + ", and no faster cut-off was tried"
    after = index + 1
    beyond, noise = f"{text}; at {tried[after]:g} Hz", trials.noise(after)
    if relative.get(after, 0.0) > 1.0 + tolerance:
        return f"{beyond} unseen torque is predicted {100 * (relative[after] - 1):.0f} % worse than at best"
    if noise.share > BIAS_LIMIT:
        return f"{beyond} it would be {100 * noise.share:.2g} %, a bias towards zero for every inertia"
    return f"{beyond} they would carry {100 * noise.carried:.0f} % of the torque sensor's noise power into the model"
