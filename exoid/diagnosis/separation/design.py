"""The next experiment: the motion inside the limits that best distinguishes rival effects.

Each rival in turn is the truth, and every other one is refitted to it with all parameters of the model; the design
maximises the smallest of these distances, in standard deviations of the noise (T-optimality; Atkinson and Fedorov,
Biometrika 62, 1975, here with the minimum over rivals). NFO searches the motions, all of them inside the limits by
construction, with a rough form of the distance; the motion found is then evaluated by full refits. The present
recordings, and a motion drawn at random, are evaluated the same way.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace
from itertools import permutations
from typing import Unpack

import numpy as np

from exoid.diagnosis.separation.distance import Distances, Rival, planned, residual_noise
from exoid.diagnosis.separation.indistinguishable import same_torques
from exoid.diagnosis.separation.result import Separation
from exoid.diagnosis.separation.settings import SeparationOptions, SeparationSettings
from exoid.ground.errors import ExoidError
from exoid.ground.progress import Progress, silent
from exoid.ground.ties import least_of, order_of
from exoid.measurement.bench.simulation import bench_machine
from exoid.measurement.forces import pushed_model
from exoid.measurement.reading.given import Given, question_of
from exoid.measurement.trajectories.extremes import bounds, uses
from exoid.measurement.trajectories.trajectory import Fourier, random_trajectory
from exoid.optimisation.excitation.criteria import Noise
from exoid.optimisation.excitation.design import space_of
from exoid.optimisation.excitation.space import MotionSpace
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.fitting.nominal import nominal
from exoid.optimisation.linear.problem import Problem
from exoid.optimisation.optimiser import minimise
from exoid.optimisation.optimisers.nfo import NFO
from exoid.optimisation.preparation.prepare import Prepared, prepare
from exoid.symbolic.force import Force
from exoid.symbolic.model import Model
from exoid.symbolic.model_file import Numbers
from exoid.symbolic.model_structure import require_still_base
from exoid.symbolic.motion import Float
from exoid.symbolic.term import Term

CUTOFF = 6.0
"""Hz of the filter a designed motion is evaluated with where no recordings choose one."""
USUAL_NOISE = Noise(np.array([0.27, 0.21]), np.array([10.0, 10.0]), "usual on the virtual bench after its 6 Hz filter")
"""Without recordings: what a right model leaves on the bench, measured by `residual_noise` on 3 × 3 runs (0.27 to 0.28
and 0.19 to 0.23 N·m, 8 to 12 independent samples per second)."""
INDIVIDUALS = 20
"""Population of NFO."""
FINALISTS = 4
"""Motions that are evaluated by full refits; the best of them is the design."""
USUAL = 3
"""Motions drawn at random for comparison; their median counts."""


class SeparateError(ExoidError):
    """Rivals that cannot be compared: fewer than two, or the same one twice."""


def separate(
    model: Model,
    rivals: Sequence[str],
    recordings: Given = (),
    settings: SeparationSettings | None = None,
    *,
    progress: Progress | None = None,
    **changes: Unpack[SeparationOptions],
) -> Separation:
    """Return the motion that best distinguishes the `rivals` ("stribeck:hip", ...), and their distances on it.

    `model` is taken without the rivals; `recordings` give the size of each rival, the numbers of the leg, the noise and
    the filter; else `numbers` (a model file's identified ones) or typical sizes are used. Where two rivals make the
    same torque at every state no motion is sought for that pair. Refuses fewer than two rivals and names that do not
    exist.
    """
    began = time.perf_counter()
    model, recordings, _ = question_of(model, recordings)
    say = progress or silent
    asked = SeparationSettings.chosen(settings, changes)
    require_still_base(model, "the design of a motion")
    base, terms = _without(model.unpushed, rivals)
    space = space_of(bounds(model.motion_limits, asked.use), asked, model.joint_names)
    rng = np.random.default_rng([asked.seed, 3])
    drawn = [random_trajectory(rng, model.motion_limits, period=asked.period) for _ in range(USUAL)]
    filter_ = asked.cutoff or CUTOFF
    planned(drawn[0], asked.duration, filter_, joints=model.joints)  # what is too short is told before the search
    say(0.02, "looking for rivals that are the same")
    same = same_torques(base, terms)
    forces = pushed_model(model, recordings).forces
    prepared = prepare(base.with_forces(*forces), recordings, cutoff=asked.cutoff) if recordings else None
    truths, measured = _truths(base, terms, forces, prepared, asked.numbers, say)
    noise = asked.noise or measured or usual_noise(model)
    # All (truth, rival) but those of which the rival can stand for the truth on every motion.
    lost = {(item.first, item.second) for item in same} | {(item.second, item.first) for item in same if item.mutual}
    pairs = [(a, b) for a, b in permutations(truths, 2) if not lost & {(a.name, b.name), (a.name, "")}]
    if prepared is not None:
        filter_ = prepared.choice.cutoff
    measure = Distances(base, tuple(pairs), noise, asked.duration, filter_)
    motion: Fourier | None = None
    apart: dict[tuple[str, str], float] = {}
    if pairs:
        found = _search(space, measure, asked.generations, asked.seed, say)
        say(0.85, "evaluating the motions")
        tried = [(item, measure.motion(item)) for item in found]
        motion, apart = least_of(tried, lambda item: -min(item[1].values()))
    usual = [measure.motion(item) for item in drawn]
    return Separation(
        model=base,
        rivals=tuple(truths),
        same=same,
        trajectory=motion,
        apart=apart,
        present=measure.recordings(prepared.train) if prepared is not None else None,
        present_seconds=sum(len(item.kept) / item.kept_rate for item in prepared.train) if prepared else 0.0,
        usual={pair: float(np.median([entry[pair] for entry in usual])) for pair in apart},
        noise=noise,
        duration=asked.duration,
        cutoff=filter_,
        uses=uses(motion, model.motion_limits) if motion is not None else (),
        seed=asked.seed,
        seconds=time.perf_counter() - began,
    )


def _without(model: Model, rivals: Sequence[str]) -> tuple[Model, tuple[Term, ...]]:
    """Return the model without the rivals, and the rivals as terms of it."""
    rivals = [rivals] if isinstance(rivals, str) else rivals
    base = model.without(*(term.name for term in model.terms if term.name in rivals))
    terms = tuple(base.with_effect(name).terms[-1] for name in rivals)
    names = [term.name for term in terms]
    if len(set(names)) < 2 or len(set(names)) < len(names):
        usual = model.joint_names[0]
        first = names[0] if names else f"stribeck:{usual}"
        effect, _, joint = first.partition(":")
        second = f"{'stribeck' if effect == 'viscous_quadratic' else 'viscous_quadratic'}:{joint or usual}"
        raise SeparateError(
            f"{', '.join(sorted(set(names))) or 'nothing'} is named, but it takes two different effects to compare",
            where="--separate",
            remedy=f"add a second effect: {first},{second}",
        )
    return base, terms


def usual_noise(model: Model) -> Noise:
    """Return the noise that a right model leaves on the virtual bench, where nothing else is known."""
    if not model.chain:
        return USUAL_NOISE
    scale = np.array(bench_machine(model).sensor_scale)
    return Noise(float(USUAL_NOISE.sd[0]) * scale, np.full(scale.shape, 10.0), USUAL_NOISE.source, model.joints)


def _truths(
    base: Model,
    terms: Sequence[Term],
    forces: Sequence[Force],
    prepared: Prepared | None,
    numbers: Numbers | None,
    say: Progress,
) -> tuple[tuple[Rival, ...], Noise | None]:
    """Return every rival with its numbers, and the noise that the best of their fits leaves; the `forces` pushed the
    recordings, and nothing pushes the machine on a motion to come.
    """
    truths, fits = [], []
    for k, term in enumerate(terms):
        model = replace(base, terms=(*base.terms, term))
        usual = nominal(model, numbers)
        if prepared is None:
            names = (*numbers.linear, *numbers.shape) if numbers is not None else ()
            known = any(name.startswith(f"{term.name}.") for name in names)
            source = "identified" if known else "typical size"
            truths.append(Rival(term.name, model, usual.linear, usual.shape, source))
            continue
        say(0.05 + 0.1 * k, f"fitting {term.name} to the recordings")
        pushed = model.with_forces(*forces)
        fit = identify(pushed, prepared.train, optimisers=())
        fits.append(fit)
        at = [pushed.parameters.index(p) for p in model.parameters]
        linear, source = np.array(fit.linear)[at], "fitted to the recordings"
        count = len(base.parameters)
        own = [*zip(linear[count:].tolist(), model.parameters[count:], strict=True)]
        inside = all((p.min is None or v >= p.min) and (p.max is None or v <= p.max) for v, p in own)
        if not inside or (own and not any(v != 0.0 for v, _ in own)):
            linear = np.concatenate([linear[:count], usual.linear[count:]])
            source = "typical size, since its fit has a sign it cannot have"
        truths.append(Rival(term.name, model, linear, np.array(fit.shape), source))
    if not fits or prepared is None:
        return tuple(truths), None
    best = least_of(fits, lambda fit: fit.loss)
    of, rate = best.data, prepared.train[0].kept_rate
    return tuple(truths), residual_noise(best.residual, of.use, of.groups, rate, prepared.choice.cutoff, base.joints)


def _search(space: MotionSpace, measure: Distances, generations: int, seed: int, say: Progress) -> list[Fourier]:
    """Return the motions with the largest smallest distances that NFO finds, best first."""

    def stretched(y: Float) -> list[Fourier]:
        swings, offsets = space.split(y)
        return [space.inside(swing, offset) for swing, offset in zip(swings, offsets, strict=True)]

    def fitness(y: Float) -> Float:
        return np.array([-measure.smallest(item) for item in stretched(y)])

    edge = np.ones(space.size)
    run = minimise(
        Problem(fitness, -edge, edge, space.names, ("1",) * space.size),
        NFO(alpha=0.8, crossover=0.95),
        individuals=INDIVIDUALS,
        generations=generations,
        seed=seed,
        progress=lambda spent, best: say(
            0.3 + 0.5 * spent / (INDIVIDUALS * generations), f"NFO: {np.sqrt(max(-best, 0.0)):.1f} σ apart"
        ),
    )
    last = run.state
    return stretched(np.concatenate([run.x[None], last.x[order_of(last.f)[1:FINALISTS]]]))
