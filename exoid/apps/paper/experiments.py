"""The paper's experiments on the virtual bench with the leg that it identified; each is made once, when asked for.

The leg, its motion, its limits, the sizes of its populations and its thresholds are the paper's; its recordings are not
published. Shapes: N samples, J = 2 joints, P = 8 parameters.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from types import MappingProxyType

import numpy as np

from exoid.apps.paper.item import SEEDS
from exoid.apps.paper.printed import CUTOFF, DURATION, PAPER_DELTA, RATE
from exoid.ground.engines.engine import Engine, completed
from exoid.ground.engines.processes import processes
from exoid.measurement.bench.leg import paper_leg
from exoid.measurement.bench.simulation import Bench, BenchRun, run_bench
from exoid.measurement.signals.conditioning import derivatives, low_pass
from exoid.measurement.trajectories.trajectory import Fourier, paper_trajectory
from exoid.optimisation.contest.motion import NARROW, WIDE, MotionContest, MotionEntrant, motion_contest
from exoid.optimisation.contest.problem import paper_contest
from exoid.optimisation.contest.rivals import entrants, rivals
from exoid.optimisation.contest.standings import Rivals
from exoid.optimisation.contest.subject import ContestSubject
from exoid.optimisation.excitation.design import design, evaluate
from exoid.optimisation.excitation.result import Excitation
from exoid.optimisation.excitation.settings import CRITERION_NAMES
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.fitting.settings import Search
from exoid.optimisation.linear.certificate import Certificate, certify
from exoid.optimisation.linear.problem import LinearData
from exoid.optimisation.linear.solve import delta_rule, solve_huber, solve_sse
from exoid.optimisation.optimisers.nfo import NFO
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion

UNSEEN = 1_000
"""What is added to a seed for the motion that a fit is judged on."""
STARTS = 1
"""Starts of IPOPT for its best motion."""
CONDITION = "condition"
ENTRANTS = ("nfo", "pso", "ga")
"""Those whom the paper compares."""
BOXES = (WIDE, NARROW, 0.05)
"""rad: half-widths of the box of motions that are sought with an infinite penalty; the paper does not print its own."""


@dataclass(frozen=True, eq=False)
class PaperFits:
    """SSE and Huber on one recording: parameters (P,), thresholds `delta` (J,), the proof, and an unseen motion with
    measured and with true torque, N·m.
    """

    data: LinearData
    sse: Float
    huber: Float
    delta: Float
    proof: Certificate
    verify: LinearData
    truth: LinearData

    def error(self, linear: Float, against: str) -> float:
        """Return the RMS error over both joints on the unseen motion against "measured" or "true" torque, N·m."""
        data = self.verify if against == "measured" else self.truth
        return float(np.sqrt(np.mean(data.residual(linear) ** 2)))

    def ratio(self, against: str) -> float:
        """Return Huber's RMS error over that of SSE."""
        return self.error(self.huber, against) / self.error(self.sse, against)


def _usual(run: BenchRun, rng: np.random.Generator) -> Float:
    """The bench's own instruments: 0.5 N·m of noise, 6 % outliers, bursts of chatter."""
    return np.asarray(run.recording.tau)


def _symmetric(run: BenchRun, rng: np.random.Generator) -> Float:
    """Errors of the size of the paper's δ, as often up as down: every fifth sample is knocked."""
    knocked = rng.random(run.torque.shape) < 0.2
    return np.asarray(run.torque + PAPER_DELTA * (0.15 + 2.35 * knocked) * rng.standard_normal(run.torque.shape))


def _one_sided(run: BenchRun, rng: np.random.Generator) -> Float:
    """Errors of the size of the paper's δ that all point one way: knocks of about 0.2 s, one a second."""
    torque = np.asarray(run.torque + 0.15 * PAPER_DELTA * rng.standard_normal(run.torque.shape))
    for joint in range(torque.shape[1]):
        for start in rng.integers(0, len(torque), int(DURATION)):
            torque[start : start + int(20 * rng.uniform(0.5, 1.5)), joint] += 1.4 * PAPER_DELTA[joint]
    return torque


ERRORS: Mapping[str, Callable[[BenchRun, np.random.Generator], Float]] = MappingProxyType(
    {
        "the bench's instruments": _usual,
        "as large as the paper's δ, both ways": _symmetric,
        "as large as the paper's δ, one way": _one_sided,
    }
)
"""Ways in which the torque sensors may be wrong; the paper does not say which were its own."""
USUAL, _, ONE_SIDED = ERRORS


@dataclass(frozen=True, eq=False)
class Experiments:
    """All of the paper's experiments, those that are random for `seeds` seeds from `seed` on."""

    seed: int = 0
    seeds: int = SEEDS

    @cached_property
    def engine(self) -> Engine:
        """The processes that all experiments share, so that they start and compile once; `close` ends them."""
        return processes()

    def close(self, ended: bool = True) -> None:
        """End the processes where there are any, in the middle of their work unless all has `ended`."""
        engine = self.__dict__.pop("engine", None)
        if engine is not None:
            engine.close(ended)

    @cached_property
    def leg(self) -> Model:
        """The eight-parameter model."""
        return Model.standard()

    @cached_property
    def runs(self) -> tuple[BenchRun, ...]:
        """The leg along the published motion, 35 s at 10 ms, one run per seed."""
        return tuple(_record(self.leg, seed, paper_trajectory()) for seed in self._all)

    @cached_property
    def unseen(self) -> tuple[BenchRun, ...]:
        """The same leg along another motion, one per seed."""
        return tuple(_record(self.leg, seed + UNSEEN, None) for seed in self._all)

    @cached_property
    def fits(self) -> Mapping[str, tuple[PaperFits, ...]]:
        """{kind of error: the fits of each seed}; fitted on the published motion, judged on the other."""
        return MappingProxyType({name: tuple(self._fits(wrong)) for name, wrong in ERRORS.items()})

    @cached_property
    def identified(self) -> Float:
        """The parameters (R, P) that `exoid identify` finds in the same recordings."""
        return np.array([identify(self.leg, [run.recording], optimisers=()).linear for run in self.runs])

    @cached_property
    def printed_regressor(self) -> Mapping[str, Float]:
        """{"derived", "printed"}: true RMS error (J,) on the unseen motion of an SSE fit with either Y, N·m."""
        return {name: self._misprinted(share) for name, share in (("derived", 0.0), ("printed", 1.0))}

    def published(self, period: float = 10.0) -> Excitation:
        """Return the evaluation of the published coefficients, read as degrees, at a `period` in s."""
        return evaluate(paper_trajectory(period), self.leg, name="the paper's")

    @cached_property
    def designs(self) -> Mapping[str, Excitation]:
        """{criterion: the motion that `exoid design` finds for it}; for the condition number with IPOPT beside it."""
        ended = completed(self.engine, _designed, CRITERION_NAMES, lambda name: (self.leg, name, self.seed))
        found = {name: future.result() for name, future in ended}
        return {name: found[name] for name in CRITERION_NAMES}

    @cached_property
    def motions(self) -> MotionContest:
        """The search for a motion, with the best one known."""
        return motion_contest(self.leg, CONDITION, found=self.designs[CONDITION])

    @cached_property
    def on_motions(self) -> Rivals:
        """All optimisers on motions that are rescaled, and those of the paper with the infinite penalty too."""
        known = entrants(problem="excitation")
        names = [name for name in known if name.removesuffix("_penalty") in (name, *ENTRANTS)]
        competing = {name: known[name] for name in names}
        return self._competing(self.motions, competing)

    @cached_property
    def boxes(self) -> Rivals:
        """NFO with an infinite penalty in boxes of several sizes, and with rescaled motions."""
        done = {NARROW: "nfo_penalty", None: "nfo"}
        missing = {_within(half): MotionEntrant(NFO(), penalised=True, half=half) for half in BOXES if half not in done}
        found = self._competing(self.motions, missing)
        both = {**found.outcomes, **{_within(half): self.on_motions.outcomes[name] for half, name in done.items()}}
        names = [_within(half) for half in (*BOXES, None)]
        return replace(found, searches={}, outcomes={name: both[name] for name in names})

    @cached_property
    def on_fits(self) -> Mapping[str, Rivals]:
        """{"SSE", "Huber"}: NFO, PSO and GA on the paper's fit; NFO, and PSO by SSE, in whitened coordinates too."""
        known = entrants(whitened=True)
        squared = paper_contest(self.seed, delta=np.full(len(self.leg.joints), np.inf))
        tasks = {
            "SSE": (squared, [*ENTRANTS, *(f"{name}_whitened" for name in ENTRANTS[:2])]),
            "Huber": (paper_contest(self.seed), [*ENTRANTS, f"{ENTRANTS[0]}_whitened"]),
        }
        found = {}
        for loss, (problem, names) in tasks.items():
            found[loss] = self._competing(problem, {name: known[name] for name in names})
        return MappingProxyType(found)

    @property
    def _all(self) -> range:
        return range(self.seed, self.seed + self.seeds)

    def _competing(self, problem: ContestSubject, competing: Mapping[str, Search]) -> Rivals:
        return rivals(problem, seed=self.seed, seeds=self.seeds, competing=competing, engine=self.engine)

    def _fits(self, wrong: Callable[[BenchRun, np.random.Generator], Float]) -> list[PaperFits]:
        found = []
        for seed, train, unseen in zip(self._all, self.runs, self.unseen, strict=True):
            rng = np.random.default_rng([seed, 7])
            data = linear_data(self.leg, train, wrong(train, rng))
            verify = linear_data(self.leg, unseen, wrong(unseen, rng))
            truth = linear_data(self.leg, unseen, unseen.torque)
            sse = solve_sse(data)
            delta = delta_rule(data.residual(sse))
            best = solve_huber(data, delta, sse)
            found.append(PaperFits(data, sse, best, delta, certify(data, best, delta), verify, truth))
        return found

    def _misprinted(self, share: float) -> Float:
        pair = []
        train, unseen = self.runs[0], self.unseen[0]
        for run, tau in ((train, train.recording.tau), (unseen, unseen.torque)):
            data, motion = linear_data(self.leg, run, tau), _smoothed(run)
            columns, (dq1, dq2), (ddq1, ddq2) = np.array(data.columns), motion.dq.T, motion.ddq.T
            columns[0, :, 2] += share * np.cos(motion.q[:, 1]) * (2 * dq1 + dq2 - 2 * ddq1 - ddq2)
            pair.append(LinearData(columns, data.tau, data.groups, data.names, data.units))
        return pair[1].rms(solve_sse(pair[0]))


def linear_data(model: Model, run: BenchRun, tau: Float) -> LinearData:
    """Return τ = YΦ with Y from smoothed encoders, and `tau` (N, J) as it is: nothing filtered, nothing repaired."""
    names, units = zip(*((p.name, p.unit) for p in model.parameters), strict=True)
    return LinearData(model.columns(_smoothed(run)), tau.T, np.zeros(len(tau), dtype=np.int64), names, units)


def _smoothed(run: BenchRun) -> Motion:
    q = low_pass(run.recording.q, CUTOFF, RATE)
    return Motion(run.recording.t, q, *derivatives(q, RATE))


def _record(model: Model, seed: int, excitation: Fourier | None) -> BenchRun:
    return run_bench(
        model, paper_leg(), excitation=excitation, seed=seed, bench=Bench(duration=DURATION, rate=RATE)
    )


def _within(half: float | None) -> str:
    """Return the name of a search of motions in a box of this half-width; None where they are rescaled."""
    return f"rescaled into the limits, within ±{WIDE:g} rad" if half is None else f"∞ outside, within ±{half:g} rad"


def _designed(model: Model, criterion: str, seed: int) -> Excitation:
    """Return the motion that is best by a criterion; with IPOPT beside it where motions compete."""
    return design(model, criterion=criterion, seed=seed, starts=STARTS if criterion == CONDITION else 0)
