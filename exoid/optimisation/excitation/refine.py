"""From a good motion to the best one near it: sequential quadratic programming with the limits as what they are.

Stretched to its limits a motion's value has a kink wherever another instant or another limit becomes the first. Left
unstretched the limits are linear in the coefficients and the criterion is smooth but where eigenvalues change places,
so SciPy's SLSQP follows its gradient along the limits, within a region that shrinks where that does not help. A step
counts only where the stretched motion is better by the exact criterion. It ends at a local optimum, as a rule.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from exoid.optimisation.excitation.criteria import CRITERIA, PIECES, Aim
from exoid.optimisation.excitation.space import MotionSpace
from exoid.symbolic.codegen.information import Information
from exoid.symbolic.motion import Float

NEAR = 0.15
"""Share of a limit's range within which an instant is watched: a step of `RADIUS` hardly takes others there."""
RADIUS, SMALLEST = 0.3, 1e-3
"""How far a coefficient may go in one round, as a share of its harmonic's largest amplitude, and where to give up."""
ROUNDS, STEPS = 8, 25
"""Rounds, and steps of SLSQP in each."""
GAIN = 1e-5
"""Relative gain below which a round was the last."""
STEP = 1e-6
"""Step of the differences that give gradients."""


@dataclass(frozen=True, eq=False)
class Refinement:
    """Descends `criterion` from points of `space`, inside its limits."""

    info: Information
    space: MotionSpace
    aim: Aim
    criterion: str

    def refined(self, y: Float, value: float) -> tuple[Float, float, int]:
        """Return the best point (n,) near a stretched one that is worth `value`, what it is worth, and the motions
        evaluated; the same point where nothing near is better.
        """
        spent, radius = 0, RADIUS
        for _ in range(ROUNDS):
            if not np.isfinite(value) or radius < SMALLEST:
                break
            trial, count = self._round(y, radius)
            swings, offsets = self.space.split(trial[None])
            sums = self.info.sums(swings, offsets, rescale=True)
            reached = float(CRITERIA[self.criterion](sums.gram, self.aim)[0])
            spent += count + 1
            if not reached < value:
                radius *= 0.25
                continue
            gained, value = value - reached, reached
            y = trial.copy()
            width = self.space.basis.shape[2]
            y[: len(self.space.limits) * width] *= np.repeat(sums.factor[0], width)
            if gained <= GAIN * abs(value):
                break
        return y, value, spent

    def _round(self, y: Float, radius: float) -> tuple[Float, int]:
        """End of SLSQP within `radius`, and the motions evaluated."""
        from scipy.optimize import minimize

        slopes, low, high = self._limits
        along, size = slopes @ y, len(y)
        over, under = along > high - NEAR, along < low + NEAR
        rows, room = np.vstack([slopes[over], -slopes[under]]), np.concatenate([high[over], -low[under]])
        pieces, edge = _Pieces(self), self._edge
        bounds = [*zip(np.maximum(y - radius, -edge), np.minimum(y + radius, edge), strict=True)]
        options = {"maxiter": STEPS, "ftol": 1e-8}
        inside = {"type": "ineq", "fun": lambda x: room - rows @ x[:size]}
        if len(pieces.values(y)) == 1:
            ended = minimize(
                lambda x: float(pieces.values(x)[0]), y, jac=lambda x: pieces.slopes(x)[0], method="SLSQP",
                bounds=bounds, constraints=[inside | {"jac": lambda x: -rows}], options=options,
            )  # fmt: skip
            return np.clip(ended.x, -edge, edge), pieces.count
        # The largest of several smooth pieces is the least bound above all of them: one more variable.
        unit, wider = np.append(np.zeros(size), 1.0), -np.pad(rows, ((0, 0), (0, 1)))
        below = {
            "type": "ineq",
            "fun": lambda x: x[-1] - pieces.values(x[:size]),
            "jac": lambda x: np.pad(-pieces.slopes(x[:size]), ((0, 0), (0, 1)), constant_values=1.0),
        }
        ended = minimize(
            lambda x: float(x[-1]), np.append(y, pieces.values(y).max()), jac=lambda x: unit, method="SLSQP",
            bounds=[*bounds, (None, None)], constraints=[inside | {"jac": lambda x: wider}, below], options=options,
        )  # fmt: skip
        return np.clip(ended.x[:-1], -edge, edge), pieces.count

    @cached_property
    def _edge(self) -> Float:
        """Limits of coordinates (n,): an offset between its limits, a coefficient as far as the limits let it."""
        edge = np.full(self.space.size, np.inf)
        if self.space.centre is None:
            edge[-len(self.space.limits) :] = 1.0
        return edge

    @cached_property
    def _limits(self) -> tuple[Float, Float, Float]:
        """The limits as low ≤ A y ≤ high, in shares of each range: A (L, n), low and high (L,)."""
        size = self.space.size
        start = self._motion(np.zeros(size))
        slopes = np.column_stack([self._motion(unit) - start for unit in np.eye(size)])
        ranges = [((a, b), (-v, v), (-c, c)) for a, b, v, c in self.space.limits]
        edges = np.repeat(np.array(ranges, dtype=float).reshape(-1, 2), self.info.grid, axis=0)
        width = edges[:, 1] - edges[:, 0]
        return slopes / width[:, None], (edges[:, 0] - start) / width, (edges[:, 1] - start) / width

    def _motion(self, y: Float) -> Float:
        """Return angle, velocity and acceleration of every joint on the grid, one behind the other."""
        swings, offsets = self.space.split(y[None])
        at = self.space.trajectory(swings[0], offsets[0]).at(self.info.times)
        return np.concatenate([row for j in range(len(offsets[0])) for row in (at.q[:, j], at.dq[:, j], at.ddq[:, j])])


class _Pieces:
    """The pieces of the criterion at the point asked for last, and how many motions were evaluated."""

    def __init__(self, of: Refinement) -> None:
        self._of, self.count = of, 0
        self._at, self._values = np.zeros(0), np.zeros(0)

    def values(self, x: Float) -> Float:
        """Return the pieces (K,) of the unstretched motion `x` (n,)."""
        if not np.array_equal(x, self._at):
            self._at, self._values = x.copy(), self._evaluated(x[None])[0]
        return self._values

    def slopes(self, x: Float) -> Float:
        """Return the derivatives (K, n) of the pieces."""
        return (self._evaluated(x + STEP * np.eye(len(x))) - self.values(x)).T / STEP

    def _evaluated(self, points: Float) -> Float:
        self.count += len(points)
        swings, offsets = self._of.space.split(points)
        gram = self._of.info.sums(swings, offsets, rescale=False).gram
        return PIECES[self._of.criterion](gram, self._of.aim)
