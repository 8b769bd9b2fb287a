"""NFO against other people's optimisers at the same work, as ratios in one run (`python benchmarks/identification.py`).

40 × 400 evaluations of the Huber loss of 3 500 samples and two joints. NFO runs as `exoid identify` runs it, on the
compiled fitness. mealpy (if it is there), pymoo, SciPy and cma get the best they could have without it: NumPy in place
over a whole population wherever the library hands over a population, in place for one candidate where it does not. A
last column gives them the compiled fitness too, so that one sees what is fitness and what is the library. Times are CPU
time of one thread, which other work on the machine hardly changes. Nothing is asserted.
"""

from __future__ import annotations

import os
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from exoid.optimisation.contest.problem import Contest, paper_contest  # noqa: E402
from exoid.optimisation.linear.problem import huber_problem  # noqa: E402
from exoid.optimisation.optimiser import minimise  # noqa: E402
from exoid.optimisation.optimisers.nfo import NFO  # noqa: E402
from exoid.symbolic.codegen.fitness import fitness  # noqa: E402

INDIVIDUALS, GENERATIONS, REPEATS = 40, 400, 5
BUDGET = INDIVIDUALS * GENERATIONS
Fitness = Callable[[np.ndarray], np.ndarray]


@dataclass(eq=False)
class InPlace:
    """Huber loss (I,) of a population (I, 8) in NumPy: non-zero columns only, block by block, no copies."""

    contest: Contest
    block: int = 1750
    count: int = 0
    _parts: list = field(default_factory=list)

    def __post_init__(self) -> None:
        data = self.contest.data
        for joint, delta in enumerate(self.contest.delta):
            used = np.flatnonzero(np.any(data.columns[joint] != 0.0, axis=0))
            for start in range(0, data.tau.shape[1], self.block):
                span = slice(start, start + self.block)
                columns = np.ascontiguousarray(data.columns[joint, span][:, used].T)
                room = np.empty((2, INDIVIDUALS, columns.shape[1]))
                self._parts.append((used, columns, data.tau[joint, span], float(delta), room))

    def __call__(self, population: np.ndarray) -> np.ndarray:
        population = np.atleast_2d(population)
        size = len(population)
        self.count += size
        out = np.zeros(size)
        for used, columns, tau, delta, (miss, inner) in self._parts:
            miss, inner = miss[:size], inner[:size]
            np.matmul(population[:, used], columns, out=miss)
            np.subtract(tau, miss, out=miss)
            np.abs(miss, out=miss)
            np.minimum(miss, delta, out=inner)
            miss *= 2.0
            miss -= inner
            out += np.einsum("in,in->i", inner, miss)
        return out


def run_pymoo(kind: str) -> Callable[[Contest, Fitness, np.ndarray, np.ndarray], float]:
    """Return pymoo's PSO, GA or DE in its own loop, display and history off."""

    def run(contest: Contest, fitness: Fitness, low: np.ndarray, high: np.ndarray) -> float:
        from pymoo.algorithms.soo.nonconvex.de import DE
        from pymoo.algorithms.soo.nonconvex.ga import GA
        from pymoo.algorithms.soo.nonconvex.pso import PSO
        from pymoo.core.problem import Problem
        from pymoo.optimize import minimize

        class Leg(Problem):
            def __init__(self) -> None:
                super().__init__(n_var=low.size, n_obj=1, xl=low, xu=high)

            def _evaluate(self, x, out, *args, **kwargs) -> None:
                out["F"] = fitness(x)[:, None]

        algorithm = {"PSO": PSO, "GA": GA, "DE": DE}[kind](pop_size=INDIVIDUALS)
        found = minimize(Leg(), algorithm, ("n_gen", GENERATIONS), seed=0, copy_algorithm=False)
        return float(found.F[0])

    return run


def run_scipy(contest: Contest, fitness: Fitness, low: np.ndarray, high: np.ndarray) -> float:
    """SciPy's differential evolution, whole populations at once."""
    from scipy.optimize import differential_evolution

    found = differential_evolution(
        lambda x: fitness(np.ascontiguousarray(x.T)) if x.ndim == 2 else float(fitness(x)[0]),
        list(zip(low, high, strict=True)), popsize=INDIVIDUALS // low.size, maxiter=GENERATIONS - 1, tol=0.0, atol=0.0,
        polish=False, vectorized=True, updating="deferred", rng=0, init="random",
    )  # fmt: skip
    return float(found.fun)


def run_cma(contest: Contest, fitness: Fitness, low: np.ndarray, high: np.ndarray) -> float:
    """CMA-ES by its author, asked for whole populations."""
    import cma

    options = {"seed": 1, "verbose": -9, "popsize": INDIVIDUALS, "bounds": [0.0, 1.0]}
    strategy = cma.CMAEvolutionStrategy(np.full(low.size, 0.5), 0.3, options)
    best = np.inf
    for _ in range(GENERATIONS):
        x = np.array(strategy.ask())
        f = fitness(low + x * (high - low))
        strategy.tell(list(x), f)
        best = min(best, float(f.min()))
    return best


def run_mealpy(contest: Contest, fitness: Fitness, low: np.ndarray, high: np.ndarray) -> float:
    """mealpy's PSO; it evaluates one candidate at a time."""
    from mealpy import PSO, FloatVar

    problem = {
        "obj_func": lambda x: float(fitness(x)[0]), "bounds": FloatVar(lb=low, ub=high), "minmax": "min",
        "log_to": None, "save_population": False,
    }  # fmt: skip
    found = PSO.OriginalPSO(epoch=GENERATIONS - 1, pop_size=INDIVIDUALS).solve(problem, seed=1)
    return float(found.target.fitness)


def run_ours(alpha: float, whitened: bool) -> Callable[[Contest, Fitness, np.ndarray, np.ndarray], float]:
    """Return NFO as `identify` runs it."""

    def run(contest: Contest, fitness: Fitness, low: np.ndarray, high: np.ndarray) -> float:
        problem = huber_problem(contest.data, fitness, contest.delta, contest.sse_linear)
        return minimise(problem.whitened() if whitened else problem, NFO(alpha=alpha), seed=0).fitness

    return run


def measure(contest: Contest, run: Callable, make: Callable[[], InPlace | Fitness]) -> tuple[float, float, int]:
    """Return the median time in s, the relative gap it ended at, and the evaluations it made."""
    problem, times, loss, count = contest.problem(), [], np.inf, 0
    for _ in range(REPEATS):
        inner = make()
        counted = [0]

        def fitness(x: np.ndarray, inner=inner, counted=counted) -> np.ndarray:
            counted[0] += 1 if x.ndim == 1 else len(x)
            return inner(x)

        began = time.process_time()
        loss = run(contest, fitness, problem.low, problem.high)
        times.append(time.process_time() - began)
        count = counted[0]
    return statistics.median(times), float(contest.gap(loss)), count


def main() -> None:
    contest = paper_contest()
    compiled = fitness(contest.data.columns, contest.data.tau)
    plain = InPlace(contest)
    x = contest.problem().low + np.random.default_rng(0).random((INDIVIDUALS, 8))
    assert np.allclose(plain(x), compiled.huber(x, contest.delta), rtol=1e-10)

    def numpy_fitness() -> InPlace:
        return InPlace(contest)

    def c_fitness() -> Fitness:
        return lambda x: compiled.huber(x, contest.delta)

    ours = {"NFO as printed": run_ours(0.8, False), "NFO whitened": run_ours(1.0, True)}
    others = {f"pymoo {kind}": run_pymoo(kind) for kind in ("PSO", "GA", "DE")}
    others |= {"SciPy DE": run_scipy, "cma": run_cma}
    try:
        import mealpy  # noqa: F401
    except ImportError:
        sys.stdout.write("mealpy is not installed: left out\n")
    else:
        others["mealpy PSO"] = run_mealpy
    rows = [(name, *measure(contest, run, c_fitness), None) for name, run in ours.items()]
    for name, run in others.items():
        rows.append((name, *measure(contest, run, numpy_fitness), measure(contest, run, c_fitness)[0]))
    base = rows[0][1]
    lines = [
        f"{BUDGET} evaluations on {contest.data.tau.shape[1]} samples x 2 joints, medians of {REPEATS}; "
        f"times relative to NFO as printed ({base:.3f} s)",
        "",
        "| optimiser | evaluations | time | with our compiled fitness | relative gap |",
        "|---|---|---|---|---|",
    ]
    for name, seconds, gap, count, fast in rows:
        second = "" if fast is None else f"{fast / base:.1f}"
        lines.append(f"| {name} | {count} | {seconds / base:.1f} | {second} | {gap:.0e} |")
    fastest = min(seconds for name, seconds, *_ in rows[2:])
    lines += ["", f"fastest of the others: {fastest / base:.1f} times NFO's time"]
    sys.stdout.write("\n".join(lines) + "\n")


if __name__ == "__main__":
    main()
