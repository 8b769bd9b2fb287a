"""The contract every optimiser keeps, and the one loop that runs them all.

An optimiser is a frozen recipe with three verbs; everything that changes lives in the state it returns:

    start(x, f, box, rng) -> state   x (I, n) the first population with its fitness f (I,), inside `box`
    ask(state, rng)  -> candidates   (I, n), anywhere
    tell(state, x, f) -> state       the candidates as they were evaluated, with their fitness

The loop owns what must be the same for all: seed, bounds, evaluation of the whole population at once, the
count of evaluations, the best point ever seen. A fitness of NaN counts as +∞, so no comparison can be won
by it. What an optimiser does not care about is declared in `invariances` and tested: "shift" of the
coordinates with their box, "scale" (all by one factor), "axes" (each by its own), and "monotone" (any rising function
of the fitness gives the same run).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple, Protocol

import numpy as np

from exoid.ground.frames import pandas
from exoid.ground.html import table
from exoid.ground.plain import AsJson
from exoid.optimisation.budget import GENERATIONS, INDIVIDUALS
from exoid.optimisation.fitting.plots import run_figure
from exoid.optimisation.linear.problem import Problem
from exoid.symbolic.motion import Float

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.figure import Figure


class Box(NamedTuple):
    """Box in which candidates lie: `low` and `high` (n,)."""

    low: Float
    high: Float


class Optimiser(Protocol):
    """Contract of a file in `optimisers/`. `boundary` names the rule for candidates outside the box."""

    @property
    def invariances(self) -> frozenset[str]:
        """Transformations that do not change a run: of "shift", "scale", "axes", "monotone"."""

    @property
    def boundary(self) -> str:
        """One of `BOUNDARIES`."""

    def start(self, x: Float, f: Float, box: Box, rng: np.random.Generator) -> Any:
        """Return the state after the first population."""

    def ask(self, state: Any, rng: np.random.Generator) -> Float:
        """Return candidates (I, n)."""

    def tell(self, state: Any, x: Float, f: Float) -> Any:
        """Return the state after the candidates were evaluated."""


def _reflect(x: Float, low: Float, high: Float) -> Float:
    width = np.where(high > low, high - low, 1.0)
    folded = np.abs((x - low + width) % (2.0 * width) - width)
    return np.clip(np.where((x < low) | (x > high), low + folded, x), low, high)


def _wrap(x: Float, low: Float, high: Float) -> Float:
    width = np.where(high > low, high - low, 1.0)
    return np.clip(np.where((x < low) | (x > high), low + (x - low) % width, x), low, high)


BOUNDARIES: Mapping[str, Callable[[Float, Float, Float], Float]] = MappingProxyType(
    {"clip": np.clip, "reflect": _reflect, "wrap": _wrap}
)
"""What happens to a candidate outside the box: put on the border, mirrored, or let in on the other side."""


@dataclass(frozen=True, eq=False)
class OptimiserRun(AsJson):
    """One run: best `x` (physical parameters, (P,)), its `fitness`, and how it got there.

    `history` (G,) is the best fitness after `counts` (G,) evaluations; `found_at` (K,) are the evaluations that found
    something better, and `found` (K,) what they found. `gap` is the relative distance of the fitness to a certified
    optimum where one is known; `state` is the optimiser's last.
    """

    name: str
    x: Float
    fitness: float
    evaluations: int
    seconds: float
    seed: int
    history: Float = field(repr=False)
    counts: Float = field(repr=False)
    found_at: Float = field(repr=False)
    found: Float = field(repr=False)
    gap: float | None = None
    state: Any = field(default=None, repr=False)

    def to_frame(self) -> pd.DataFrame:
        """Return the best fitness after so many evaluations, one row per generation."""
        return pandas().DataFrame({"evaluations": self.counts.astype(int), "loss": self.history})

    def plot(self, optimum: float | None = None) -> Figure:
        """Draw the best fitness against evaluations; above `optimum` where one is known."""
        return run_figure(self.name, self.counts, self.history, optimum)

    def _repr_html_(self) -> str:
        head = ("optimiser", "loss", "relative gap", "evaluations", "seconds", "seed")
        return table(head, [(self.name, self.fitness, self.gap, self.evaluations, self.seconds, self.seed)])

    def _json(self) -> dict[str, Any]:
        return {
            "name": self.name, "parameters": self.x, "loss": self.fitness, "evaluations": self.evaluations,
            "seconds": self.seconds, "seed": self.seed, "gap": self.gap,
        }  # fmt: skip


def minimise(
    problem: Problem,
    optimiser: Optimiser,
    *,
    name: str = "",
    individuals: int = INDIVIDUALS,
    generations: int = GENERATIONS,
    seed: int = 0,
    start: Float | None = None,
    form: Callable[[Float], Float] = lambda x: x,
    progress: Callable[[int, float], None] | None = None,
) -> OptimiserRun:
    """Run `optimiser` on `problem` for exactly `individuals` × `generations` evaluations and return the Run.

    The first population is drawn evenly from the box unless `start` (I, n) gives it. `form` turns candidates into such
    as stand for the same. `progress(evaluations, best)` is called once per generation.
    """
    began, rng = time.perf_counter(), np.random.default_rng(seed)
    inside = BOUNDARIES[optimiser.boundary]
    budget = individuals * generations
    if start is None:
        start = problem.low + rng.random((individuals, problem.low.size)) * (problem.high - problem.low)
    x = inside(np.asarray(start, dtype=float)[:budget], problem.low, problem.high)
    f = _evaluate(problem, x)
    state = optimiser.start(x, f, Box(problem.low, problem.high), rng)
    best_x, best_f, spent = x[int(np.argmin(f))].copy(), float(np.min(f)), len(x)
    history, counts = [best_f], [spent]
    # The very first evaluation is the best so far whatever it found.
    places, values = [np.ones(1), 1.0 + _better(f, f[0])], [f[:1], f[_better(f, f[0])]]
    while spent < budget:
        x = inside(form(optimiser.ask(state, rng))[: budget - spent], problem.low, problem.high)
        f = _evaluate(problem, x)
        spent += len(x)
        winner = int(np.argmin(f))
        if f[winner] < best_f:
            better = _better(f, best_f)
            places.append(spent - len(x) + 1.0 + better)
            values.append(f[better])
            best_x, best_f = x[winner].copy(), float(f[winner])
        history.append(best_f)
        counts.append(spent)
        if progress is not None:
            progress(spent, best_f)
        if len(x) and spent < budget:
            state = optimiser.tell(state, x, f)
    return OptimiserRun(
        name or type(optimiser).__name__,
        problem.physical(best_x),
        best_f,
        spent,
        time.perf_counter() - began,
        seed,
        np.array(history),
        np.array(counts, dtype=float),
        np.concatenate(places),
        np.concatenate(values),
        state=state,
    )


def _better(f: Float, than: float) -> np.ndarray:
    """Return the indices (K,) in `f` (I,) that are below `than` and below everything before them."""
    lowest = np.minimum.accumulate(np.concatenate([[than], f]))
    return np.flatnonzero(lowest[1:] < lowest[:-1])


def _evaluate(problem: Problem, x: Float) -> Float:
    f = np.asarray(problem.fitness(x), dtype=float)
    return np.where(np.isnan(f), np.inf, f)
