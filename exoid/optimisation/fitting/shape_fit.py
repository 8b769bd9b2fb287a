"""The search over shape parameters, each trial solved exactly in the linear ones."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exoid.ground.errors import ExoidError
from exoid.optimisation.fitting.assemble import Assembly, Settled
from exoid.optimisation.fitting.local_shape import descend
from exoid.optimisation.fitting.phases import turning, with_phases
from exoid.optimisation.fitting.settings import MULTISTART
from exoid.optimisation.fitting.shape_problem import ShapeProblem
from exoid.optimisation.fitting.shapes import GRID, ShapeMethod, search_shape
from exoid.optimisation.linear.physical import Physics
from exoid.optimisation.optimisers import optimisers as optimiser_kinds
from exoid.symbolic.motion import Float

FULL_STARTS, FULL_APART = 6, 0.08
"""Starts of the local searches, and how far apart they begin, when more is asked for than the light mode."""


def shape_method(name: str, full: bool, seed: int) -> ShapeMethod:
    """Method by which shapes are searched; refuses a name that is neither "multistart" nor an optimiser."""
    known = {} if name == MULTISTART else optimiser_kinds()
    if name != MULTISTART and name not in known:
        what = f"there is no way to search shapes called {name!r}"
        raise ExoidError(what, where="shape_search", remedy=f"use {MULTISTART}, {', '.join(known)}")
    if name == MULTISTART and not full:
        return GRID
    optimiser = None if name == MULTISTART else known[name]()
    return ShapeMethod(optimiser, FULL_STARTS, None, FULL_APART, seed)


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
    problem = ShapeProblem(assembly, delta, possible, reference)
    shapes = [s.shape for s in assembly.model.shapes]
    if not shapes or fixed is not None:
        values = np.zeros(0) if not shapes else np.asarray(fixed, dtype=float)
        return values, problem.solved(values), [values], None
    model = assembly.model
    if isinstance(starts, np.ndarray) or problem.own:
        began = np.asarray(starts, dtype=float) if isinstance(starts, np.ndarray) else np.array([])
        if searched := not began.size:
            terms = {model.shapes[k].term for k in turning(model)}
            phases_only = all(entry.term in terms for entry in model.shapes)  # what they need is looked for with them
            began = model.typical_shape
            if not phases_only:
                began = search_shape(problem.loss, shapes, None, method, problem.at_once).best
        if began.ndim == 1 and turning(model):
            began = with_phases(assembly, began, problem.solved(began).linear, searched)
        rows = np.broadcast_to(began, (len(assembly.prepared) if problem.own else 1, len(shapes)))
        found = descend(problem, rows, delta)
        best = found if problem.own else found[0]
        return best, problem.solved(best), best, None
    search = search_shape(problem.loss, shapes, starts, method, problem.at_once)
    # Far apart again, so that what they agree on is agreed on by starts of their own.
    leaders = search.valleys if method.apart <= 0.0 else [search.best, *search.began]
    return search.best, problem.solved(search.best), leaders, search.agreeing
