"""Bounds of a periodic motion between the points at which it was looked at, proven.

Let p be a trigonometric polynomial of degree K with period T, and ‖p‖ the largest |p| at any time. On M > 2K evenly
spaced times of one period,

    ‖p‖ ≤ max over the grid of |p| / cos(πK/M)                                  (Ehlich and Zeller, 1964)

Proof. Let |p| be largest at t*, say p(t*) = ‖p‖ > 0. By a lemma of M. Riesz (1914), which is the sharp form of
Bernstein's inequality |p'| ≤ Kω‖p‖ with ω = 2π/T, p falls from its peak no faster than a cosine of degree K: p(t) ≥
‖p‖ cos(Kω(t - t*)) as long as Kω|t - t*| ≤ π. (Bernstein-Szegő: p'² + (Kω)² p² ≤ (Kω)² ‖p‖², so the angle
arccos(p/‖p‖) changes at most by Kω per second.) Some point of the grid lies within T/2M of t*, that is within πK/M in
the argument of the cosine; there |p| ≥ ‖p‖ cos(πK/M). Divide. ∎

The angle minus the middle of its range, the velocity and the acceleration of a Fourier motion are such polynomials of
the same degree, so a grid whose values stay below limit × cos(πK/M) keeps the limit at all times. With K = 5 and M =
500 the price is 0.05 % of the limit.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from exoid.ground.plain import AsJson
from exoid.measurement.trajectories.trajectory import Fourier, TrajectoryError
from exoid.symbolic.model_structure import TABLE_1, Limits
from exoid.symbolic.motion import Float

FINE = 8192
"""Points per period on which a finished motion is evaluated: with five harmonics the bound is then within 2e-6."""

UNITS = {"angle": "rad", "velocity": "rad/s", "acceleration": "rad/s²"}


def margin(harmonics: int, grid: int) -> float:
    """Return cos(πK/M), the share of a limit that values on the grid may use; see the proof above.

    TrajectoryError where the grid has too few points to prove anything.
    """
    if grid <= 2 * harmonics:
        what = f"{grid} points cannot bound a motion with {harmonics} harmonics"
        raise TrajectoryError(what, remedy=f"use more than {2 * harmonics} points per period")
    return float(np.cos(np.pi * harmonics / grid))


@dataclass(frozen=True)
class Use(AsJson):
    """The use of one limit by a motion: `low` to `high` can be reached at no time beyond, `limit` is (low, high)."""

    joint: str
    quantity: str
    low: float
    high: float
    limit: tuple[float, float]

    @property
    def unit(self) -> str:
        """The unit of the limit and of what is reached."""
        return UNITS[self.quantity]

    @property
    def share(self) -> float:
        """Largest share of the limit in use, about the middle of its range; above one the limit is broken."""
        middle, half = 0.5 * sum(self.limit), 0.5 * (self.limit[1] - self.limit[0])
        return max(self.high - middle, middle - self.low) / half

    @property
    def holds(self) -> bool:
        """True if the limit is proven to hold at all times."""
        return self.share <= 1.0 + 1e-12

    def _json(self) -> dict[str, Any]:
        return {**super()._json(), "unit": self.unit, "holds": self.holds}


def uses(trajectory: Fourier, limits: Mapping[str, Limits] = TABLE_1, grid: int = FINE) -> tuple[Use, ...]:
    """Return the use of each limit by `trajectory`, with bounds proven for all times."""
    stretch = 1.0 / margin(trajectory.sine.shape[1], grid)
    motion = trajectory.at(np.arange(grid) * (trajectory.period / grid))
    found = []
    for j, (joint, limit) in enumerate(limits.items()):
        for quantity, values, (low, high) in (
            ("angle", motion.q[:, j], limit.angle),
            ("velocity", motion.dq[:, j], (-limit.velocity, limit.velocity)),
            ("acceleration", motion.ddq[:, j], (-limit.acceleration, limit.acceleration)),
        ):
            # The polynomial that the proof is about: the value less its mean, whose two sides differ least.
            middle = 0.5 * float(values.max() + values.min())
            reach = 0.5 * float(np.ptp(values)) * stretch
            found.append(Use(joint, quantity, middle - reach, middle + reach, (low, high)))
    return tuple(found)


def shortest_period(trajectory: Fourier, limits: Mapping[str, Limits] = TABLE_1) -> float:
    """Return the shortest period in s for which these coefficients keep every limit; infinite where none does.

    Angles do not depend on the period, velocities go with 1/T and accelerations with 1/T².
    """
    powers = {"angle": 0, "velocity": 1, "acceleration": 2}
    shortest = 0.0
    for use in uses(trajectory, limits):
        if powers[use.quantity] == 0:
            if not use.holds:
                return float("inf")
        else:
            shortest = max(shortest, trajectory.period * use.share ** (1.0 / powers[use.quantity]))
    return shortest


def bounds(limits: Mapping[str, Limits], share: float = 1.0) -> Float:
    """Return (J, 4): low and high angle, speed and acceleration, each range shrunk about its middle to `share`."""
    rows = []
    for limit in limits.values():
        middle, half = 0.5 * sum(limit.angle), 0.5 * (limit.angle[1] - limit.angle[0]) * share
        rows.append((middle - half, middle + half, limit.velocity * share, limit.acceleration * share))
    return np.array(rows)
