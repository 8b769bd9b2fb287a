"""Motions that tell as much as possible about a leg's numbers: designed, checked, and evaluated.

    θ_i(t) = θ_i0 + Σ_{k=1..K} a_ik sin(kωt) + b_ik cos(kωt)                          (13) of the paper

An optimiser searches the coefficients, 20 individuals × 400 generations in several runs, and each result is refined
(exoid/optimisation/excitation/search.py). IPOPT, started from short searches, is a second opinion. The best of them
is the best motion known; that is no proof of an optimum, since the problem is not convex.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, Unpack

import numpy as np

from exoid.ground.progress import Progress, silent
from exoid.ground.ties import CONVERGED, least_of
from exoid.measurement.trajectories.extremes import FINE, bounds, margin, uses
from exoid.measurement.trajectories.trajectory import Fourier, paper_trajectory
from exoid.optimisation.excitation.criteria import CRITERIA, Aim, Noise, condition, deviations, fisher, log_det
from exoid.optimisation.excitation.result import DesignedMotion, Excitation, Precision
from exoid.optimisation.excitation.search import MotionSearch, NoMotionError
from exoid.optimisation.excitation.settings import DURATION, DesignError, DesignOptions, DesignSettings, MotionSettings
from exoid.optimisation.excitation.space import MotionSpace, motion_space
from exoid.optimisation.fitting.nominal import Nominal, nominal, sizes
from exoid.optimisation.preparation.sticking import STICK
from exoid.symbolic.codegen.information import Information, information
from exoid.symbolic.memory import memory_operations
from exoid.symbolic.model import Model
from exoid.symbolic.model_file import Numbers
from exoid.symbolic.model_structure import Limits, require_still_base
from exoid.symbolic.motion import Float

__all__ = ["DesignError", "NoMotionError", "design", "evaluate", "evaluate_paper"]

GRID = 500
"""Samples per period in a search; its sums differ from those of 4000 by 1e-4, its proof of the limits costs 0.05 %."""
MOST_CREEP = 0.1
"""Share of time in which a joint may creep before that is said."""


def design(
    model: Model | None = None,
    settings: DesignSettings | None = None,
    *,
    progress: Progress | None = None,
    **changes: Unpack[DesignOptions],
) -> Excitation:
    """Return the motion inside the model's limits that is best by a criterion.

    `settings`, or the same names as keywords, say what is wanted. `offsets` is "paper", "middle" or "free";
    a machine that is no leg takes the middle for the paper's. DesignError where no motion is inside the limits or
    determines the model.
    """
    began = time.perf_counter()
    say = progress or silent
    asked = DesignSettings.chosen(settings, changes)
    model = Model.standard() if model is None else model
    require_still_base(model, "the design of a motion")
    free = _said_of_forces(model)
    model = model.unpushed
    search = search_of(model, asked, say)
    found = search.run()
    references: list[DesignedMotion] = []
    if asked.starts > 0 and not asked.printed and not memory_operations(model):
        say(0.6, "IPOPT")
        references = search.reference(asked.starts)
    best = least_of([*found, *references], lambda one: one.value, within=CONVERGED)
    say(0.95, "evaluating the motion")
    cautions = (*free, *_cautions(model, asked))
    room, at = bounds(model.motion_limits, asked.use), nominal(model, asked.numbers)
    task = _Task(model, asked.criterion, room, search.aim, at, asked.offsets, asked.rest, asked.seed)
    return _evaluated(task, best, (*found, *references), cautions, time.perf_counter() - began)


def search_of(model: Model, asked: DesignSettings, say: Progress = silent) -> MotionSearch:
    """Return the search for motions of `model` that are `asked` for."""
    room = bounds(model.motion_limits, asked.use)
    offsets = "middle" if asked.offsets == "paper" and model.chain else asked.offsets
    space = space_of(room, replace(asked, offsets=offsets), model.joint_names)
    at = nominal(model, asked.numbers)
    aim = Aim(sizes(model, at), asked.noise or Noise.white(joints=model.joints), asked.duration)
    info = information(
        model, at.linear, at.shape, space.limits, period=asked.period, harmonics=asked.harmonics, grid=GRID
    )
    return MotionSearch(info, space, aim, asked, say)


def space_of(room: Float, asked: MotionSettings, joints: tuple[str, ...]) -> MotionSpace:
    """Return the motions inside the limits `room` (J, 4) at all times, not only on the grid of a search, and by as much
    as the grid on which a finished motion is evaluated needs to prove it.
    """
    inner = shrunk(room, margin(asked.harmonics, GRID) * margin(asked.harmonics, FINE))
    return motion_space(
        inner, period=asked.period, harmonics=asked.harmonics, offsets=asked.offsets, rest=asked.rest, joints=joints
    )


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
    """Criterion and limits of a given motion, without any search."""
    began = time.perf_counter()
    model = Model.standard() if model is None else model
    require_still_base(model, "the design of a motion")
    model = model.unpushed  # a motion is designed for a machine that nothing pushes
    at = nominal(model, numbers)
    aim = Aim(sizes(model, at), noise or Noise.white(joints=model.joints), duration)
    room = bounds(model.motion_limits, use)
    info = information(
        model, at.linear, at.shape, room,
        period=trajectory.period, harmonics=trajectory.sine.shape[1], grid=GRID,
    )  # fmt: skip
    swing = np.concatenate([trajectory.sine, trajectory.cosine], axis=1)[None]
    value = CRITERIA[criterion](info.sums(swing, trajectory.offset[None], rescale=False).gram, aim)
    motion = DesignedMotion(name, trajectory, float(value[0]), 1, 0.0, "")
    rest = bool(np.abs(np.array([trajectory.at(np.zeros(1)).dq, trajectory.at(np.zeros(1)).ddq])).max() < 1e-9)
    task = _Task(model, criterion, room, aim, at, "given", rest, 0)
    return _evaluated(task, motion, (motion,), (), time.perf_counter() - began)


def evaluate_paper(period: float = 10.0, model: Model | None = None) -> Excitation:
    """Evaluation of the paper's published coefficients at a `period` in s, which the paper does not print."""
    return evaluate(paper_trajectory(period), model, name="the paper's")


def shrunk(room: Float, share: float) -> Float:
    """Return limits (J, 4) drawn in about the middle of each range to `share`: what values on the grid may use."""
    middle, half = 0.5 * (room[:, 0] + room[:, 1]), 0.5 * (room[:, 1] - room[:, 0]) * share
    return np.column_stack([middle - half, middle + half, room[:, 2:] * share])


def _said_of_forces(model: Model) -> tuple[str, ...]:
    """Return that a motion is designed for a machine that nothing pushes, where the forces of `model` are measured."""
    pushed = " and ".join(force.name for force in model.forces)
    return (f"nothing is taken to push the machine meanwhile: the plan has no {pushed}",) if pushed else ()


def _cautions(model: Model, asked: DesignSettings) -> tuple[str, ...]:
    out = []
    if memory_operations(model):
        out.append(
            "operators with a past (play, dahl, delay, lag, ddt) have no formula at an instant: their columns are "
            "computed in Python, the motion is taken to start at rest in its past, and there is no IPOPT reference"
        )
    if any("t" in str(term.effect.torque) and term.effect.family == "drift" for term in model.terms):
        out.append("an effect that drifts with time is evaluated over one period, from its start")
    choices = [s.name for s in model.shapes if s.shape.choices]
    if choices:
        out.append(f"held as they are, since they are choices and have no derivative: {', '.join(choices)}")
    return tuple(out)


@dataclass(frozen=True, eq=False)
class _Task:
    """The question of a design: the model at its numbers `at`, what is best, inside which limits `room` (J, 4)."""

    model: Model
    criterion: str
    room: Float
    aim: Aim
    at: Nominal
    offsets: str
    rest: bool
    seed: int


def _evaluated(
    task: _Task,
    best: DesignedMotion,
    candidates: tuple[DesignedMotion, ...],
    cautions: tuple[str, ...],
    seconds: float,
) -> Excitation:
    """Return the result, every figure of merit computed anew for the motion chosen."""
    motion, model, at, aim = best.trajectory, task.model, task.at, task.aim
    info = information(
        model, at.linear, at.shape, task.room, period=motion.period, harmonics=motion.sine.shape[1], grid=2 * GRID
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
        parts = zip(model.joint_names, creeping, strict=True)
        shares = " and ".join(f"{joint} {100 * part:.0f} %" for joint, part in parts)
        cautions = (
            *cautions,
            f"slower than {STICK:g} rad/s for {shares} of the time, where a real joint may stick and a fit leaves "
            f"samples out; without them cond(Ȳ) is {moving:.1f}",
        )
    lost = [p.name for p in precision if not np.isfinite(p.deviation)]
    if lost:
        cautions = (*cautions, f"this motion carries no information on {', '.join(lost)} individually")
    return Excitation(
        model=model,
        trajectory=motion,
        criterion=task.criterion,
        value=best.value,
        condition=float(condition(gram)[0]),
        log_det=float(log_det(known)[0]),
        candidates=candidates,
        chosen=best.name,
        uses=uses(motion, _limits(task.room, model.joint_names)),
        precision=precision,
        noise=aim.noise,
        duration=aim.duration,
        numbers=at.source,
        offsets=task.offsets,
        rest=task.rest,
        backend=info.backend,
        seed=task.seed,
        creeping=creeping,
        condition_moving=moving,
        cautions=cautions,
        seconds=seconds,
    )


def _without_creep(info: Information, motion: Fourier) -> tuple[tuple[float, ...], float]:
    """Return the share of time each joint may stick, and cond(Ȳ) of the other samples."""
    along = motion.at(info.times)
    slow = np.abs(along.dq) < STICK * np.array([joint.reach for joint in info.model.joints])
    rows = info.sensitivities(along)
    kept = np.concatenate([rows[j][~slow[:, j]] for j in range(len(rows))])
    size = np.linalg.svd(kept, compute_uv=False)
    share = slow.mean(axis=0)
    moving = float(size[0] / size[-1]) if size.size and size[-1] > 0.0 else float("inf")
    return tuple(map(float, share)), moving


def _limits(room: Float, joints: Sequence[str]) -> Any:
    return {j: Limits((r[0], r[1]), r[2], r[3]) for j, r in zip(joints, room.tolist(), strict=True)}
