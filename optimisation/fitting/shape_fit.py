"""The search over shape parameters, each trial solved exactly in the linear ones."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from ground.errors import ExoidError, ExpressionError
from optimisation.fitting.assemble import Assembly, Settled, settle
from optimisation.fitting.local_shape import ShapeProblem, descend, own_shapes
from optimisation.fitting.phases import turning, with_phases
from optimisation.fitting.settings import MULTISTART
from optimisation.fitting.shapes import GRID, ShapeMethod, search_shape
from optimisation.linear.loss import huber
from optimisation.linear.physical import Physics, solve_physical
from optimisation.linear.problem import LinearData
from optimisation.linear.solve import solve_huber, solve_sse
from optimisation.optimisers import optimisers as optimiser_kinds
from symbolic.motion import Float

FULL_STARTS, FULL_APART = 6, 0.08
"""Starts of the local searches, and how far apart they begin, when more is asked for than the light mode."""


def shape_method(name: str, full: bool, seed: int) -> ShapeMethod:
    """Return how shapes are searched; refuses a name that is neither "multistart" nor an optimiser."""
    known = {} if name == MULTISTART else optimiser_kinds()
    if name != MULTISTART and name not in known:
        raise ExoidError(
            f"there is no way to search shapes called {name!r}",
            where="shape_search",
            remedy=f"use {MULTISTART}, {', '.join(known)}",
        )
    if name == MULTISTART and not full:
        return GRID
    optimiser = None if name == MULTISTART else known[name]()
    return ShapeMethod(optimiser, FULL_STARTS, None, FULL_APART, seed)


def solution(data: LinearData, delta: Float, possible: Physics | None, start: Float | None = None) -> Float:
    """Return the exact linear parameters (P,), among the possible ones where these are given."""
    if possible is not None:
        return solve_physical(data, delta, possible, start)
    return solve_sse(data) if np.isinf(delta).all() else solve_huber(data, delta, start)


def solve_shape(
    assembly: Assembly,
    delta: Float,
    fixed: Float | None,
    starts: Sequence[Float] | Float | None,
    reference: Float | None = None,
    possible: Physics | None = None,
    method: ShapeMethod = GRID,
) -> tuple[Float, Settled, Sequence[Float] | Float, tuple[int, int] | None]:
    """Return the best shape values ((S,), or (R, S) where recordings have their own), the linear solution
    there, where a next stage may start, and how many of how many starts agree.
    """

    def solve(data: LinearData) -> Float:
        return solution(data, delta, possible)

    known = reference  # of the shape before: few rounds lead from there to the next fixed point
    last: dict[bytes, Settled] = {}  # a descent asks for the shapes it has just tried

    def solved(shape: Float) -> Settled:
        nonlocal known
        if (key := shape.tobytes()) not in last:
            found = settle(assembly, shape, solve, known)
            known = found.linear if found.converged else reference
            last.clear()
            last[key] = found
        return last[key]

    def loss(shape: Float) -> float:
        try:
            found = solved(shape)
        except ExpressionError:  # the torque is not finite there: no place to look for the optimum
            return float("inf")
        return huber(found.data.residual(found.linear), delta)

    def at_once(nodes: Float) -> Float:
        fed_back = solved(nodes[len(nodes) // 2]).linear if assembly.model.needs_reference else None
        if sse:
            try:
                if (found := assembly.sse_at(nodes, fed_back)) is not None:
                    return found
            except ExpressionError:  # at some node: one by one
                pass
        if fed_back is None:
            return np.array([loss(node) for node in nodes])
        return np.array([_held_loss(assembly, node, fed_back, solve, delta) for node in nodes])

    sse = possible is None and bool(np.isinf(delta).all())
    shapes = [s.shape for s in assembly.model.shapes]
    if not shapes or fixed is not None:
        values = np.zeros(0) if not shapes else np.asarray(fixed, dtype=float)
        return values, solved(values), [values], None
    model = assembly.model
    own = bool(own_shapes(model))
    if isinstance(starts, np.ndarray) or own:
        began = np.asarray(starts, dtype=float) if isinstance(starts, np.ndarray) else np.array([])
        if searched := not began.size:
            terms = {model.shapes[k].term for k in turning(model)}
            phases_only = all(entry.term in terms for entry in model.shapes)  # what they need is looked for with them
            began = model.typical_shape if phases_only else search_shape(loss, shapes, None, method, at_once).best
        if began.ndim == 1 and turning(model):
            began = with_phases(assembly, began, solved(began).linear, searched)
        rows = np.broadcast_to(began, (len(assembly.prepared) if own else 1, len(shapes)))
        found = descend(ShapeProblem(assembly, loss, solved, own), rows, delta)
        best = found if own else found[0]
        return best, solved(best), best, None
    search = search_shape(loss, shapes, starts, method, at_once)
    # Far apart again, so that what they agree on is agreed on by starts of their own.
    leaders = search.valleys if method.apart <= 0.0 else [search.best, *search.began]
    return search.best, solved(search.best), leaders, search.agreeing


def _held_loss(
    assembly: Assembly, shape: Float, fed_back: Float, solve: Callable[[LinearData], Float], delta: Float
) -> float:
    """Return the loss (J,) at `shape` with the torque that is fed back computed from the parameters `fed_back` (P,)."""
    try:
        data = assembly.data(shape, fed_back)
        return huber(data.residual(solve(data)), delta)
    except ExpressionError:
        return float("inf")
