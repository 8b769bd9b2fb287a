"""The course of a change: at once or slowly, and when it began."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exoid.diagnosis.against.result import Course
from exoid.ground.thresholds import Threshold
from exoid.ground.ties import index_of_least
from exoid.symbolic.motion import Float

SURE: Threshold = 6.0
"""fall of the weighted squares, in variances, within which another moment explains the course as well: an interval too
short
"""
SLOW: Threshold = 20.0
"""the same by which a slow change must explain it better than a jump: noise after a jump looks like a ramp"""
RAMPS = (30.0, 60.0, 120.0, 240.0, 480.0)
"""Durations of a slow change that are tried, s."""
VISIBLE = 8
"""Stretches at least that must lie within a slow change, after it was noticed, for it to be no jump."""


@dataclass(frozen=True)
class Onset:
    """The time at which a change began, `t` in s with the interval [`low`, `high`], and whether it came slowly."""

    t: float
    low: float
    high: float
    slow: bool

    @classmethod
    def at(cls, t: float) -> Onset:
        """Return that it began at `t` s at once."""
        return cls(t, t, t, False)


def onset(course: Course, after: float = -np.inf) -> Onset:
    """Return the onset of the change of `course`; a slow one counts as begun where its rise begins.

    A jump is looked for from `after` s on.
    """
    order = np.argsort(course.t, kind="stable")
    t, wants, power = course.t[order], course.wants[order], course.power[order]
    edges = np.concatenate([t[:1] - 1.0, 0.5 * (t[1:] + t[:-1]), t[-1:] + 1.0])
    jumps = np.array([_loss((t >= edge).astype(float), wants, power) if edge > after else np.inf for edge in edges])
    best = index_of_least(jumps)
    variance = max(float(jumps[best]) / max(len(t) - 2, 1), 1e-300)
    near = np.flatnonzero(jumps <= jumps[best] + SURE * variance)
    ramps = [
        (_loss(np.clip((t - edge) / length, 0.0, 1.0), wants, power), float(edge))
        for length in RAMPS
        if length < 1.5 * (t[-1] - t[0])
        for edge in edges
        if np.sum((t > max(edge, after)) & (t < edge + length)) >= VISIBLE
    ]
    least = min(ramps, default=(np.inf, 0.0))
    if least[0] < jumps[best] - SLOW * variance:
        begun = np.flatnonzero(np.isin(edges, [edge for loss, edge in ramps if loss <= least[0] + SURE * variance]))
        return Onset(least[1], *_around(edges, begun), True)
    low, high = _around(edges, near)
    return Onset(float(edges[best]), max(after, low), high, False)


def _around(edges: Float, possible: np.ndarray) -> tuple[float, float]:
    """Return from where to where the moment lies, if one of the `possible` edges is the nearest to it."""
    return float(edges[max(possible[0] - 1, 0)]), float(edges[min(possible[-1] + 1, len(edges) - 1)])


def _loss(shape: Float, wants: Float, power: Float) -> float:
    """Return the weighted squares that a course of this shape, of any size, leaves."""
    whole = float(power @ shape**2)
    size = float(power @ (shape * wants)) / whole if whole > 0.0 else 0.0
    return float(power @ (wants - size * shape) ** 2)
