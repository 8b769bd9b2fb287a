"""A doubt about channels that cannot be what they say, and what it is judged by: how much of each torque is left."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.gram import numbers_of
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.symbolic.motion import Float

COLUMNS = (
    "check the columns and their order (--map), units (--units), the signs and zeros of angles and torques, and "
    "whether torque and motion are of the same run; draw them over time, or start with a slow motion of one joint"
)
"""What to do about a torque that is not that of the machine."""


@dataclass(frozen=True)
class Doubt:
    """Reason why the channels cannot be what they say: the rule that fired, the sentence, and what to do."""

    rule: str
    sentence: str
    remedy: str


def turned_round(columns: Iterable[tuple[str, str]]) -> str:
    """Return the option of `--units` that turns `columns` round, each given with its unit as it is printed."""
    return ",".join(f"{name}=-{unit.replace('·', '')}" for name, unit in columns)


def left_share(fitted: FittedModel) -> Float:
    """Return the share (J,) of the variance of the torque that a model leaves, the larger of fitted and held out.

    The variance is that of all recordings: a held-out one that happens to need hardly any torque is no wrong channel.
    NaN for a joint that has no torque of its own to explain: undriven, or without a usable sample.
    """
    every, count = fitted.prepared.all, len(fitted.prepared.train)
    parts = [slice(count), slice(count, None)][: 1 + fitted.verified]
    left = [mean_square_known(fitted.residuals[part], every[part]) for part in parts]
    return np.asarray(np.fmax.reduce(left) / variance_known(every))


def variance_known(recordings: Sequence[PreparedRecording]) -> Float:
    """Return the variance (J,) of the torques of recordings; NaN where it is zero, or no torque of a drive known."""
    mean = _means([item.torque for item in recordings], recordings)[:, None]
    power = mean_square_known([item.torque - mean for item in recordings], recordings)
    return np.where(power > 0.0, power, np.nan)


def mean_square_known(rows: Sequence[Float], recordings: Sequence[PreparedRecording]) -> Float:
    """Return the mean square (J,) of `rows` (J, K) of recordings where torques of drives are known, NaN where none."""
    return _means([row**2 for row in rows], recordings)


def _means(rows: Sequence[Float], recordings: Sequence[PreparedRecording]) -> Float:
    use = np.concatenate([item.used & item.driven[:, None] for item in recordings], axis=1)
    count = use.sum(axis=1)
    return np.asarray(np.sum(np.concatenate(rows, axis=1), axis=1, where=use) / np.where(count > 0, count, np.nan))


def finite(share: Float, joints: Sequence[str]) -> Iterator[tuple[str, float]]:
    """Joints of which something can be left, with the share that is."""
    return ((joint, float(x)) for joint, x in zip(joints, share, strict=True) if np.isfinite(x))


def left_beside(fitted: FittedModel, columns: Sequence[Float], joint: int) -> tuple[Float, Float, Float]:
    """A torque where its joint moves in fitted motion, what the model leaves of it, and what `columns` (J, K, P) of
    each recording do.
    """
    train, residuals = fitted.prepared.train, fitted.residuals
    seen = [item.used[joint] & (item.driven[joint] and not item.standing[joint]) for item in train]
    tau, left, rows = (
        np.concatenate([part[joint][use] for part, use in zip(parts, seen, strict=False)])
        for parts in ([item.torque for item in train], residuals, columns)
    )
    return tau, left, tau - rows @ numbers_of(rows.T @ rows, rows.T @ tau)
