"""Bound on what is left of recordings that have numbers of their own, by least squares, before any is looked for."""

from __future__ import annotations

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gram import numbers_of
from exoid.diagnosis.evidence.model_error import sensor_noise
from exoid.ground.ties import index_of_least
from exoid.symbolic.motion import Float

PACE = 0.5
"""Seconds between moments at which a change is looked for first."""
LEAST = 2.0
"""Seconds before and after a change that are needed to see it."""


def least_left(last: FittedModel) -> Float:
    """Error (J,) of a model as a multiple of the noise where each joint of every recording has all numbers of its own,
    a zero and a clock among them, and others from some moment on: what belongs to recordings leaves hardly less.
    """
    square, count = np.zeros((2, len(last.model.joints)))
    for k, block in enumerate(last.evidence(seed=0, draws=0).blocks):
        rising = np.gradient(last.torque(k), axis=1)
        for j, (columns, slope, left, used) in enumerate(
            zip(block.columns, rising, block.residual, block.use > 0.0, strict=True)
        ):
            own = np.column_stack([columns, np.ones(len(slope)), slope, left]) * used[:, None]
            _, _, least = best_split(own[None], own[None], block.rate)
            square[j] += least
            count[j] += np.count_nonzero(used)
    return np.asarray(np.sqrt(square / np.maximum(count, 1)) / np.maximum(sensor_noise(last.prepared), 1e-6))


def best_split(columns: Float, weighted: Float, rate: float) -> tuple[float, int, float]:
    """Squared error that columns (J, K, D - 1) at `rate` Hz leave of another one, the last (J, K, D); and the sample
    before and after which they leave least with other numbers, 0 where none can be seen, and how much then.
    """
    least, many = int(LEAST * rate), columns.shape[1]
    places = np.arange(least, many - least, max(1, int(PACE * rate)))
    ends = zip([0, *places], [*places, many], strict=True)
    grams = np.array([np.tensordot(columns[:, a:b], weighted[:, a:b], ((0, 1), (0, 1))) for a, b in ends])
    before = np.cumsum(grams, axis=0)
    whole = float(_left(before[-1]))
    if not len(places):
        return whole, 0, whole
    split = _left(before[:-1]) + _left(before[-1] - before[:-1])
    best = index_of_least(split)
    return whole, int(places[best]), float(split[best])


def _left(grams: Float) -> Float:
    """Squared errors (...) that the columns of Gram matrices (..., D, D) leave of the last one."""
    product = grams[..., :-1, -1]
    return np.maximum(grams[..., -1, -1] - np.sum(product * numbers_of(grams[..., :-1, :-1], product), axis=-1), 0.0)
