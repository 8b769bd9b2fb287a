"""The loss of a fit over its shape parameters alone: at every trial the linear ones are solved exactly."""

from __future__ import annotations

import numpy as np

from exoid.ground.errors import ExpressionError
from exoid.optimisation.fitting.assemble import Assembly, Settled, settle
from exoid.optimisation.linear.loss import huber
from exoid.optimisation.linear.physical import Physics, solve_physical
from exoid.optimisation.linear.problem import LinearData
from exoid.optimisation.linear.solve import solve_huber, solve_sse
from exoid.symbolic.motion import Float


def solution(data: LinearData, delta: Float, possible: Physics | None, start: Float | None = None) -> Float:
    """Return the exact linear parameters (P,), among the possible ones where these are given."""
    if possible is not None:
        return solve_physical(data, delta, possible, start)
    return solve_sse(data) if np.isinf(delta).all() else solve_huber(data, delta, start)


class ShapeProblem:
    """The loss for thresholds `delta` (J,) over shape values (S,), or (R, S) with a row per recording where some are a
    recording's `own`; (1, S) is read as (S,) where none is.

    `reference` (P,) are parameters from which a torque that is fed back begins, `possible` the conditions on them.
    """

    def __init__(self, assembly: Assembly, delta: Float, possible: Physics | None, reference: Float | None) -> None:
        self.assembly, self.delta, self.possible, self.reference = assembly, delta, possible, reference
        self.own = any(entry.shape.per_recording for entry in assembly.model.shapes)
        self._known = reference  # of the shape before: few rounds lead from there to the next fixed point
        self._last: tuple[bytes, Settled] | None = None  # a descent asks for the shapes it has just tried

    def _form(self, shape: Float) -> Float:
        return shape if self.own or shape.ndim == 1 else shape[0]

    def _solve(self, data: LinearData) -> Float:
        return solution(data, self.delta, self.possible, self._known)

    def solved(self, shape: Float) -> Settled:
        """Return the linear parameters there, with their data."""
        shape = self._form(shape)
        key = shape.tobytes()
        if self._last is None or self._last[0] != key:
            found = settle(self.assembly, shape, self._solve, self._known)
            self._known = found.linear if found.converged else self.reference
            self._last = key, found
        return self._last[1]

    def loss(self, shape: Float) -> float:
        """Return the loss with the linear parameters solved anew; infinite where the torque is not finite.

        Friction that cannot be negative beside its own curve counts as none where it is.
        """
        try:
            found = self.solved(shape)
        except ExpressionError:
            return float("inf")
        return huber(found.data.residual(self._possible(found.linear)), self.delta)

    def _possible(self, linear: Float) -> Float:
        places = list(self.assembly.model.bent_friction)
        if not places:
            return linear
        linear = linear.copy()
        linear[places] = np.maximum(linear[places], 0.0)
        return linear

    def data(self, shape: Float, linear: Float) -> LinearData:
        """Return the linear data there, fed-back torques computed from `linear` (P,)."""
        return self.assembly.data(self._form(shape), linear if self.assembly.model.needs_reference else None)

    def at_once(self, nodes: Float) -> Float:
        """Return about the loss (V,) at all `nodes` (V, S), a fed-back torque held at what it is in the middle one."""
        fed_back = None
        if self.assembly.model.needs_reference:
            fed_back = self.solved(nodes[len(nodes) // 2]).linear
        if self.possible is None and np.isinf(self.delta).all() and not self.assembly.model.bent_friction:
            try:
                if (found := self.assembly.sse_at(nodes, fed_back)) is not None:
                    return found
            except ExpressionError:  # at some node: one by one
                pass
        if fed_back is None:
            return np.array([self.loss(node) for node in nodes])
        return np.array([self._held_loss(node, fed_back) for node in nodes])

    def _held_loss(self, shape: Float, fed_back: Float) -> float:
        try:
            data = self.assembly.data(shape, fed_back)
            return huber(data.residual(self._possible(self._solve(data))), self.delta)
        except ExpressionError:
            return float("inf")
