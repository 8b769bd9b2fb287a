"""Parameters the torque is *not* linear in: search them outside, solve the linear ones exactly inside.

This is variable projection (Golub, Pereyra 1973). A grid as fine as each effect declares (`Shape.points`,
`spacing`, `choices`) finds the valleys, or a population does (NFO, or any optimiser of the same interface); a local
search refines the best few. The loss over shape parameters is not convex, so the result is "best known", never "the
optimum"; how many starts end at it is a hint of how well it is known.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.minimum import minimum
from exoid.ground.ties import TIED, index_of_least, least_of, order_of
from exoid.optimisation.linear.problem import Problem
from exoid.optimisation.optimiser import Optimiser, minimise
from exoid.symbolic.effect import Shape
from exoid.symbolic.motion import Float

MAX_NODES = 400
"""Nodes of the grid at most; with many shape parameters each gets fewer points."""
STARTS = 3
"""Valleys refined by the local search."""
POPULATION, GENERATIONS = 20, 20
"""Of a population that searches instead of the grid: as many evaluations as the grid has nodes."""
PRECISION = 1e-7
"""To what share of its range a shape value is refined."""
ROUGH = 1e-3
"""The same for a valley that is not the lowest, until it turns out to be."""
EDGE = 1e-4
"""Where, as a share of the range beside a bound, the loss is looked at to see whether it rises from there."""
SAME = 1e-6
"""Relative difference of losses up to which two starts have ended in the same valley."""


@dataclass(frozen=True, eq=False)
class ShapeSearch:
    """Best shape values `best` (S,), their `value`, every node tried (T, S) with its value (T,).

    The local searches `began` at (R, S), ended at `ends` (R, S) and `reached` values (R,).
    """

    best: Float
    value: float
    nodes: Float
    values: Float
    began: Float
    ends: Float
    reached: Float

    @property
    def agreeing(self) -> tuple[int, int]:
        """Number of starts that ended at the best value, and number of all starts."""
        return int(np.count_nonzero(self._same)), len(self.reached)

    @property
    def valleys(self) -> list[Float]:
        """The best shape values, and where the searches ended that did not agree."""
        return [self.best, *self.ends[~self._same]]

    @property
    def _same(self) -> NDArray[np.bool_]:
        return np.asarray(self.reached <= self.value + SAME * max(abs(self.value), np.finfo(float).tiny))


def to_unit(shape: Shape, value: float) -> float:
    """Place of `value` between the bounds of `shape`, 0 to 1, in its declared spacing."""
    if shape.spacing == "log":
        return float(np.log(value / shape.min) / np.log(shape.max / shape.min))
    return (value - shape.min) / (shape.max - shape.min)


def from_unit(shape: Shape, unit: float) -> float:
    """Return the value of `shape` at `unit` (0 to 1, clipped)."""
    u = min(max(unit, 0.0), 1.0)
    if shape.spacing == "log":
        return float(min(max(shape.min * (shape.max / shape.min) ** u, shape.min), shape.max))
    return float(shape.min + u * (shape.max - shape.min))


def slope_by_shape(values: Callable[[Float], Float], at: Float, index: int, shape: Shape, share: float) -> Float:
    """Return the derivative of `values` by shape value `index` of `at` (S,) or (R, S), in all recordings at once: by
    central differences of a `share` of its range, inside its bounds.
    """
    step = share * (shape.max - shape.min)
    up, down = at.copy(), at.copy()
    up[..., index] = np.minimum(at[..., index] + step, shape.max)
    down[..., index] = np.maximum(at[..., index] - step, shape.min)
    return np.asarray((values(up) - values(down)) / np.mean(up[..., index] - down[..., index]))


def grid(shapes: Sequence[Shape]) -> list[tuple[float, ...]]:
    """Return the nodes of the search, each with one value per shape."""
    return list(itertools.product(*_axes(shapes)))


def _axes(shapes: Sequence[Shape]) -> list[Sequence[float]]:
    """Return the values of each shape that are tried, in every combination."""
    points = [len(s.choices) or (1 if s.turns else max(2, s.points)) for s in shapes]
    while np.prod(points) > MAX_NODES:
        finest = max(range(len(points)), key=lambda i: 0 if shapes[i].choices else points[i])
        if shapes[finest].choices or points[finest] <= 2:
            break
        points[finest] -= 1
    return [
        s.choices or ((0.0,) if s.turns else tuple(from_unit(s, u) for u in np.linspace(0.0, 1.0, n)))
        for s, n in zip(shapes, points, strict=True)
    ]


def _valleys(values: Float, shapes: Sequence[Shape], lengths: Sequence[int]) -> list[int]:
    """Return the nodes of a grid with axes of `lengths` (S,) that no neighbour lies below, the best first.

    Nodes next to each other would be refined to the same place. Choices are no neighbours of each other.
    """
    table = values.reshape(lengths)
    lowest = np.isfinite(table)
    for axis, shape in enumerate(shapes):
        if not shape.choices:
            padded = np.pad(table, [(int(k == axis),) * 2 for k in range(table.ndim)], constant_values=np.inf)
            inner = [slice(None)] * table.ndim
            for side in (slice(None, -2), slice(2, None)):
                inner[axis] = side
                lowest &= table <= padded[tuple(inner)] + TIED * np.abs(table)
    return [k for k in order_of(values) if lowest.flat[k]]


@dataclass(frozen=True)
class ShapeMethod:
    """Method of the shape search: the grid, or `optimiser`; of `starts` valleys found, `refined` (all) are refined.

    `apart` is how far from each other these begin, as a share of the ranges, 0 for valleys of the grid; `seed` is that
    of the optimiser.
    """

    optimiser: Optimiser | None = None
    starts: int = STARTS
    refined: int | None = None
    apart: float = 0.0
    seed: int = 0


GRID = ShapeMethod()


def search_shape(
    evaluate: Callable[[Float], float],
    shapes: Sequence[Shape],
    starts: Sequence[Float] | None = None,
    method: ShapeMethod = GRID,
    at_once: Callable[[Float], Float] | None = None,
) -> ShapeSearch:
    """Minimise `evaluate` ((S,) -> loss) over `shapes`: everywhere (or only from `starts`), then locally.

    `at_once` ((V, S) -> (V,)) looks at all nodes of the grid, should that be cheaper; it need not be as exact.
    """
    if starts is None and method.optimiser is not None:
        nodes, values = _population(evaluate, shapes, method.optimiser, method.seed)
    else:
        nodes = np.array(grid(shapes) if starts is None else [tuple(s) for s in starts], dtype=float)
        values = at_once(nodes) if at_once and starts is None else np.array([evaluate(node) for node in nodes])
    values = np.where(np.isnan(values), np.inf, values)
    if starts is None and method.optimiser is None and method.apart <= 0.0:
        chosen = _valleys(values, shapes, [len(axis) for axis in _axes(shapes)])[: method.starts]
    else:
        chosen = _apart(nodes, values, shapes, method)
    if at_once and starts is None:
        values[chosen] = [evaluate(nodes[index]) for index in chosen]
    known = chosen or [index_of_least(values)]
    best, value = least_of(((nodes[k], float(values[k])) for k in known), lambda pair: pair[1])
    ends, reached = [], []
    for rank, index in enumerate(chosen[: method.refined or method.starts]):
        rough = rank > 0 and method.apart <= 0.0
        found, low = _refine(evaluate, shapes, nodes[index], float(values[index]), ROUGH if rough else PRECISION)
        if rough and low < value - TIED * abs(value):
            found, low = _refine(evaluate, shapes, nodes[index], float(values[index]))
        ends.append(found)
        reached.append(low)
        if low < value - TIED * abs(value):
            best, value = found, low
    places = np.array(ends).reshape(len(ends), len(shapes))
    return ShapeSearch(best, value, nodes, values, nodes[chosen], places, np.array(reached))


def _population(
    evaluate: Callable[[Float], float], shapes: Sequence[Shape], optimiser: Optimiser, seed: int
) -> tuple[Float, Float]:
    """Return every point (T, S) an optimiser tried, and its value (T,)."""
    points: list[Float] = []
    values: list[float] = []

    def fitness(units: Float) -> Float:
        for unit in units:
            points.append(np.array([_value(s, float(u)) for s, u in zip(shapes, unit, strict=True)]))
            values.append(evaluate(points[-1]))
        return np.array(values[-len(units) :])

    count = len(shapes)
    names = tuple(f"shape {k + 1}" for k in range(count))
    problem = Problem(fitness, np.zeros(count), np.ones(count), names, ("1",) * count)
    minimise(problem, optimiser, individuals=POPULATION, generations=GENERATIONS, seed=seed)
    return np.array(points), np.array(values)


def _value(shape: Shape, unit: float) -> float:
    """Return the value at `unit` (0 to 1), a choice where there are choices."""
    if shape.choices:
        return float(shape.choices[min(int(unit * len(shape.choices)), len(shape.choices) - 1)])
    return from_unit(shape, unit)


def _apart(nodes: Float, values: Float, shapes: Sequence[Shape], method: ShapeMethod) -> list[int]:
    """Return the best nodes that are far enough from each other to be starts of their own."""
    order = order_of(values)
    if method.apart <= 0.0:
        return order[: method.starts]
    places = np.array(
        [[float(v) if s.choices else to_unit(s, v) for s, v in zip(shapes, n, strict=True)] for n in nodes]
    )
    chosen: list[int] = []
    for index in order:
        if np.isfinite(values[index]) and all(
            np.max(np.abs(places[index] - places[other])) >= method.apart for other in chosen
        ):
            chosen.append(index)
        if len(chosen) == method.starts:
            break
    return chosen


def _refine(
    evaluate: Callable[[Float], float],
    shapes: Sequence[Shape],
    node: Float,
    value: float,
    precision: float = PRECISION,
) -> tuple[Float, float]:
    """Refine the continuous shapes around `node` of loss `value`; choices stay as they are."""
    free = [i for i, s in enumerate(shapes) if not s.choices]
    if not free:
        return node, value
    reach = [1.0 / max(1, shapes[i].points - 1) for i in free]
    middle = [to_unit(shapes[i], node[i]) for i in free]

    def at(units: float | Float) -> Float:
        out = node.copy()
        for i, u in zip(free, np.ravel(units), strict=True):
            out[i] = from_unit(shapes[i], float(u))
        return out

    if len(free) == 1:
        inside = abs(middle[0] - EDGE)
        if middle[0] in (0.0, 1.0) and evaluate(at(inside)) >= value:  # it rises from the bound on
            return node, value
        bounds = (max(0.0, middle[0] - reach[0]), min(1.0, middle[0] + reach[0]))
        unit, least = minimum(lambda u: evaluate(at(u)), *bounds, precision)
        return at(unit), least
    from scipy.optimize import minimize

    corners = [np.array(middle)]
    for i, step in enumerate(reach):
        corner = np.array(middle)
        corner[i] += 0.5 * step if corner[i] < 0.5 else -0.5 * step
        corners.append(corner)
    options: Any = {
        "initial_simplex": np.array(corners),
        "xatol": 1e-6,
        "fatol": 0.0,
        "maxfev": 120 * len(free),
    }
    box: Any = [(0.0, 1.0)] * len(free)
    start: Float = np.array(middle, dtype=float)
    refined: Any = minimize(lambda u: evaluate(at(u)), start, method="Nelder-Mead", bounds=box, options=options)
    return at(refined.x), float(refined.fun)
