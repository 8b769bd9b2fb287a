"""The search for the most informative motion: several short runs of an optimiser, each refined; or NFO in stages.

Every candidate is stretched to the first limit it meets, so that the search stays among motions that a leg can make
("feasible by construction"). Inf outside the limits, as the paper has it, leaves a search nothing to
follow and is kept to compare.
Individuals are the stretched motions themselves, shifted in time to resemble each other where the start does not
matter, so that near neighbours are near motions.

There are many local optima, each where kinks meet: of cond(Ȳ), where eigenvalues change places, and of the stretching,
where another instant or another limit becomes the first. An optimiser of the folder `optimisers/` is therefore run
several times, for as long as it takes to come near one of them, and what it finds is refined to the end
(`refine.py`). NFO, which leans on its nearest neighbours and stops at kinks, has stages instead: most of it goes
to smooth proxies, which become sharper from stage to stage. Being smooth they have a curvature: in coordinates in which
it is the same in all directions NFO descends a curved valley as it does a round one (what whitening does for the fit
of a leg).
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from exoid.ground.progress import Progress, silent
from exoid.ground.ties import CONVERGED, ascending, index_of_least, least_of, tied
from exoid.measurement.trajectories.trajectory import Fourier
from exoid.optimisation.excitation.criteria import CRITERIA, Aim, softened
from exoid.optimisation.excitation.reference import solve_motions
from exoid.optimisation.excitation.refine import Refinement
from exoid.optimisation.excitation.result import DesignedMotion
from exoid.optimisation.excitation.settings import DesignError, DesignSettings
from exoid.optimisation.excitation.space import MotionSpace
from exoid.optimisation.linear.problem import Problem
from exoid.optimisation.optimiser import minimise
from exoid.optimisation.optimisers import optimisers
from exoid.optimisation.optimisers.cma_es import CMAES
from exoid.optimisation.optimisers.nfo import NFO
from exoid.symbolic.codegen.information import Information
from exoid.symbolic.memory import memory_operations
from exoid.symbolic.motion import Float


class NoMotionError(DesignError):
    """A search that met no motion inside the limits."""


@dataclass(frozen=True)
class PenaltyStage:
    """A `share` of the budget with limits of order 2^`doublings` and eigenvalues of order `power`; 0: exactly.

    `whitened`: in the coordinates of the curvature at the best motion so far.
    """

    share: float
    doublings: int
    power: float
    whitened: bool = False


STAGES = (
    PenaltyStage(0.375, 4, 2.0),
    PenaltyStage(0.25, 4, 4.0, whitened=True),
    PenaltyStage(0.25, 5, 8.0, whitened=True),
    PenaltyStage(0.125, 0, 0.0),
)
"""From smooth to exact. Chosen on 96 seeds that are not those of docs/design.md."""
RECIPE = NFO(alpha=0.9, crossover=0.95)
"""NFO with almost every component taken: coefficients act together, a motion is no sum of independent choices."""
RECIPES = {"cma_es": CMAES(spread=0.075)}
"""Optimisers that are told something of this search: the box is four times as wide as where it begins."""
WHITENED = NFO(alpha=1.0)
"""NFO in whitened coordinates, as for the fit of a leg."""
NEAR = 0.3
"""Spread of the first population of a whitened stage, where the proxy has grown by half its square."""
FLAT = 1e-4
"""Share of the largest curvature that counts as none: a motion's size and its start have none at all."""
STEP = 0.01
"""Step of the differences that give the curvature."""
DEAREST = 0.5
"""Share of a stage's evaluations that its curvature may cost; otherwise it goes on without."""
BOX_HALF_WIDTH = 2.0
"""Half-width of the box around stretched motions: a mixture of harmonics may exceed what each alone may do."""
SHORT = 120
"""Generations of NFO's search from whose result IPOPT starts."""
RUNS, SHORTEST = 8, 50
"""Runs among which the generations are divided, and the fewest generations of one. Of runs of 600 to 2000 evaluations
alike four in ten end at one of the best motions known once they are refined, so many short ones are worth more."""


@dataclass(frozen=True, eq=False)
class MotionSearch:
    """A search of `space` as `asked`: the criterion, the evaluations, the seed.

    `asked.printed`: with Inf outside the limits, in a box of ± `asked.box` times each harmonic's largest amplitude.
    """

    info: Information
    space: MotionSpace
    aim: Aim
    asked: DesignSettings
    say: Progress = silent

    def value(self, y: Float) -> Float:
        """Return the criterion (I,) of points `y` (I, n), stretched to the limits or Inf outside them."""
        swings, offsets = self.space.split(y)
        sums = self.info.sums(swings, offsets, rescale=not self.asked.printed)
        value = CRITERIA[self.asked.criterion](sums.gram, self.aim)
        return np.where((sums.factor >= 1.0).all(axis=1), value, np.inf) if self.asked.printed else value

    def smooth(self, y: Float, stage: PenaltyStage) -> Float:
        """Return the proxy (I,) of the criterion that `stage` searches."""
        swings, offsets = self.space.split(y)
        gram = self.info.sums(swings, offsets, rescale=True, doublings=stage.doublings).gram
        soft = self.asked.criterion == "condition" and stage.power > 0.0
        return softened(gram, stage.power) if soft else CRITERIA[self.asked.criterion](gram, self.aim)

    def run(self) -> list[DesignedMotion]:
        """Result of the search, before and after refinement; NoMotionError where none is inside the limits."""
        asked, began = self.asked, time.perf_counter()
        if asked.printed:
            return [self._printed()]
        if asked.optimiser == "nfo":
            ends, spent = [self._staged(asked.generations, asked.seed)], asked.individuals * asked.generations
        else:
            ends, spent = self._runs()
        name = label_of(asked.optimiser)
        (y, value), seconds = least_of(ends, lambda end: end[1]), time.perf_counter() - began
        found = [self._candidate(name, y[None], value, spent, seconds)]
        if memory_operations(self.info.model):  # a motion takes too long for so many differences
            return found
        refinement = Refinement(self.info, self.space, self.aim, asked.criterion)
        better = []
        for k, (end, reached) in enumerate(ends, start=1):
            better.append(refinement.refined(self.stretched(end[None])[0], reached))
            self.say(0.5 + 0.4 * k / len(ends), "refining")
        y, value, _ = least_of(better, lambda end: end[1])
        spent += sum(count for *_, count in better)
        return [*found, self._candidate(f"{name}, refined", y[None], value, spent, time.perf_counter() - began)]

    def _printed(self) -> DesignedMotion:
        """Result of NFO as the paper has it."""
        asked, began = self.asked, time.perf_counter()
        run = minimise(
            self._problem(self.value, asked.box), NFO(), individuals=asked.individuals,
            generations=asked.generations, seed=asked.seed,
        )  # fmt: skip
        spent = asked.individuals * asked.generations
        if not np.isfinite(run.fitness):
            raise NoMotionError(
                f"none of {spent} candidate motions met the limits; an infinite penalty "
                "outside them leaves the search nothing to follow",
                where=f"NFO as printed, box {asked.box:g}",
                remedy="leave --printed away (every motion is then feasible by construction), or try a smaller --box",
            )
        return self._candidate("NFO as printed", run.x[None], run.fitness, spent, time.perf_counter() - began)

    def _runs(self) -> tuple[list[tuple[Float, float]], int]:
        """Return the best point of each of several runs with its value, and the evaluations of all."""
        asked = self.asked
        count = min(RUNS, max(1, asked.generations // SHORTEST))
        each, more = divmod(max(asked.generations, 1), count)
        problem = self._problem(self.value, BOX_HALF_WIDTH)
        ends, spent = [], 0
        for k in range(count):
            seed = self._seed(k)
            first = np.random.default_rng([seed, 1]).uniform(-1.0, 1.0, (asked.individuals, self.space.size))
            run = minimise(
                problem, RECIPES.get(asked.optimiser, optimisers()[asked.optimiser]()), individuals=asked.individuals,
                generations=each + (k < more), seed=seed, start=self.stretched(first),
            )  # fmt: skip
            ends.append((run.x, float(run.fitness)))
            spent += run.evaluations
            self.say(0.05 + 0.45 * len(ends) / count, label_of(asked.optimiser))
        return ends, spent

    def _staged(self, generations: int, seed: int) -> tuple[Float, float]:
        """Return the best point and its value after all stages."""
        rng = np.random.default_rng(seed)
        x = self.stretched(rng.uniform(-1.0, 1.0, (self.asked.individuals, self.space.size)))
        value = self.value(x)
        first = x[index_of_least(value)]

        def form(y: Float) -> Float:
            return self.stretched(self.space.aligned(y, first) if self.shiftable else y)

        x = form(x)
        spent, until = 1, 0.0  # generations: the first population has been evaluated
        for stage in STAGES:
            self.say(0.05 + 0.5 * until, "NFO")
            until += stage.share
            left = round(until * generations) - spent
            if left <= 0:
                continue
            spent += left
            x, value = self._stage(stage, x, left, form, rng, seed)
            if stage.doublings or stage.power:
                value = np.full(len(x), np.nan)
        if not np.isfinite(value).all():
            value = self.value(x)
        best = index_of_least(value)
        return x[best], float(value[best])

    def _stage(
        self, stage: PenaltyStage, x: Float, generations: int, form: Callable[[Float], Float], rng: np.random.Generator,
        seed: int,
    ) -> tuple[Float, Float]:  # fmt: skip
        """Return the population (I, n) after a stage, and what it searched for of each (I,)."""

        def proxy(y: Float) -> Float:
            return self.smooth(y, stage)

        price = -(-_differences(self.space.size) // self.asked.individuals)
        if stage.whitened and price + 1 <= DEAREST * generations:
            best = x[index_of_least(proxy(x))]
            axes = _whitening(proxy, best)
            edge = self._edge(BOX_HALF_WIDTH)

            def placed(z: Float) -> Float:
                return np.asarray(np.clip(best + z @ axes.T, -edge, edge))

            near = NEAR * rng.normal(size=x.shape)
            near[0] = 0.0
            far = np.full(self.space.size, 100.0 * NEAR)
            inner = Problem(lambda z: proxy(placed(z)), -far, far, self.space.names, ("1",) * self.space.size)
            left = generations - price - 1
            run = minimise(inner, WHITENED, individuals=self.asked.individuals, generations=left, seed=seed, start=near)
            found, f = _with(run.state, run.x, run.fitness)
            return form(placed(found)), f
        run = minimise(
            self._problem(proxy, BOX_HALF_WIDTH), RECIPE, individuals=self.asked.individuals, generations=generations,
            seed=seed, start=x, form=form,
        )  # fmt: skip
        return _with(run.state, run.x, run.fitness)

    def stretched(self, y: Float) -> Float:
        """Return points (I, n) as the motions they stand for: stretched to the first limit they meet."""
        edge = self._edge(np.inf)
        y = np.clip(y, -edge, edge)  # a free offset stays between the limits
        swings, offsets = self.space.split(y)
        factor = self.info.sums(swings, offsets, rescale=False).factor
        width = self.space.basis.shape[2]
        out = y.copy()
        out[:, : len(self.space.limits) * width] *= np.repeat(np.minimum(factor, 1e6), width, axis=1)
        return out

    def reference(self, starts: int) -> list[DesignedMotion]:
        """Ends of IPOPT from the results of short searches of its own, best first."""
        began = time.perf_counter()
        points = [self._staged(SHORT, self._seed(k))[0] for k in range(starts)]
        ended = solve_motions(self.info, self.space, self.aim, self.asked.criterion, np.array(points))
        sums = self.info.sums(ended.swings, ended.offsets, rescale=True)
        values = CRITERIA[self.asked.criterion](sums.gram, self.aim)
        each = (time.perf_counter() - began) / starts
        out = []
        for k, value in enumerate(values):
            swing = ended.swings[k] * sums.factor[k][:, None]
            motion = self.space.trajectory(swing, ended.offsets[k])
            out.append(
                DesignedMotion(f"IPOPT {k + 1}", motion, float(value), ended.iterations[k], each, ended.statuses[k])
            )
        return ascending(out, lambda one: one.value if np.isfinite(one.value) else np.inf, within=CONVERGED)

    @property
    def shiftable(self) -> bool:
        """True if a motion that starts later, or runs backwards, is the same motion to the criterion."""
        return not self.info.model.terms and self.space.whole

    def _edge(self, width: float) -> Float:
        edge = np.full(self.space.size, width)
        if self.space.centre is None:
            edge[-len(self.space.limits) :] = 1.0
        return edge

    def _problem(self, fitness: Callable[[Float], Float], width: float) -> Problem:
        edge = self._edge(width)
        return Problem(fitness, -edge, edge, self.space.names, ("1",) * self.space.size)

    def _candidate(self, name: str, y: Float, value: float, evaluations: int, seconds: float) -> DesignedMotion:
        swings, offsets = self.space.split(y)
        found = self.info.sums(swings, offsets, rescale=False).factor[0]
        factor = np.ones_like(found) if self.asked.printed else found
        motion: Fourier = self.space.trajectory(swings[0] * factor[:, None], offsets[0])
        return DesignedMotion(name, motion, value, evaluations, seconds, "")

    def _seed(self, k: int) -> int:
        return int(np.random.SeedSequence([self.asked.seed, k]).generate_state(1)[0])


def label_of(optimiser: str) -> str:
    """Return an optimiser's name as it is written: CMA-ES for "cma_es"."""
    return optimiser.upper().replace("_", "-")


def _with(field: Any, x: Float, f: float) -> tuple[Float, Float]:
    """Return a population and its fitness with the best of a run in it: the last generation was not selected from."""
    points, values = field.x.copy(), field.f.copy()
    worst = int(np.argmax(values))
    if f < values.min():
        points[worst], values[worst] = x, f
    return points, values


def _differences(size: int) -> int:
    """Number of evaluations that a curvature costs in `size` dimensions."""
    return 1 + 2 * size + size * (size - 1) // 2


def _whitening(function: Callable[[Float], Float], at: Float) -> Float:
    """Return axes (n, n) along which `function` has curvature ±1 at the point `at` (n,), by differences.

    A direction without curvature gets that of the flattest that has any.
    """
    size = len(at)
    steps = STEP * np.eye(size)
    first, second = np.tril_indices(size, -1)
    points = np.concatenate([at[None], at + steps, at - steps, at + steps[first] + steps[second]])
    values = function(points)
    middle, up, down, both = np.split(values, [1, 1 + size, 1 + 2 * size])
    curvature = np.diag((up + down - 2.0 * middle) / STEP**2)
    curvature[first, second] = curvature[second, first] = (both - up[first] - up[second] + middle) / STEP**2
    size_of, axes = np.linalg.eigh(curvature)
    # Which way an axis points is left to the library: here the largest part of each is positive.
    largest_part = np.argmax(tied(-np.abs(axes), axis=0), axis=0)
    axes *= np.sign(axes[largest_part, np.arange(size)])
    largest = np.abs(size_of).max()
    return np.asarray(axes / np.sqrt(np.maximum(np.abs(size_of), FLAT * largest if largest > 0.0 else 1.0)))
