"""Recursive estimation: a square-root information filter that forgets each parameter at a pace of its own.

The information is kept as a triangle R with right side z, R θ = z; a new sample is rotated into it (Bierman,
Factorization Methods for Discrete Sequential Estimation, 1977). A parameter forgets only what new samples have taught
about *it*: by how much its variance has fallen is credited, and forgetting spends the credit, at most at its own pace.
Without excitation nothing is learnt and nothing forgotten, so nothing winds up. Samples are weighted by their residual
(Huber 1964), in units of a scale that follows within seconds: a burst passes by, a change does not.

Intervals are those of sums of scores over blocks of time, longer than residuals remember (the sandwich of
`optimisation.linear.uncertainty`, in recursive form), with Student's quantile for as many blocks as are remembered.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from scipy.stats import t as student

from symbolic.motion import Float
from symbolic.quantity import Estimate

ROBUST = 2.0
"""Scales beyond which a residual counts linearly."""
CREDIT = 20.0
"""Samples' worth of forgetting that may be saved up."""
LEAST_BLOCKS = 4.0
"""Blocks that must be remembered before an interval is told."""


@dataclass(frozen=True)
class Pace:
    """How long numbers are remembered, in s: `inertia` the inertial ones, `rest` all others; `block` s is the length
    over which scores are summed, `scale` s the memory of the residual's scale.
    """

    inertia: float = 300.0
    rest: float = 60.0
    block: float = 5.0
    scale: float = 10.0


@dataclass(eq=False)
class Estimator:
    """The state of the estimation of P parameters from J joints; `step` takes one sample.

    `forget` (P,) is the largest share of the information that a sample makes forgotten, `block` the samples of a block,
    `follow` the share by which the scale (J,) of the residual follows a sample. Torques count in `unit` (J,) N·m,
    the scale at first.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    forget: Float
    block: int
    follow: float
    unit: Float
    root: Float
    right: Float
    linear: Float
    variance: Float
    scale: Float = field(init=False)
    credit: Float = field(init=False)
    score: Float = field(init=False)
    meat: Float = field(init=False)
    blocks: float = 0.0
    inside: int = 0

    def __post_init__(self) -> None:
        count = self.linear.size
        self.scale = self.unit.copy()
        self.credit, self.score, self.meat = np.zeros(count), np.zeros(count), np.zeros((count, count))

    @classmethod
    def start(
        cls, names: Sequence[str], units: Sequence[str], linear: Float, spread: Float, scale: Float, rate: float,
        inertial: int, pace: Pace | None = None,
    ) -> Estimator:  # fmt: skip
        """Return an estimator that begins at `linear` (P,), each known to a standard deviation of `spread` (P,).

        `scale` (J,) N·m is that of the residual at first, `rate` Hz that of the samples; the first `inertial`
        parameters are inertial ones.
        """
        pace = pace or Pace()
        seconds = np.where(np.arange(linear.size) < inertial, pace.inertia, pace.rest)
        return cls(
            tuple(names), tuple(units), 1.0 / (seconds * rate), max(1, round(pace.block * rate)),
            1.0 / (pace.scale * rate), np.array(scale, dtype=float), np.diag(1.0 / spread), linear / spread,
            np.array(linear, dtype=float), spread**2,
        )  # fmt: skip

    def step(self, columns: Float, tau: Float, use: Sequence[bool] | np.ndarray) -> None:
        """Take one sample: `columns` (J, P), torque (J,) N·m and which joints can be used."""
        if not any(use):
            return
        rows = []
        for j, row in enumerate(columns):
            if use[j]:
                left = tau[j] - row @ self.linear
                rows.append(np.append(row, tau[j]) * np.sqrt(self._weight(j, left)))
                self.scale[j] = np.sqrt(
                    self.scale[j] ** 2 + self.follow * (min(left**2, (3.0 * self.scale[j]) ** 2) - self.scale[j] ** 2)
                )
        self._rotate(rows)
        inverse = np.linalg.inv(self.root)
        self.linear = inverse @ self.right
        variance = np.sum(inverse**2, axis=1)
        gain = np.clip(1.0 - variance / self.variance, 0.0, 1.0)
        self.credit = np.minimum(self.credit + gain, CREDIT * self.forget)
        lost = np.minimum(self.forget, self.credit)
        self.credit -= lost
        kept = 1.0 - lost
        self.root = self.root * np.sqrt(kept)
        self.right = self.root @ self.linear
        self.variance = variance / kept
        for j, row in enumerate(columns):
            if use[j]:
                left = tau[j] - row @ self.linear
                self.score = self.score + self._weight(j, left) * left * row
        self.meat = self.meat * np.outer(kept, kept)
        self.blocks *= float(kept.mean()) ** 2
        self.inside += 1
        if self.inside == self.block:
            self.meat += np.outer(self.score, self.score)
            self.score = np.zeros_like(self.score)
            self.inside = 0
            self.blocks += 1.0

    def _weight(self, joint: int, left: float) -> float:
        scale = float(self.scale[joint])
        return min(1.0, ROBUST * scale / max(abs(left), 1e-300)) / self.unit[joint] ** 2

    def _rotate(self, rows: Sequence[Float]) -> None:
        """Rotate weighted rows (P + 1,) of columns and torque into the triangle."""
        count = self.right.size
        whole = np.vstack([np.column_stack([self.root, self.right]), *rows])
        triangle = np.array(np.linalg.qr(whole, mode="r"))[:count]
        triangle *= np.where(np.diag(triangle) < 0.0, -1.0, 1.0)[:, None]
        self.root, self.right = triangle[:, :count], triangle[:, count]

    def covariance(self) -> Float:
        """Return the covariance (P, P) of the parameters, valid under autocorrelation."""
        inverse = np.linalg.inv(self.root)
        bread = inverse @ inverse.T
        return np.asarray(bread @ self.meat @ bread)

    def estimates(self) -> tuple[Estimate, ...]:
        """Return the parameters with their 95 % intervals; infinite where too little has been seen to tell."""
        half = np.full(self.linear.size, np.inf)
        if self.blocks >= LEAST_BLOCKS:
            critical = float(student.ppf(0.975, self.blocks - 1.0))
            half = critical * np.sqrt(np.maximum(np.diag(self.covariance()), 0.0))
        return tuple(
            Estimate(n, float(v), u, float(v - h), float(v + h))
            for n, u, v, h in zip(self.names, self.units, self.linear, half, strict=True)
        )
