"""The residual where the motion repeats: what comes again is an error of the model, what does not is noise."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.ground.ties import index_of_least
from exoid.symbolic.motion import Float

ALIKE = 0.05
"""Motions are the same where their angles differ by less than this part of their standard deviation."""
SHORTEST = 1.0
"""s, of a period; and of what two recordings must have in common."""
LEAST_SAMPLES = 60


@dataclass(frozen=True, eq=False)
class Repeats:
    """The residual of the torque in motions that repeat: `share` (J,) of its variance that comes again, `noise` (J,)
    N·m the RMS of what does not, and between what it was compared (`what`).
    """

    share: Float
    noise: Float
    what: str


def repeats(fitted: FittedModel) -> Repeats | None:
    """Repeats of the residual, from period to period or from run to run; None where no motion repeats."""
    periods = [pair for index in range(len(fitted.residuals)) if (pair := _periods(fitted, index)) is not None]
    if periods:
        return _compared(periods, "from period to period")
    runs = [pair for a, b in combinations(range(len(fitted.residuals)), 2) if (pair := _runs(fitted, a, b)) is not None]
    return _compared(runs, "from run to run") if runs else None


Pair = tuple[Float, Float, np.ndarray]
"""Residuals (J, K) N·m at the same place of a motion, the first and the second time, and what of them counts (J, K)."""


def _periods(fitted: FittedModel, index: int) -> Pair | None:
    recording = fitted.prepared.all[index]
    q = recording.motion.q[recording.kept]
    moves = q.std(axis=0) > 0.0
    first, most = int(np.ceil(SHORTEST * recording.kept_rate)), len(q) // 2
    if most - first < 2 or len(q) - most < LEAST_SAMPLES or not moves.any():
        return None
    q = (q - q.mean(axis=0))[:, moves] / q.std(axis=0)[moves]
    away = _differences(q, most)[first:].max(axis=1)
    best = index_of_least(away, 1.0)
    if away[best] > ALIKE**2:
        return None
    lag, rest, use = first + best, fitted.residuals[index], recording.used
    return rest[:, :-lag], rest[:, lag:], use[:, :-lag] & use[:, lag:]


def _differences(x: Float, most: int) -> Float:
    """Return the mean of (x(t + lag) - x(t))² of signals `x` (N, J) for each lag up to `most`, (most + 1, J)."""
    count, lags = len(x), np.arange(most + 1)
    size = 2 * count
    alike = np.fft.irfft(np.abs(np.fft.rfft(x, size, axis=0)) ** 2, size, axis=0)[: most + 1]
    sums = np.concatenate([np.zeros((1, x.shape[1])), np.cumsum(x**2, axis=0)])
    return np.asarray((sums[-1] - sums[lags] + sums[count - lags] - 2.0 * alike) / (count - lags)[:, None])


def _runs(fitted: FittedModel, a: int, b: int) -> Pair | None:
    first, second = fitted.prepared.all[a], fitted.prepared.all[b]
    t, s = first.t - first.motion.t[0], second.t - second.motion.t[0]
    inside = (t >= s[0]) & (t <= s[-1])
    if inside.sum() < LEAST_SAMPLES or t[inside][-1] - t[inside][0] < SHORTEST:
        return None
    q, p = first.motion.q[first.kept][inside], second.motion.q[second.kept]
    at = t[inside]
    p = np.column_stack([np.interp(at, s, column) for column in p.T])
    size = np.maximum(q.std(axis=0), 0.02)
    if np.any(np.sqrt(np.mean((q - p) ** 2, axis=0)) > ALIKE * size):
        return None
    rest = np.array([np.interp(at, s, row) for row in fitted.residuals[b]])
    use = np.array([np.interp(at, s, row.astype(float)) > 0.99 for row in second.used])
    return fitted.residuals[a][:, inside], rest, first.used[:, inside] & use


def _compared(pairs: list[Pair], what: str) -> Repeats:
    again, whole, noise, count = (np.zeros(pairs[0][0].shape[0]) for _ in range(4))
    for first, second, use in pairs:
        again += np.sum(first * second * use, axis=1)
        whole += 0.5 * np.sum((first**2 + second**2) * use, axis=1)
        noise += 0.5 * np.sum((first - second) ** 2 * use, axis=1)
        count += use.sum(axis=1)
    share = np.clip(again / np.maximum(whole, 1e-300), 0.0, 1.0)
    return Repeats(share, np.sqrt(noise / np.maximum(count, 1)), what)
