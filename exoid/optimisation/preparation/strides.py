"""Strides of a recording: a motion that comes again and again, cut where a foot comes down, or where one joint passes
its middle.

A stride is one step to the next of the same foot where a foot's contact, or the force under it, was measured all along;
else one turn of the joint that turns most evenly. Motions whose turns are not alike have none.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from exoid.ground.thresholds import Threshold
from exoid.ground.ties import index_of_least
from exoid.symbolic.motion import Float

ALIKE: Threshold = 0.4
"""part of the standard deviation of the mean stride, RMS, by which strides differ from it in any angle: motions that
come again in another size every time would be laid over one another
"""
SHORTEST, LONGEST = 0.4, 6.0
"""s, of a stride."""
COVERED = 0.6
"""Part of the time that strides take at least."""
PHASES = 50
"""Points of a stride."""
STILL = 0.02
"""rad, or tenths of a metre: standard deviation below which a joint does not move."""


@dataclass(frozen=True, eq=False)
class StrideCut:
    """Begin and end (S, 2) of every stride, in samples and parts of them; they begin where a foot comes down, or where
    `joint` (index) passes its `middle` forwards. `stance` is the part of a stride in which the foot is on the ground.
    """

    ends: Float
    joint: int | None = None
    middle: float = np.nan
    stance: float = np.nan

    def starts(self, count: int) -> NDArray[np.int_]:
        """Return the samples at which blocks of `count` samples begin: strides, and what lies beside them."""
        every = np.ceil(np.unique(self.ends)).astype(int)
        return np.unique(np.concatenate([[0], every[every < count]]))


def cut_into_strides(q: Float, t: Float, stances: Float | None, reach: Float) -> StrideCut | None:
    """Return the strides of angles (N, J) at even times `t` (N,) s; None where they have none. `stances` (S, 2) in s
    are those of a foot, `reach` (J,) is what a joint moves where a turning one moves 1 rad.
    """
    moving = np.flatnonzero(q.std(axis=0) > STILL * reach)
    if not moving.size:
        return None
    rate = 1.0 / float(t[1] - t[0])
    if stances is not None and len(stances) > 2:
        at = (stances[:, 0] - t[0]) * rate
        if (ends := _alike(_pairs(at, len(q)), q[:, moving])) is not None:
            lasts = np.diff(stances[:, 0])
            return StrideCut(ends, stance=float(np.median(np.diff(stances, axis=1)[:-1, 0] / lasts)))
    period = _period(q[:, moving], rate)
    if period is None:
        return None
    tried = [(int(joint), _passes(q[:, joint], period)) for joint in moving]
    uneven = [np.std(np.diff(at)) / np.mean(np.diff(at)) if len(at) > 3 else np.inf for _, at in tried]
    joint, at = tried[index_of_least([float(x) for x in uneven], 1.0)]
    ends = _alike(_pairs(at, len(q)), q[:, moving])
    return None if ends is None else StrideCut(ends, joint, float(q[:, joint].mean()))


def over_phases(rows: Float, ends: Sequence[float] | Float) -> Float:
    """Return rows (J, N) over the phases of one stride, (J, PHASES), between samples along straight lines."""
    at, places = np.linspace(ends[0], ends[1], PHASES, endpoint=False), np.arange(rows.shape[1])
    return np.array([np.interp(at, places, row) for row in rows])


def _pairs(at: Sequence[float] | Float, count: int) -> list[tuple[float, float]]:
    """Return begin and end of strides of usual length that lie within `count` samples; none where they take too little
    of them.
    """
    inside = [float(place) for place in at if 0.0 <= place <= count - 1]
    if len(inside) < 3:
        return []
    usual = float(np.median(np.diff(inside)))
    pairs = [(a, b) for a, b in pairwise(inside) if 0.7 * usual < b - a < 1.4 * usual]
    return pairs if len(pairs) >= 2 and sum(b - a for a, b in pairs) >= COVERED * count else []


def _alike(pairs: list[tuple[float, float]], q: Float) -> Float | None:
    """Return begin and end (S, 2) of strides of the angles (N, J); None where there are none, or they differ much."""
    if not pairs:
        return None
    curves = np.array([over_phases(q.T, pair) for pair in pairs])
    usual = curves.mean(axis=0)
    away = np.sqrt(np.mean((curves - usual) ** 2, axis=(0, 2))) / np.maximum(usual.std(axis=1), 1e-12)
    return np.array(pairs) if np.all(away < ALIKE) else None


def _period(q: Float, rate: float) -> float | None:
    """Return after how many samples angles (N, J) come again first; None where they do not."""
    x = (q - q.mean(axis=0)) / q.std(axis=0)
    size = 2 * len(x)
    alike = np.fft.irfft(np.abs(np.fft.rfft(x, size, axis=0)) ** 2, size, axis=0)[: len(x)].mean(axis=1)
    alike = alike / (len(x) - np.arange(len(x)))
    first, last = int(SHORTEST * rate), min(int(LONGEST * rate), len(x) // 3)
    peaks = [k for k in range(max(first, 1), last) if alike[k - 1] <= alike[k] > alike[k + 1]]
    best = max((alike[k] for k in peaks), default=0.0)
    return next((float(k) for k in peaks if alike[k] > 0.8 * best), None) if best > 0.3 else None


def _passes(x: Float, period: float) -> list[float]:
    """Return at which samples (fractions) an angle (N,) passes its middle forwards, once in a period."""
    width = max(1, round(period / 4.0))
    smooth = np.convolve(x - x.mean(), np.ones(width) / width, mode="same")
    before = np.flatnonzero((smooth[:-1] < 0.0) & (smooth[1:] >= 0.0))
    at = before + smooth[before] / (smooth[before] - smooth[before + 1])
    kept: list[float] = []
    for place in at:
        if not kept or place - kept[-1] > 0.5 * period:
            kept.append(float(place))
    return kept
