"""The problem that is searched: the linear data of a fit, and the box in which an optimiser may look.

The rule for the box, so that it contains the optimum by construction and nobody has to guess bounds:

* SSE: Y = QR and z = RΦ give |z_SSE| = |Qᵀτ| ≤ |τ|. The box is centred on zero with half-width |τ|.
* Huber: Qᵀ clip(r, δ) = 0 at the optimum gives z_SSE - z_Huber = Qᵀe with e the part of the residual beyond
  δ, and Σ 2δ|e| ≤ Huber(Φ_Huber) ≤ Huber(Φ_SSE). The box is centred on z_SSE with half-width
  Huber(Φ_SSE) · max_i |Q_i| / 2δ_i, where Q_i are the rows of Q.

In physical coordinates it is the smallest box around that ball: half-width times the row lengths of R⁻¹.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from copy import copy
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from exoid.ground.errors import NotEnoughDataError, RecordingError
from exoid.optimisation.linear.factor import Factor, factorise
from exoid.optimisation.linear.loss import Bool, huber
from exoid.symbolic.joints import Joint
from exoid.symbolic.motion import Float

Fitness = Callable[[Float], Float]


@dataclass(frozen=True, eq=False)
class LinearData:
    """τ ≈ YΦ: `columns` (J, N, P), `tau` (J, N) N·m, `groups` (N,) recording index, `use` (J, N) usable
    samples.

    `factoriser` is what finds `factor`: one that remembers (`Factors`) where columns come again.
    Rows that are not usable are set to zero in `columns` and `tau`: they then weigh nothing in any loss.
    Refuses shapes that do not match and usable values that are not finite.
    """

    columns: Float
    tau: Float
    groups: NDArray[np.int64]
    names: tuple[str, ...]
    units: tuple[str, ...]
    use: Bool = None  # type: ignore[assignment]
    factoriser: Callable[[Float], Factor] = field(default=factorise, repr=False)
    owned: bool = field(default=False, repr=False)
    """Whether `columns` are nobody else's, so that they need not be copied."""

    def __post_init__(self) -> None:
        tau = np.array(self.tau, dtype=float)
        columns = np.ascontiguousarray(self.columns) if self.owned else np.array(self.columns, dtype=float)
        use = np.ones(tau.shape, dtype=bool) if self.use is None else np.array(self.use, dtype=bool)
        groups = np.array(self.groups, dtype=np.int64)
        joints, samples, width = columns.shape
        if tau.shape != (joints, samples) or use.shape != tau.shape or groups.shape != (samples,):
            raise ValueError(f"columns {columns.shape}, tau {tau.shape}, use {use.shape}, groups {groups.shape}")
        if len(self.names) != width or len(self.units) != width:
            raise ValueError(f"{width} columns but {len(self.names)} names and {len(self.units)} units")
        if not use.all():
            columns[~use] = 0.0
            tau[~use] = 0.0
        self._refuse_infinite(columns, tau)
        for array in (columns, tau, use, groups):
            array.setflags(write=False)
        for name, value in (
            ("columns", columns),
            ("tau", tau),
            ("use", use),
            ("groups", groups),
        ):
            object.__setattr__(self, name, value)

    def _refuse_infinite(self, columns: Float, tau: Float) -> None:
        if np.isfinite(columns.sum() + tau.sum()) or (np.isfinite(columns).all() and np.isfinite(tau).all()):
            return
        bad = [n for p, n in enumerate(self.names) if not np.isfinite(columns[:, :, p]).all()]
        raise RecordingError(
            "values that are not finite numbers reached the fit",
            where=", ".join(bad) or "torque",
            remedy="check the recording and the bounds of the effect's shape parameters",
        )

    @property
    def matrix(self) -> Float:
        """The regressor Ȳ with all joints stacked (J·N, P)."""
        return self.columns.reshape(-1, self.columns.shape[2])

    @property
    def vector(self) -> Float:
        """The torque with all joints stacked (J·N,), N·m."""
        return self.tau.reshape(-1)

    @cached_property
    def factor(self) -> Factor:
        """The regressor in whitened coordinates, with its rank and condition number."""
        return self.factoriser(self.matrix)

    @property
    def alone(self) -> LinearData:
        """The same without what was computed of it and what would compute it faster: to be kept."""
        kept = copy(self)
        vars(kept).pop("factor", None)
        object.__setattr__(kept, "factoriser", factorise)
        return kept

    def weighted(self, weight: Float) -> LinearData:
        """Return the same with every joint's torque times its `weight` (J,): in the units that a loss then counts."""
        if np.all(weight == 1.0):
            return self
        return replace(
            self, columns=self.columns * weight[:, None, None], tau=self.tau * weight[:, None], owned=True
        )

    def require_enough(self, joints: Sequence[Joint]) -> None:
        """Refuse data with fewer usable samples than parameters; one of `joints` that never moves may have none."""
        counts = self.use.sum(axis=1)
        for joint, count in zip(joints, counts, strict=True):
            if 0 < count <= len(self.names) or not counts.any():
                raise NotEnoughDataError(
                    f"only {int(count)} usable samples for {len(self.names)} parameters",
                    where=joint.name,
                    remedy="use a longer recording, or see in the audit why samples were left out",
                )

    def residual(self, linear: Float) -> Float:
        """Return τ - YΦ (J, N) in N·m for `linear` (P,); zero where a sample is not usable."""
        return self.tau - self.columns @ linear

    def rms(self, linear: Float) -> Float:
        """Return the RMS residual of each joint (J,) over its usable samples, N·m."""
        square = np.sum(self.residual(linear) ** 2, axis=1)
        return np.asarray(np.sqrt(square / np.maximum(self.use.sum(axis=1), 1)))


@dataclass(frozen=True, eq=False)
class Ball:
    """Ball that holds the optimum: |z - centre| ≤ radius with z = WΦ (`factor`)."""

    factor: Factor
    centre: Float
    radius: float


@dataclass(frozen=True, eq=False)
class Problem:
    """Minimise `fitness` ((I, n) -> (I,)) inside [`low`, `high`] (n,).

    `transform` (P, n) leads from the coordinates searched in back to physical parameters (None: the same);
    `ball` is what `whitened()` needs.
    """

    fitness: Fitness
    low: Float
    high: Float
    names: tuple[str, ...]
    units: tuple[str, ...]
    ball: Ball | None = None
    transform: Float | None = None

    def physical(self, x: Float) -> Float:
        """Return the physical parameters (..., P) of points `x` (..., n)."""
        return np.array(x, dtype=float) if self.transform is None else np.asarray(x) @ self.transform.T

    def whitened(self) -> Problem:
        """Return the same problem searched in z = RΦ, where Euclidean nearness means a similar torque.

        Refuses a problem that is not linear in its parameters (it has no R).
        """
        if self.ball is None:
            raise ValueError("only a problem that is linear in its parameters can be whitened")
        backward, fitness = self.ball.factor.backward, self.fitness
        count = self.ball.centre.size
        return Problem(
            fitness=lambda z: fitness(np.ascontiguousarray(z @ backward.T)),
            low=self.ball.centre - self.ball.radius,
            high=self.ball.centre + self.ball.radius,
            names=tuple(f"z{i + 1}" for i in range(count)),
            units=("N·m",) * count,
            transform=backward,
        )


def _boxed(data: LinearData, fitness: Fitness, centre: Float, radius: float) -> Problem:
    factor = data.factor
    middle = factor.backward @ centre
    half = radius * np.linalg.norm(factor.backward, axis=1)
    return Problem(fitness, middle - half, middle + half, data.names, data.units, Ball(factor, centre, radius))


def sse_problem(data: LinearData, fitness: Fitness) -> Problem:
    """Return the SSE problem of `data`, whose SSE is `fitness` ((I, P) -> (I,))."""
    radius = float(np.linalg.norm(data.vector)) or 1.0
    return _boxed(data, fitness, np.zeros(data.factor.rank), radius)


def huber_problem(data: LinearData, fitness: Fitness, delta: Float, sse_linear: Float) -> Problem:
    """Return the Huber problem for thresholds `delta` (J,), boxed around the SSE solution (P,)."""
    reach = np.linalg.norm(data.factor.basis, axis=1) / np.repeat(2.0 * delta, data.tau.shape[1])
    radius = huber(data.residual(sse_linear), delta) * float(np.max(reach))
    floor = 1e-9 * (float(np.linalg.norm(data.vector)) or 1.0)
    return _boxed(data, fitness, data.factor.forward @ sse_linear, max(radius, floor))
