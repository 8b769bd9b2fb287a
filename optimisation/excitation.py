"""Motions that tell as much as possible about a leg's numbers: designed, checked, and judged.

    θ_i(t) = θ_i0 + Σ_{k=1..K} a_ik sin(kωt) + b_ik cos(kωt)                          (13) of the paper

NFO searches the coefficients, 20 individuals × 400 generations. A fitness of Inf outside the limits, as the paper has
it, starves the search: nearly every individual is at Inf. Here every candidate is stretched to the first limit it
meets, so that the search stays among motions that a leg can make ("feasible by construction"); the printed variant is
kept for comparison. Individuals are the stretched motions themselves, shifted in time to resemble each other where the
start does not matter, so that near neighbours are near motions. The first part of the budget explores with a smooth
stand-in of cond(Ȳ), because its kinks hide the valleys; the rest goes on with the criterion itself. IPOPT, started
from short searches, gives the best motion known; that is no proof of an optimum, since the problem is not convex.
"""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from measurement.extremes import bounds, margin, uses
from measurement.trajectory import Fourier, paper_trajectory
from optimisation.criteria import CRITERIA, Aim, Noise, condition, deviations, fisher, log_det, softened
from optimisation.excitation_result import Candidate, Excitation, Precision
from optimisation.motion_reference import solve_motions
from optimisation.motion_space import MotionSpace, motion_space
from optimisation.nominal import Nominal, nominal, sizes
from optimisation.optimiser import Box, Optimiser, minimise
from optimisation.optimisers.nfo import NFO
from optimisation.prepare import STICK
from optimisation.problem import Problem
from symbolic.errors import ExoidError
from symbolic.gram import Information, information
from symbolic.memory import memory_operations
from symbolic.model import Model
from symbolic.model_file import Numbers
from symbolic.motion import Float
from symbolic.quantity import JOINTS

GRID = 500
"""Samples per period in a search; its sums differ from those of 4000 by 1e-4, its proof of the limits costs 0.05 %."""
INDIVIDUALS, GENERATIONS = 20, 400
"""The paper's population and generations for this problem."""
EXPLORING = 150
"""Generations, of the same budget, that explore with the smooth stand-in."""
SHORT = 60
"""Generations of the search from whose result IPOPT starts."""
WIDE = 2.0
"""Half-width of the box around stretched motions: a mixture of harmonics may exceed what each alone may do."""
STARTS = 3
"""Starts of IPOPT."""
DURATION = 30.0
"""s of recording for which standard deviations are predicted."""
MOST_CREEP = 0.1
"""Share of time in which a joint may creep before that is said."""

Progress = Callable[[float, str], None]


class DesignError(ExoidError):
    """A design that cannot be made: unknown words, or no motion inside the limits."""


class NoMotionError(DesignError):
    """A search that met no motion inside the limits."""


@dataclass(frozen=True)
class Remembering:
    """An optimiser whose candidates are brought into a common form, and which keeps its last population.

    `form` turns points (I, n) into points (I, n) that stand for the same motions, so that near points are near motions.
    """

    optimiser: Optimiser
    form: Callable[[Float], Float]
    last: list[Any] = field(default_factory=list)

    @property
    def boundary(self) -> str:
        """As the optimiser's own."""
        return self.optimiser.boundary

    @property
    def invariances(self) -> frozenset[str]:
        """As the optimiser's own."""
        return self.optimiser.invariances

    def start(self, x: Float, f: Float, box: Box, rng: np.random.Generator) -> Any:
        """Start it."""
        return self._keep(self.optimiser.start(x, f, box, rng))

    def ask(self, state: Any, rng: np.random.Generator) -> Float:
        """Ask it."""
        return self.form(self.optimiser.ask(state, rng))

    def tell(self, state: Any, x: Float, f: Float) -> Any:
        """Tell it."""
        return self._keep(self.optimiser.tell(state, x, f))

    def _keep(self, state: Any) -> Any:
        self.last[:] = [state]
        return state


RECIPE = NFO(alpha=0.9, crossover=0.95)
"""NFO with almost every component taken: coefficients act together, a motion is no sum of independent choices."""


def design(
    model: Model | None = None,
    *,
    criterion: str = "condition",
    period: float = 10.0,
    harmonics: int = 5,
    offsets: str = "paper",
    rest: bool = False,
    use: float = 1.0,
    printed: bool = False,
    box: float = 1.0,
    noise: Noise | None = None,
    numbers: Numbers | None = None,
    duration: float = DURATION,
    starts: int = STARTS,
    individuals: int = INDIVIDUALS,
    generations: int = GENERATIONS,
    seed: int = 0,
    progress: Progress | None = None,
) -> Excitation:
    """Return the motion of `period` s inside the model's limits that is best by `criterion` (see `CRITERIA`).

    `offsets` (paper, middle, free), `rest` and `harmonics` are those of `motion_space`; `use` is the share of each
    limit that may be used (less than one leaves room for tracking errors). `printed` searches with Inf outside the
    limits, in a box of ± `box` times each harmonic's largest amplitude. `starts` of IPOPT, 0 for none. `numbers` are
    the model's identified ones. DesignError where no motion is inside the limits or determines the model.
    """
    began = time.perf_counter()
    say = progress or _silent
    model = Model.standard() if model is None else model
    if criterion not in CRITERIA:
        raise DesignError(f"there is no criterion {criterion!r}", remedy=f"one of: {', '.join(CRITERIA)}")
    if not 0.0 < use <= 1.0:
        raise DesignError(f"{use:g} of the limits", remedy="give a share above 0 and at most 1")
    room = bounds(model.limits, use)
    space = motion_space(
        shrunk(room, margin(harmonics, GRID)), period=period, harmonics=harmonics, offsets=offsets, rest=rest
    )
    at = nominal(model, numbers)
    aim = Aim(sizes(model, at), noise or Noise.white(), duration)
    info = information(model, at.linear, at.shape, space.limits, period=period, harmonics=harmonics, grid=GRID)
    search = _Search(info, space, aim, criterion, printed, box, individuals, generations, seed, say)
    found = search.run()
    references: list[Candidate] = []
    if starts > 0 and not printed and not memory_operations(model):
        say(0.6, "IPOPT")
        references = search.reference(starts)
    best = min([found, *references], key=lambda one: one.value)
    say(0.95, "judging the motion")
    cautions = _cautions(model, starts, printed)
    return _judged(
        model, best, (found, *references), aim, at, criterion, room, offsets, rest, seed, cautions,
        time.perf_counter() - began,
    )  # fmt: skip


def evaluate(
    trajectory: Fourier,
    model: Model | None = None,
    *,
    criterion: str = "condition",
    name: str = "given",
    noise: Noise | None = None,
    numbers: Numbers | None = None,
    duration: float = DURATION,
    use: float = 1.0,
) -> Excitation:
    """Return how good a given motion is and what it makes of the model's limits, without any search."""
    began = time.perf_counter()
    model = Model.standard() if model is None else model
    at = nominal(model, numbers)
    aim = Aim(sizes(model, at), noise or Noise.white(), duration)
    room = bounds(model.limits, use)
    info = information(
        model, at.linear, at.shape, room,
        period=trajectory.period, harmonics=trajectory.sine.shape[1], grid=GRID,
    )  # fmt: skip
    swing = np.concatenate([trajectory.sine, trajectory.cosine], axis=1)[None]
    value = CRITERIA[criterion](info.sums(swing, trajectory.offset[None], rescale=False).gram, aim)
    one = Candidate(name, trajectory, float(value[0]), 1, 0.0, "")
    rest = bool(np.abs(np.array([trajectory.at(np.zeros(1)).dq, trajectory.at(np.zeros(1)).ddq])).max() < 1e-9)
    return _judged(
        model, one, (one,), aim, at, criterion, room, "given", rest, 0, (), time.perf_counter() - began
    )  # fmt: skip


def evaluate_paper(period: float = 10.0, model: Model | None = None) -> Excitation:
    """Return the judgement of the paper's published coefficients at a `period` in s, which the paper does not print."""
    return evaluate(paper_trajectory(period), model, name="the paper's")


def _silent(fraction: float, text: str) -> None:
    """Say nothing."""


def shrunk(room: Float, share: float) -> Float:
    """Return limits (J, 4) drawn in about the middle of each range to `share`: what values on the grid may use."""
    middle, half = 0.5 * (room[:, 0] + room[:, 1]), 0.5 * (room[:, 1] - room[:, 0]) * share
    return np.column_stack([middle - half, middle + half, room[:, 2:] * share])


@dataclass(frozen=True, eq=False)
class _Search:
    """What stays the same during one design."""

    info: Information
    space: MotionSpace
    aim: Aim
    criterion: str
    printed: bool
    box: float
    individuals: int
    generations: int
    seed: int
    say: Progress

    def value(self, y: Float) -> Float:
        """Return the criterion (I,) of points `y` (I, n), stretched to the limits or Inf outside them."""
        swings, offsets = self.space.split(y)
        sums = self.info.sums(swings, offsets, rescale=not self.printed)
        value = CRITERIA[self.criterion](sums.gram, self.aim)
        return np.where((sums.factor >= 1.0).all(axis=1), value, np.inf) if self.printed else value

    def smooth(self, y: Float) -> Float:
        """Return the smooth stand-in (I,) of cond(Ȳ)."""
        swings, offsets = self.space.split(y)
        return softened(self.info.sums(swings, offsets, rescale=True).gram)

    def run(self) -> Candidate:
        """Return what NFO finds within its budget; NoMotionError where none is inside the limits."""
        began = time.perf_counter()
        if self.printed:
            run = minimise(
                self._problem(self.value, self.box), NFO(), individuals=self.individuals, generations=self.generations,
                seed=self.seed,
            )  # fmt: skip
            best = run.x, run.fitness
        else:
            best = self._formed(self.generations, EXPLORING, self.seed)
        if not np.isfinite(best[1]):
            raise NoMotionError(
                f"not one of {self.individuals * self.generations} motions was inside the limits: Inf outside starves "
                "the search",
                where=f"NFO as printed, box {self.box:g}",
                remedy="leave --printed away (every motion is then feasible by construction), or try a smaller --box",
            )
        spent = self.individuals * self.generations
        name = "NFO as printed" if self.printed else "NFO"
        return self._candidate(name, best[0][None], best[1], spent, time.perf_counter() - began)

    def _formed(self, generations: int, exploring: int, seed: int) -> tuple[Float, float]:
        """Return the best point and its value after a search among motions in a common form."""
        rng = np.random.default_rng(seed)
        x = self.stretched(rng.uniform(-1.0, 1.0, (self.individuals, self.space.size)))
        first = x[int(np.argmin(self.value(x)))]

        def form(y: Float) -> Float:
            return self.stretched(self.space.aligned(y, first) if self.shiftable else y)

        remember = Remembering(RECIPE, form)
        x = form(x)
        if self.criterion == "condition" and generations > 2 * exploring > 0:
            self.say(0.05, "NFO explores")
            minimise(
                self._problem(self.smooth, WIDE), remember, individuals=self.individuals, generations=exploring,
                seed=seed, start=x,
            )  # fmt: skip
            x, generations = remember.last[0].x, generations - exploring
        self.say(0.3, "NFO")
        run = minimise(
            self._problem(self.value, WIDE), remember, individuals=self.individuals, generations=generations,
            seed=seed, start=x,
        )  # fmt: skip
        return run.x, run.fitness

    def stretched(self, y: Float) -> Float:
        """Return points (I, n) as the motions they stand for: stretched to the first limit they meet."""
        swings, offsets = self.space.split(y)
        factor = self.info.sums(swings, offsets, rescale=False).factor
        width = self.space.basis.shape[2]
        out = y.copy()
        out[:, : 2 * width] *= np.repeat(np.minimum(factor, 1e6), width, axis=1)
        return out

    def reference(self, starts: int) -> list[Candidate]:
        """Return where IPOPT ends from what short searches of its own find, best first."""
        began = time.perf_counter()
        points = [self._formed(SHORT, 0, self._seed(k))[0] for k in range(starts)]
        ended = solve_motions(self.info, self.space, self.aim, self.criterion, np.array(points))
        sums = self.info.sums(ended.swings, ended.offsets, rescale=True)
        values = CRITERIA[self.criterion](sums.gram, self.aim)
        each = (time.perf_counter() - began) / starts
        out = []
        for k, value in enumerate(values):
            swing = ended.swings[k] * sums.factor[k][:, None]
            motion = self.space.trajectory(swing, ended.offsets[k])
            out.append(Candidate(f"IPOPT {k + 1}", motion, float(value), ended.iterations[k], each, ended.statuses[k]))
        return sorted(out, key=lambda one: one.value if np.isfinite(one.value) else np.inf)

    @property
    def shiftable(self) -> bool:
        """Whether a motion that starts later, or runs backwards, is the same motion to the criterion."""
        return not self.info.model.terms and self.space.whole

    def _problem(self, fitness: Callable[[Float], Float], width: float) -> Problem:
        edge = np.full(self.space.size, width)
        if self.space.centre is None:
            edge[-2:] = 1.0
        return Problem(fitness, -edge, edge, self.space.names, ("1",) * self.space.size)

    def _candidate(self, name: str, y: Float, value: float, evaluations: int, seconds: float) -> Candidate:
        swings, offsets = self.space.split(y)
        factor = self.info.sums(swings, offsets, rescale=False).factor[0] if not self.printed else np.ones(2)
        motion = self.space.trajectory(swings[0] * factor[:, None], offsets[0])
        return Candidate(name, motion, value, evaluations, seconds, "")

    def _seed(self, k: int) -> int:
        return int(np.random.SeedSequence([self.seed, k]).generate_state(1)[0])


def _cautions(model: Model, starts: int, printed: bool) -> tuple[str, ...]:
    out = []
    if memory_operations(model):
        out.append(
            "operators with a past (play, dahl, delay, ddt) have no formula at an instant: their columns are "
            "computed in Python, the motion is taken to start at rest in its past, and there is no IPOPT reference"
        )
    elif starts <= 0 and not printed:
        out.append("no IPOPT reference was asked for")
    if any("t" in str(term.effect.torque) and term.effect.family == "drift" for term in model.terms):
        out.append("an effect that drifts with time is judged over one period, from its start")
    choices = [s.name for s in model.shapes if s.shape.choices]
    if choices:
        out.append(f"held as they are, since they are choices and have no derivative: {', '.join(choices)}")
    return tuple(out)


def _judged(
    model: Model,
    best: Candidate,
    candidates: tuple[Candidate, ...],
    aim: Aim,
    at: Nominal,
    criterion: str,
    room: Float,
    offsets: str,
    rest: bool,
    seed: int,
    cautions: tuple[str, ...],
    seconds: float,
) -> Excitation:
    """Return the result, every figure of merit computed anew for the motion chosen."""
    motion = best.trajectory
    info = information(
        model, at.linear, at.shape, room, period=motion.period, harmonics=motion.sine.shape[1], grid=2 * GRID
    )
    swing = np.concatenate([motion.sine, motion.cosine], axis=1)[None]
    gram = info.sums(swing, motion.offset[None], rescale=False).gram
    known = fisher(gram, aim.noise, aim.duration)
    spread = deviations(known)[0]
    units = {p.name: p.unit for p in model.parameters} | {s.name: s.shape.unit for s in model.shapes}
    values = dict(zip((p.name for p in model.parameters), at.linear, strict=True))
    values |= dict(zip((s.name for s in model.shapes), at.shape, strict=True))
    precision = tuple(
        Precision(name, float(values[name]), units[name], float(sd), float(sd / size) if size > 0.0 else None)
        for name, sd, size in zip(info.names, spread, aim.size, strict=True)
    )
    creeping, moving = _without_creep(info, motion)
    if max(creeping) > MOST_CREEP:
        shares = " and ".join(f"{joint} {100 * part:.0f} %" for joint, part in zip(JOINTS, creeping, strict=True))
        cautions = (
            *cautions,
            f"slower than {STICK:g} rad/s for {shares} of the time, where a real joint may stick and a fit leaves "
            f"samples out; without them cond(Ȳ) is {moving:.1f}",
        )
    lost = [p.name for p in precision if not np.isfinite(p.deviation)]
    if lost:
        cautions = (*cautions, f"this motion says nothing about {', '.join(lost)} one by one")
    return Excitation(
        model=model,
        trajectory=motion,
        criterion=criterion,
        value=best.value,
        condition=float(condition(gram)[0]),
        log_det=float(log_det(known)[0]),
        candidates=candidates,
        chosen=best.name,
        uses=uses(motion, _limits(room)),
        precision=precision,
        noise=aim.noise,
        duration=aim.duration,
        numbers=at.source,
        offsets=offsets,
        rest=rest,
        backend=info.backend,
        seed=seed,
        creeping=creeping,
        condition_moving=moving,
        cautions=cautions,
        seconds=seconds,
    )


def _without_creep(info: Information, motion: Fourier) -> tuple[tuple[float, float], float]:
    """Return the share of time each joint may stick, and cond(Ȳ) of the other samples."""
    along = motion.at(info.times)
    slow = np.abs(along.dq) < STICK
    rows = info.sensitivities(along)
    kept = np.concatenate([rows[j][~slow[:, j]] for j in range(len(JOINTS))])
    size = np.linalg.svd(kept, compute_uv=False)
    share = slow.mean(axis=0)
    return (float(share[0]), float(share[1])), float(size[0] / size[-1]) if size[-1] > 0.0 else float("inf")


def _limits(room: Float) -> Any:
    from symbolic.model import Limits

    return {j: Limits((r[0], r[1]), r[2], r[3]) for j, r in zip(JOINTS, room.tolist(), strict=True)}
