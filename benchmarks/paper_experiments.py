"""The paper's experiments on the virtual bench with the paper's leg; `paper.py` writes docs/paper.md from them.

Everything is measured here and nothing is taken from the paper but its inputs: leg, trajectory, limits, sizes of the
populations and the published δ. Shapes: N samples, J = 2 joints, P = 8 parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from measurement.bench.leg import paper_leg
from measurement.bench.simulation import Bench, BenchRun
from measurement.bench.simulation import run_bench as run_bench
from measurement.signals.conditioning import derivatives, low_pass
from measurement.trajectories.trajectory import CENTRE, Fourier, largest_scale, paper_trajectory, within
from optimisation.contest.rivals import rivals
from optimisation.contest.standings import Rivals
from optimisation.excitation.design import design
from optimisation.excitation.result import Excitation
from optimisation.fitting.identify import identify
from optimisation.linear.certificate import Certificate, certify
from optimisation.linear.problem import LinearData, Problem, huber_problem
from optimisation.linear.reference import Reference, solve_reference
from optimisation.linear.solve import delta_rule, solve_huber, solve_sse
from optimisation.optimiser import minimise
from optimisation.optimisers import optimisers
from optimisation.optimisers.nfo import NFO
from symbolic.codegen.fitness import fitness
from symbolic.model import TABLE_1, Model
from symbolic.motion import Motion

PAPER_HUBER = np.array([25.14, 7.42, 1.43, -10.42, 31.35, 12.53, 43.40, 28.01])
PAPER_SSE = np.array([27.97, 12.15, 1.79, -8.41, 31.83, 15.25, 52.39, -5.89])
PAPER_DELTA = np.array([138.46, 92.89])
PAPER_RATIO = 0.63
DURATION, RATE, CUTOFF = 35.0, 100.0, 5.0
SEEDS = 10
LEG = Model.standard()


@dataclass(frozen=True, eq=False)
class Fits:
    """SSE and Huber on one set of recordings: parameters (P,), δ (J,), proof, and errors on unseen motion, N·m.

    `ratio` is Huber over SSE of the RMS over both joints, against the measured torque and against the true one.
    """

    data: LinearData
    sse: np.ndarray
    huber: np.ndarray
    delta: np.ndarray
    proof: Certificate
    verify: LinearData
    truth: LinearData

    def error(self, linear: np.ndarray, against: str) -> float:
        """Return the RMS error over both joints on the unseen motion, N·m."""
        data = self.verify if against == "measured" else self.truth
        return float(np.sqrt(np.mean(data.residual(linear) ** 2)))

    def ratio(self, against: str) -> float:
        """Return Huber's RMS error over that of SSE."""
        return self.error(self.huber, against) / self.error(self.sse, against)


def record(seed: int, excitation: Fourier | None) -> BenchRun:
    """Run the bench for 35 s at 10 ms with the paper's leg."""
    return run_bench(LEG, paper_leg(), excitation=excitation, seed=seed, bench=Bench(duration=DURATION, rate=RATE))


def linear_data(run: BenchRun, tau: np.ndarray) -> LinearData:
    """Return τ = YΦ with Y from smoothed encoders, and `tau` (N, J) as it is: no torque filter, nothing bridged."""
    q = low_pass(run.recording.q, CUTOFF, RATE)
    dq, ddq = derivatives(q, RATE)
    columns = np.asarray(LEG.columns(Motion(run.recording.t, q, dq, ddq)))
    names, units = zip(*((p.name, p.unit) for p in LEG.parameters), strict=True)
    return LinearData(columns, tau.T, np.zeros(len(q), dtype=int), names, units)


def usual(run: BenchRun, rng: np.random.Generator) -> np.ndarray:
    """The bench's own instruments: 0.5 N·m of noise, 6 % outliers, bursts of chatter."""
    return np.asarray(run.recording.tau)


def symmetric(run: BenchRun, rng: np.random.Generator) -> np.ndarray:
    """Errors of the size of the paper's δ, as often up as down: every fifth sample is knocked."""
    shape = run.torque.shape
    knocked = rng.random(shape) < 0.2
    return run.torque + PAPER_DELTA * (0.15 + 2.35 * knocked) * rng.standard_normal(shape)


def one_sided(run: BenchRun, rng: np.random.Generator) -> np.ndarray:
    """Errors of the size of the paper's δ that all point one way: knocks of about 0.2 s, one a second."""
    torque = run.torque + 0.15 * PAPER_DELTA * rng.standard_normal(run.torque.shape)
    for joint in range(2):
        for start in rng.integers(0, len(torque), int(DURATION)):
            torque[start : start + int(20 * rng.uniform(0.5, 1.5)), joint] += 1.4 * PAPER_DELTA[joint]
    return torque


ERRORS: Mapping[str, Callable[[BenchRun, np.random.Generator], np.ndarray]] = {
    "the bench's instruments": usual,
    "as large as the paper's δ, both ways": symmetric,
    "as large as the paper's δ, one way": one_sided,
}
"""Ways in which the torque sensors may be wrong; the paper does not say which were its own."""


def fit_all(seeds: int = SEEDS) -> dict[str, list[Fits]]:
    """Return {kind of error: a Fits per seed}; fitted on the published motion, judged on a random one."""
    train = [record(seed, paper_trajectory()) for seed in range(seeds)]
    unseen = [record(100 + seed, None) for seed in range(seeds)]
    return {
        name: [fit_one(a, b, wrong, seed) for seed, (a, b) in enumerate(zip(train, unseen, strict=True))]
        for name, wrong in ERRORS.items()
    }


def fit_one(train: BenchRun, unseen: BenchRun, wrong: Callable[..., np.ndarray], seed: int) -> Fits:
    """Fit SSE, take δ from it by the 14 % rule, fit Huber, and prove the optimum."""
    rng = np.random.default_rng(seed)
    data = linear_data(train, wrong(train, rng))
    verify, truth = linear_data(unseen, wrong(unseen, rng)), linear_data(unseen, unseen.torque)
    first = solve_sse(data)
    delta = delta_rule(data.residual(first))
    best = solve_huber(data, delta, first)
    return Fits(data, first, best, delta, certify(data, best, delta), verify, truth)


def own_way(seeds: int = SEEDS) -> np.ndarray:
    """Return the parameters (R, P) that `exoid identify` finds with the bench's instruments."""
    runs = [record(seed, paper_trajectory()) for seed in range(seeds)]
    return np.array([identify(LEG, [run.recording], optimisers=()).linear for run in runs])


def misprint(train: BenchRun, unseen: BenchRun) -> dict[str, np.ndarray]:
    """Return the true RMS error (J,) on unseen motion of an SSE fit with the derived Y and with the printed one."""
    found = {}
    for name, change in (("derived", 0.0), ("printed", 1.0)):
        pair = []
        for run, tau in ((train, train.recording.tau), (unseen, unseen.torque)):
            data = linear_data(run, tau)
            columns = np.array(data.columns)
            q = low_pass(run.recording.q, CUTOFF, RATE)
            dq, ddq = derivatives(q, RATE)
            columns[0, :, 2] += change * np.cos(q[:, 1]) * ((2 * dq[:, 0] + dq[:, 1]) - (2 * ddq[:, 0] + ddq[:, 1]))
            pair.append(LinearData(columns, data.tau, data.groups, data.names, data.units))
        found[name] = pair[1].rms(solve_sse(pair[0]))
    return found


def published_motion(periods: tuple[float, ...] = (8.0, 9.0, 10.0, 12.0, 15.0)) -> list[tuple[float, float, bool]]:
    """Return (period in s, condition number, whether Table 1 holds) of the published coefficients, read as degrees."""
    return [
        (p, condition(paper_trajectory(p)), bool(np.all(largest_scale(paper_trajectory(p)) >= 1.0))) for p in periods
    ]


def condition(path: Fourier, samples: int = 200) -> float:
    """Return cond(Ȳ) over one period."""
    motion = path.at(np.arange(samples) * path.period / samples)
    return float(np.linalg.cond(np.asarray(LEG.columns(motion)).reshape(2 * samples, -1)))


@dataclass(frozen=True, eq=False)
class Search:
    """How the trajectory was searched: best cond(Ȳ) (R, G) after `counts` (G,) evaluations; ∞ where none was inside."""

    history: np.ndarray
    counts: np.ndarray


def search_motion(box: float, rescaled: bool, seeds: int, samples: int = 100) -> Search:
    """Search the excitation with NFO 20 × 400 from coefficients within ±`box` rad; ∞ outside Table 1, or rescaled."""
    runs = []
    for seed in range(seeds):

        def fitness(population: np.ndarray) -> np.ndarray:
            return np.array([_excitation(x, rescaled, samples) for x in population])

        size = 20
        problem = Problem(fitness, np.full(size, -box), np.full(size, box), ("c",) * size, ("rad",) * size)
        runs.append(minimise(problem, NFO(), individuals=20, generations=400, seed=seed))
    return Search(np.array([run.history for run in runs]), runs[0].counts)


def _excitation(x: np.ndarray, rescaled: bool, samples: int) -> float:
    path = Fourier(np.array(CENTRE), x[:10].reshape(2, 5), x[10:].reshape(2, 5), 10.0)
    if rescaled:
        return condition(within(path, TABLE_1), samples)
    return condition(path, samples) if np.all(largest_scale(path) >= 1.0) else float("inf")


def designs(seeds: int) -> list[Excitation]:
    """Return what `exoid design` finds, with IPOPT's best known motion from the first seed."""
    return [design(LEG, seed=seed, starts=3 if seed == 0 else 0) for seed in range(seeds)]


def rivals_of_motion(seeds: int) -> Rivals:
    """Let NFO, PSO, GA, DE and CMA-ES search motions, 20 × 400, rescaled and with the infinite penalty."""
    return rivals(LEG, problem="excitation", seeds=seeds, jobs=1)


@dataclass(frozen=True, eq=False)
class Curves:
    """Relative gap to the certified optimum: {optimiser: (R, G)} after `counts` {optimiser: (G,)}, and IPOPT."""

    gaps: Mapping[str, np.ndarray]
    counts: Mapping[str, np.ndarray]
    reference: Reference
    reference_gap: float


def converge(fits: Fits, seeds: int = SEEDS) -> Curves:
    """Let NFO as printed, PSO and GA (40 × 400) minimise the Huber loss, in physical and in whitened coordinates."""
    compiled = fitness(fits.data.columns, fits.data.tau)
    problem = huber_problem(fits.data, lambda x: compiled.huber(x, fits.delta), fits.delta, fits.sse)
    pso, ga = optimisers()["pso"](), optimisers()["ga"]()
    recipes: dict[str, tuple[Any, Problem]] = {
        "NFO, as printed": (NFO(), problem), "PSO": (pso, problem), "GA": (ga, problem),
        "NFO, whitened": (NFO(), problem.whitened()), "PSO, whitened": (pso, problem.whitened()),
        "GA, whitened": (ga, problem.whitened()),
    }  # fmt: skip
    best, gaps, counts = fits.proof.primal, {}, {}
    for name, (recipe, where) in recipes.items():
        runs = [minimise(where, recipe, seed=seed) for seed in range(seeds)]
        gaps[name] = np.array([np.maximum(run.history / best - 1.0, 1e-16) for run in runs])
        counts[name] = runs[0].counts
    reference = solve_reference(fits.data, fits.delta)
    return Curves(gaps, counts, reference, reference.loss / best - 1.0)
