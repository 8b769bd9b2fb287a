"""Recursive estimation: a square-root information filter that forgets each parameter at a pace of its own.

The information is kept as a triangle R with right side z, R θ = z; a new sample is rotated into it (Bierman,
Factorization Methods for Discrete Sequential Estimation, 1977). A parameter forgets only what new samples have taught
about *it*: by how much its variance has fallen is credited, and forgetting spends the credit, at most at its own pace.
Without excitation nothing is learnt and nothing forgotten, so nothing winds up. Numbers are forgotten as if they had
moved by a small step, which is correlated as what is known of them is: sums that are known well stay so as long as
others do. (With a step of its own for each number such sums last for a second only, and what is learnt beside them
seems certain; to let go of a share of all that is known of each turns them into other sums, which no sample has told.)
Samples are weighted by their residual (Huber 1964), in units of a scale that follows within seconds: a burst passes by,
a change does not.

What is known to have changed is forgotten at once (`forget`): as if it had moved by a step of unknown size since the
last sample, the time update of the same filter. What was learnt about the other numbers stays, as far as it does not
rest on it.

Noise of the angles is in the columns too, and pulls numbers towards zero where the motion is small (errors in
variables). How much information it feigns is known from its size and from the filters; the numbers and their scores are
corrected for that (Fuller, Measurement Error Models, 1987; Nakamura 1990), by the first terms of a series, which cannot
run away where the motion tells less than the noise.

Intervals are those of sums of scores over blocks of time, longer than residuals remember (the sandwich of
`exoid.optimisation.linear.uncertainty`, in recursive form), with Student's quantile for as many blocks as are
remembered of each parameter.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence
from ctypes import c_long, c_void_p
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from scipy.linalg.lapack import dgeqrf, dtrtri
from scipy.stats import t as student

from exoid.apps.watch.recursive.estimator_c import kernel, layout
from exoid.ground.thresholds import Threshold
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate

ROBUST: Threshold = 2.0
"""scales beyond which a residual counts linearly: a burst would move the numbers"""
CREDIT: Threshold = 20.0
"""samples' worth of forgetting that may be saved up: a long rest would be followed by a jump"""
LEAST_BLOCKS: Threshold = 4.0
"""blocks remembered before an interval is reported: a scatter of two or three is chance"""


TERMS = 3
"""Terms of the correction for noise in the columns; what is left is its share of the information to the fourth."""
FORGOTTEN, FORGOTTEN_LEAST = 1.0, 0.1
"""A number that is forgotten is known to this part of itself, and to no less than this in its unit."""


@dataclass(frozen=True)
class Pace:
    """The time for which numbers are remembered, in s: `inertia` the inertial ones, `rest` all others; `block` s is the
    length over which scores are summed, `scale` s the memory of the residual's scale.
    """

    inertia: float = 300.0
    rest: float = 60.0
    block: float = 5.0
    scale: float = 10.0


def constants(estimator: Estimator) -> dict[str, Any]:
    """Return the constants that the C text names, {key: text}."""
    return {
        "P": estimator.linear.size, "J": len(estimator.unit), "ROBUST": repr(ROBUST), "CREDIT": repr(CREDIT),
        "BLOCK": estimator.block, "FOLLOW": repr(estimator.follow), "TERMS": TERMS,
    }  # fmt: skip


@dataclass(eq=False)
class Estimator:
    """The state of the estimation of P parameters from J joints; `step` takes one sample.

    `pace` (P,) is the largest share of the information that a sample makes forgotten, `block` the samples of a block,
    `follow` the share by which the scale (J,) of the residual follows a sample. Torques count in `unit` (J,) N·m,
    the scale at first.
    """

    names: tuple[str, ...]
    units: tuple[str, ...]
    pace: Float
    block: int
    follow: float
    unit: list[float]
    root: Float
    right: Float
    linear: Float
    variance: Float
    scale: list[float] = field(init=False)
    credit: Float = field(init=False)
    score: Float = field(init=False)
    meat: Float = field(init=False)
    feigned: Float = field(init=False)
    """The part (P, P) of the information that noise of the angles makes up."""
    blocks: Float = field(init=False)
    inside: int = 0

    def __post_init__(self) -> None:
        count = self.linear.size
        self.scale = list(self.unit)
        self.credit, self.score, self.blocks = np.zeros(count), np.zeros(count), np.zeros(count)
        self.meat, self.feigned = np.zeros((count, count)), np.zeros((count, count))

    @classmethod
    def start(
        cls, model: Model, linear: Float, spread: Float, scale: Float, rate: float, pace: Pace | None = None
    ) -> Estimator:
        """Return an estimator that begins at `linear` (P,), each known to a standard deviation of `spread` (P,).

        `scale` (J,) N·m is that of the residual at first, `rate` Hz that of the samples.
        """
        pace = pace or Pace()
        seconds = np.where(np.arange(linear.size) < len(model.inertial), pace.inertia, pace.rest)
        return cls(
            tuple(p.name for p in model.parameters), tuple(p.unit for p in model.parameters), 1.0 / (seconds * rate),
            max(1, round(pace.block * rate)), 1.0 / (pace.scale * rate), [float(x) for x in scale],
            np.diag(1.0 / spread), linear / spread, np.array(linear, dtype=float), spread**2,
        )  # fmt: skip

    def step(
        self, columns: Float, tau: Float, use: Sequence[bool] | np.ndarray, errors: Float | None = None
    ) -> None:
        """Take one sample: `columns` (J, P), torque (J,) N·m and which joints can be used; `errors` (J, A, P) is what
        one standard deviation of the noise of each of A angles makes of the columns.
        """
        used = [j for j in range(len(tau)) if use[j]]
        if not used:
            return
        columns, tau = columns[used], tau[used]
        noise = np.zeros((len(used), 0, columns.shape[1])) if errors is None else errors[used]
        left = (tau - columns @ self.linear).tolist()
        weights = [self._weight(j, value) for j, value in zip(used, left, strict=True)]
        for j, value in zip(used, left, strict=True):
            most = min(value**2, (3.0 * self.scale[j]) ** 2)
            self.scale[j] = math.sqrt(self.scale[j] ** 2 + self.follow * (most - self.scale[j] ** 2))
        inverse = self._rotate(np.column_stack([columns, tau]) * np.sqrt(weights)[:, None])
        if noise.size:
            self.feigned += np.einsum("j,jap,jaq->pq", weights, noise, noise)
        plain = inverse @ self.right
        self.linear = plain
        for _ in range(TERMS):
            self.linear = plain + inverse @ (inverse.T @ (self.feigned @ self.linear))
        variance = np.einsum("kp,kp->k", inverse, inverse)
        gain = np.maximum(1.0 - variance / self.variance, 0.0)
        credit = np.minimum(self.credit + gain, CREDIT * self.pace)
        lost = np.minimum(self.pace, credit)
        self.credit = credit - lost
        self.variance = variance / (1.0 - lost)
        if lost.any():
            self._moved(np.sqrt(lost / (1.0 - lost))[:, None] * inverse, inverse)
        left = (tau - columns @ self.linear).tolist()
        weights = [self._weight(j, value) for j, value in zip(used, left, strict=True)]
        self.score = self.score + np.multiply(weights, left) @ columns
        self.score += np.einsum("j,jap,ja->p", weights, noise, noise @ self.linear)
        self.blocks = self.blocks * (1.0 - lost) ** 2
        self.inside += 1
        if self.inside == self.block:
            self.meat += np.outer(self.score, self.score)
            self.score = np.zeros_like(self.score)
            self.inside = 0
            self.blocks = self.blocks + 1.0

    def steps(self, columns: Float, tau: Float, use: np.ndarray, errors: Float | None = None) -> None:
        """Take samples in a row: `columns` (N, J, P), torque (N, J) N·m, `use` (N, J) and `errors` (N, J, J, P), as
        `step` does; compiled where that works.
        """
        if errors is None:
            errors = np.zeros((*columns.shape[:2], *columns.shape[1:]))
        compiled = kernel(constants(self))
        if compiled is None:
            for row, value, usable, noise in zip(columns, tau, use, errors, strict=True):
                self.step(row, value, usable, noise)
            return
        state = np.zeros((), layout(self.linear.size, len(self.unit)))
        for name in state.dtype.names or ():
            state[name] = getattr(self, name)
        kinds = ((columns, float), (tau, float), (use, np.intc), (errors, float))
        given = [np.ascontiguousarray(values, kind) for values, kind in kinds]
        compiled(state.ctypes.data_as(c_void_p), c_long(len(tau)), *(x.ctypes.data_as(c_void_p) for x in given))
        for name in state.dtype.names or ():
            plain = name in ("scale", "unit", "inside")
            setattr(self, name, state[name].tolist() if plain else state[name].copy())

    def _weight(self, joint: int, left: float) -> float:
        return min(1.0, ROBUST * self.scale[joint] / max(abs(left), 1e-300)) / self.unit[joint] ** 2

    def _rotate(self, rows: Float) -> Float:
        """Rotate weighted rows (K, P + 1) of columns and torque into the triangle; return its inverse."""
        triangle = _triangle(np.vstack([np.column_stack([self.root, self.right]), rows]))[: self.right.size]
        self.root, self.right = triangle[:, :-1], triangle[:, -1]
        return np.asarray(dtrtri(self.root)[0])

    def forget(self, which: Iterable[int]) -> None:
        """Forget the parameters `which`: nothing that was learnt about them counts from here on."""
        some, size = list(which), np.zeros(self.linear.size)
        size[some] = FORGOTTEN * np.abs(self.linear[some]) + FORGOTTEN_LEAST
        self._moved(np.diag(size), np.asarray(np.linalg.inv(self.root)), known=True)
        self.credit[some] = self.blocks[some] = 0.0
        inverse = np.linalg.inv(self.root)
        self.variance = np.einsum("kp,kp->k", inverse, inverse)

    def extended(self, names: tuple[str, ...], units: tuple[str, ...], values: Float) -> Estimator:
        """Return the same with further parameters, of which little more is known than these `values` (m,)."""
        count, more = self.linear.size, len(names)
        spread = FORGOTTEN * np.abs(values) + 1e-9
        out = Estimator(
            self.names + names, self.units + units, np.append(self.pace, np.full(more, self.pace.max())), self.block,
            self.follow, list(self.unit), np.diag(np.append(np.zeros(count), 1.0 / spread)),
            np.append(self.right, values / spread), np.append(self.linear, values), np.append(self.variance, spread**2),
        )  # fmt: skip
        out.root[:count, :count], out.scale, out.inside = self.root, list(self.scale), self.inside
        out.meat[:count, :count], out.feigned[:count, :count] = self.meat, self.feigned
        out.meat[range(count, count + more), range(count, count + more)] = 1.0 / spread**2
        for name in ("credit", "score", "blocks"):
            getattr(out, name)[:count] = getattr(self, name)
        return out

    def _moved(self, by: Float, inverse: Float, known: bool = False) -> None:
        """Go on as if the parameters had moved by steps of covariance `by` `by`ᵀ; `inverse` is that of the triangle.
        Where it is `known` that they have, the steps count into the intervals.
        """
        count, wide = self.linear.size, by.shape[1]
        rows = np.zeros((wide + count, wide + count + 1))
        rows[:wide, :wide] = np.eye(wide)
        rows[wide:] = np.column_stack([-self.root @ by, self.root, self.right])
        rows = _triangle(rows)[wide:, wide:]
        self.root, self.right = rows[:, :-1], rows[:, -1]
        # What scores say once the steps are left free, and how far these may have gone.
        information = self.root.T @ self.root
        left = information @ inverse @ inverse.T
        self.score, self.feigned = left @ self.score, left @ self.feigned
        self.meat = left @ self.meat @ left.T
        if known:
            self.meat += information @ by @ by.T @ information

    def covariance(self) -> Float:
        """Return the covariance (P, P) of the parameters, valid under autocorrelation."""
        inverse = np.linalg.inv(self.root)
        bread = plain = inverse @ inverse.T
        for _ in range(TERMS):
            bread = plain + plain @ self.feigned @ bread
        return np.asarray(bread @ self.meat @ bread.T)

    def estimates(self) -> tuple[Estimate, ...]:
        """Return the parameters with their 95 % intervals; infinite where too little has been seen to tell."""
        enough = self.blocks >= LEAST_BLOCKS
        critical = student.ppf(0.975, np.where(enough, self.blocks - 1.0, 1.0))
        half = np.where(enough, critical * np.sqrt(np.maximum(np.diag(self.covariance()), 0.0)), np.inf)
        return tuple(
            Estimate(n, float(v), u, float(v - h), float(v + h))
            for n, u, v, h in zip(self.names, self.units, self.linear, half, strict=True)
        )


def _triangle(rows: Float) -> Float:
    """Return the triangle (M, M) of rows (N, M), or all of it where there are fewer than M, its diagonal positive."""
    # LAPACK directly: for matrices this small, what NumPy does around it takes most of the time.
    triangle = np.triu(dgeqrf(np.asfortranarray(rows), overwrite_a=1)[0][: rows.shape[1]])
    return np.asarray(triangle * np.where(np.diag(triangle) < 0.0, -1.0, 1.0)[:, None])
