"""Motions to excite the leg with: a Fourier series per joint, scaled so that it stays inside the joint
limits.

    θ_i(t) = θ_i0 + Σ_{k=1..K} a_ik sin(kωt) + b_ik cos(kωt)          (13) of the paper

A series is made feasible by shrinking all its coefficients towards the offset by one factor per joint
("radial rescaling"): position, velocity and acceleration limits are then met by construction, so a search
always has something to follow.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.errors import ExoidError
from exoid.ground.html import table
from exoid.measurement.plots import motion_between_limits
from exoid.symbolic.model_structure import TABLE_1, Limits
from exoid.symbolic.motion import Float, Motion, read_only
from exoid.symbolic.quantity import JOINTS

if TYPE_CHECKING:
    from matplotlib.figure import Figure

CENTRE = (0.61, -0.925)
"""θ_0 of the paper, rad."""

GRID = 1024
"""Samples per period on which extremes are looked for; with ten harmonics a peak is missed by < 5e-4."""

ROUND_OFF = 1.0 - 5e-4


class TrajectoryError(ExoidError):
    """A trajectory that cannot be brought inside the limits, or whose numbers do not fit together."""


SHORTEST_PERIOD, LONGEST_PERIOD = 1e-3, 1e6
"""s; a joint does not swing faster, and nobody records longer."""
LARGEST = 1e3
"""rad; beyond it is another unit, or damage."""


@dataclass(frozen=True, eq=False)
class Fourier:
    """A periodic motion: `offset` (J,) and coefficients `sine`, `cosine` (J, K) in rad, `period` in s."""

    offset: Float
    sine: Float
    cosine: Float
    period: float

    def __post_init__(self) -> None:
        for name in ("offset", "sine", "cosine"):
            object.__setattr__(self, name, read_only(getattr(self, name)))
        joints = self.offset.shape
        if len(joints) != 1 or not joints[0] or self.sine.shape != self.cosine.shape or self.sine.shape[:1] != joints:
            what = f"offset {self.offset.shape}, sine {self.sine.shape}, cosine {self.cosine.shape} do not fit"
            raise TrajectoryError(what, remedy="give offset (J,), and sine and cosine of the same shape (J, harmonics)")
        if not SHORTEST_PERIOD <= self.period <= LONGEST_PERIOD:
            what = f"the period is {self.period} s, it must be positive"
            raise TrajectoryError(what, remedy=f"give {SHORTEST_PERIOD:g} to {LONGEST_PERIOD:g} s")
        largest = max(float(np.max(np.abs(x), initial=0.0)) for x in (self.offset, self.sine, self.cosine))
        if not largest <= LARGEST:
            raise TrajectoryError(f"a coefficient of {largest:g} rad", remedy=f"give numbers within ±{LARGEST:g} rad")

    def at(self, t: NDArray[np.floating[Any]]) -> Motion:
        """Return angle, velocity and acceleration at times `t` (N,) in s."""
        k = np.arange(1, self.sine.shape[1] + 1) * (2.0 * np.pi / self.period)
        s, c = np.sin(np.outer(t, k)), np.cos(np.outer(t, k))
        q = self.offset + s @ self.sine.T + c @ self.cosine.T
        dq = (c * k) @ self.sine.T - (s * k) @ self.cosine.T
        ddq = -(s * k**2) @ self.sine.T - (c * k**2) @ self.cosine.T
        return Motion(np.asarray(t, dtype=float), q, dq, ddq)

    def plot(self, limits: Mapping[str, Limits] = TABLE_1) -> Figure:
        """Draw angle, velocity and acceleration of one period between `limits`."""
        return motion_between_limits(self.at(np.linspace(0.0, self.period, 600)), limits)

    def _repr_html_(self) -> str:
        head = ("joint", "centre [rad]", *(f"{w} {k + 1}" for k in range(self.sine.shape[1]) for w in ("sin", "cos")))
        pairs = np.stack([self.sine, self.cosine], axis=2).reshape(len(self.offset), -1)
        joints = JOINTS if len(self.offset) == 2 else [f"joint {j + 1}" for j in range(len(self.offset))]
        rows = [(joint, *map(float, (self.offset[j], *pairs[j]))) for j, joint in enumerate(joints)]
        return table(head, rows, f"periodic motion, {self.period:g} s; coefficients in rad")

    def scaled(self, factor: NDArray[np.float64]) -> Fourier:
        """Return the motion with each joint's swing about its offset multiplied by `factor` (J,)."""
        column = np.asarray(factor, dtype=float)[:, None]
        return Fourier(self.offset, self.sine * column, self.cosine * column, self.period)


def largest_scale(trajectory: Fourier, limits: Mapping[str, Limits] = TABLE_1) -> NDArray[np.float64]:
    """Return per joint (J,) the factor that brings the motion's swing to the first limit it meets.

    Raises TrajectoryError when an offset lies outside the angle limits, where no factor can help.
    """
    t = np.linspace(0.0, trajectory.period, GRID + 1)
    motion = trajectory.at(t)
    factor = np.empty(len(limits))
    for j, (joint, limit) in enumerate(limits.items()):
        centre = float(trajectory.offset[j])
        low, high = limit.angle
        if not low < centre < high:
            what = f"the motion's centre {centre:g} rad lies outside [{low:g}, {high:g}] rad"
            raise TrajectoryError(what, where=joint, remedy="move the offset inside the angle limits of the model")
        swing = motion.q[:, j] - centre
        use = max(
            float(swing.max()) / (high - centre),
            float(-swing.min()) / (centre - low),
            float(np.abs(motion.dq[:, j]).max()) / limit.velocity,
            float(np.abs(motion.ddq[:, j]).max()) / limit.acceleration,
        )
        factor[j] = ROUND_OFF / use if use > 0 else 1.0
    return factor


def within(trajectory: Fourier, limits: Mapping[str, Limits] = TABLE_1, use: float = 1.0) -> Fourier:
    """Return the motion stretched per joint so that it uses the share `use` of the way to the first limit."""
    return trajectory.scaled(use * largest_scale(trajectory, limits))


def random_trajectory(
    rng: np.random.Generator,
    limits: Mapping[str, Limits] = TABLE_1,
    *,
    period: float = 10.0,
    harmonics: int = 5,
    use: float = 0.88,
) -> Fourier:
    """Draw a motion: random phases and weights, centred at random near mid-range, rescaled into the limits.

    `use` leaves room for the tracking error of the controller. Weights fall with the harmonic so that no
    single limit (acceleration, for equal weights) throttles the range of angles.
    """
    k = np.arange(1, harmonics + 1)
    weight = rng.uniform(0.3, 1.0, (len(limits), harmonics)) / k**0.4
    phase = rng.uniform(0.0, 2.0 * np.pi, (len(limits), harmonics))
    low, high = np.array([limit.angle for limit in limits.values()]).T
    offset = 0.5 * (low + high) + rng.uniform(-0.04, 0.04, len(limits)) * (high - low)
    return within(Fourier(offset, weight * np.cos(phase), weight * np.sin(phase), period), limits, use)


def paper_trajectory(period: float = 10.0) -> Fourier:
    """Return the published optimal motion. Its coefficients are printed in degrees and its period is not
    printed.

    From 9.6 s upwards every limit of Table 1 holds (the knee's velocity last); the knee comes within 4 mrad of its
    lower limit whatever the period.
    """
    sine = [[0.99, -0.68, -16.40, 11.49, -11.03], [-4.53, 3.53, -0.73, 6.46, -7.94]]
    cosine = [[1.28, -9.73, -15.52, -6.58, -4.06], [7.80, -2.91, -15.50, 10.30, -8.75]]
    return Fourier(np.array(CENTRE), np.deg2rad(sine), np.deg2rad(cosine), period)
