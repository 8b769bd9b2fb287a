"""One problem on which optimisers compete: the Huber loss of a fit whose optimum is proven, with one budget, and for
each seed one first population for all.

The first population is drawn evenly from the physical box of `problem.py`. An optimiser that searches in whitened
coordinates gets the very same points, and the box around the image of the physical box, so that nobody starts nearer.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from exoid.ground.extras import version_of
from exoid.measurement.bench.leg import paper_leg
from exoid.measurement.bench.sensors import Sensors
from exoid.measurement.bench.simulation import Bench, run_bench
from exoid.measurement.trajectories.trajectory import paper_trajectory
from exoid.optimisation.budget import GENERATIONS, INDIVIDUALS
from exoid.optimisation.contest.subject import ContestError, ContestSubject
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.fitting.settings import Search
from exoid.optimisation.linear.certificate import Certificate, certify
from exoid.optimisation.linear.loss import huber
from exoid.optimisation.linear.problem import LinearData, Problem, huber_problem, sse_problem
from exoid.optimisation.linear.solve import delta_rule, solve_huber, solve_sse
from exoid.optimisation.optimiser import minimise
from exoid.symbolic.codegen.fitness import fitness
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

VERSION = 1
"""Raised when a change of the code makes results kept on disk those of another experiment."""

DURATION, RATE, OUTLIERS, NOISE = 35.0, 100.0, 0.10, 5.0
"""The paper's recording: s, Hz; share of spoilt torque samples and standard deviation of the others, N·m."""


@dataclass(frozen=True, eq=False, kw_only=True)
class Contest(ContestSubject):
    """Minimise the Huber loss of `data` for thresholds `delta` (J,) from within the box around `sse_linear` (P,).

    Where `delta` is infinite the loss is the sum of squared errors, and the box is the one that holds its optimum.
    """

    goal: ClassVar[str] = "certified optimum"
    targets: ClassVar[tuple[float, ...]] = tuple(10.0**-k for k in range(2, 11))
    drawn: ClassVar[Float] = np.logspace(2.0, -10.0, 49)
    floor: ClassVar[float] = 1e-16

    data: LinearData = field(repr=False)
    delta: Float  # type: ignore[misc]
    sse_linear: Float = field(repr=False)
    certificate: Certificate  # type: ignore[misc]

    @property
    def function(self) -> str:
        """Name of the loss."""
        return "sse" if self.squared else "huber"

    @property
    def squared(self) -> bool:
        """True if the loss is the sum of squared errors."""
        return bool(np.isinf(self.delta).all())

    @property
    def size(self) -> int:
        """Number of linear parameters."""
        return int(self.data.columns.shape[2])

    @property
    def best(self) -> float:
        """The certified optimum."""
        return self.certificate.primal

    @property
    def standard(self) -> str:
        """Statement of the certificate."""
        return str(self.certificate)

    def gap(self, value: Float) -> Float:
        """Distance of losses above the certified optimum, relative to it; what rounding puts below is 0."""
        best = self.certificate.primal
        # A perfect fit has a loss of rounding size, which is no measure of anything.
        scale = max(best, 1e-12 * huber(self.data.tau, self.delta), np.finfo(float).tiny)
        return np.maximum((np.asarray(value, dtype=float) - best) / scale, 0.0)

    def value(self, x: Float, search: Search) -> float:
        """Return the loss for parameters (P,)."""
        return float(huber(self.data.residual(x), self.delta))

    def problem(self) -> Problem:
        """Return the problem in physical coordinates, with the compiled fitness."""
        compiled, delta = fitness(self.data.columns, self.data.tau), self.delta
        if self.squared:
            return sse_problem(self.data, compiled.sse)
        return huber_problem(self.data, lambda x: compiled.huber(x, delta), delta, self.sse_linear)

    def setting(self, search: Search, seed: int) -> tuple[Problem, Float]:
        """Return the problem, in whitened coordinates where `search` is, and the same first population for all."""
        problem = self.problem()
        start = problem.low + self.draws(seed, problem.low.size) * (problem.high - problem.low)
        if not search.whitened:
            return problem, start
        forward = self.data.factor.forward
        return _image(problem, forward), start @ forward.T

    def fingerprint(self) -> str:
        """Return a SHA-256 of everything about the problem and the budget that a result depends on."""
        content = hashlib.sha256()
        for array in (self.data.columns, self.data.tau, self.delta, self.sse_linear):
            content.update(np.ascontiguousarray(array).tobytes())
        sizes = [VERSION, self.data.columns.shape, self.individuals, self.generations]
        versions = [version_of(name) for name in ("numpy", "pymoo", "cma")]
        content.update(json.dumps([sizes, versions]).encode())
        return content.hexdigest()


@dataclass(frozen=True, eq=False)
class Outcome:
    """One run of the optimiser called `name`: `gaps` (K,) found at evaluations `found_at` (K,), each better than all
    before; the best `x` (P,) in physical parameters.
    """

    name: str
    seed: int
    found_at: Float = field(repr=False)
    gaps: Float = field(repr=False)
    x: Float
    evaluations: int
    seconds: float

    @property
    def gap(self) -> float:
        """The relative distance to the certified optimum at the end."""
        return float(self.gaps[-1])

    def hit(self, target: float) -> float:
        """Return the number of the evaluation that first came to `target` or below; ∞ if none did."""
        reached = np.flatnonzero(self.gaps <= target)
        return float(self.found_at[reached[0]]) if reached.size else float("inf")

    def at(self, evaluations: Float) -> Float:
        """Return the best gap after each number of `evaluations` (G,)."""
        place = np.searchsorted(self.found_at, evaluations, side="right") - 1
        return self.gaps[np.maximum(place, 0)]

    def to_json(self) -> dict[str, Any]:
        """Return the outcome in plain types."""
        return {k: v.tolist() if isinstance(v, np.ndarray) else v for k, v in self.__dict__.items()}


def contest_of(fit: Fit, individuals: int = INDIVIDUALS, generations: int = GENERATIONS) -> Contest:
    """Return the Huber problem of `fit`; shape parameters stay where the fit found them."""
    name = f"{fit.model.name}: {', '.join(fit.recordings)}"
    data = fit.data.weighted(fit.weight)
    return _proven(name, fit.joints, data, fit.limits, individuals, generations)


def paper_contest(
    seed: int = 0, individuals: int = INDIVIDUALS, generations: int = GENERATIONS, delta: Float | None = None
) -> Contest:
    """Return the paper's problem on the virtual bench: its leg on its motion, 35 s at 10 ms, 10 % outliers.

    Its thresholds `delta` (J,) are those of the paper's 14 % rule where they are not given; infinite ones are for SSE.
    The regressor is that of the true motion: what is compared here are optimisers, not filters.
    """
    model = Model.standard()
    sensors = replace(Sensors.ideal(), torque_noise=NOISE, outlier_share=OUTLIERS, outlier_size=30.0 * NOISE)
    bench = Bench(duration=DURATION, rate=RATE, sensors=sensors)
    made = run_bench(model, paper_leg(), excitation=paper_trajectory(), seed=seed, bench=bench)
    tau = made.recording.tau.T
    names, units = zip(*((p.name, p.unit) for p in model.parameters), strict=True)
    data = LinearData(model.columns(made.motion), tau, np.zeros(tau.shape[1], dtype=np.int64), names, units)
    return _proven("the paper's leg on the virtual bench", model.joints, data, delta, individuals, generations)


def _proven(
    name: str, joints: Sequence[Joint], data: LinearData, delta: Float | None, individuals: int, generations: int
) -> Contest:
    data.require_enough(joints)
    sse = solve_sse(data)
    limit = delta_rule(data.residual(sse), use=data.use) if delta is None else delta
    certificate = certify(data, solve_huber(data, limit, sse), limit)
    if not certificate.holds:
        what = f"there is no proven optimum to measure distances from: {certificate}"
        raise ContestError(what, where=name, remedy="see with `exoid identify` what these recordings do not determine")
    return Contest(
        name=name, data=data, delta=limit, sse_linear=sse, certificate=certificate, individuals=individuals,
        generations=generations,
    )  # fmt: skip


def race(contest: ContestSubject, name: str, search: Search, seed: int) -> Outcome:
    """Run one optimiser once. The same arguments give the same outcome, whoever else runs."""
    problem, start = contest.setting(search, seed)
    run = minimise(
        problem,
        search.optimiser,
        name=name,
        individuals=contest.individuals,
        generations=contest.generations,
        seed=seed,
        start=start,
    )
    return Outcome(name, seed, run.found_at, contest.gap(run.found), run.x, run.evaluations, run.seconds)


def _image(problem: Problem, forward: Float) -> Problem:
    """Return the whitened problem on the smallest box around the image of the physical box."""
    middle = forward @ (0.5 * (problem.low + problem.high))
    half = np.abs(forward) @ (0.5 * (problem.high - problem.low))
    return replace(problem.whitened(), low=middle - half, high=middle + half)
