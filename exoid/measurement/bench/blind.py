"""A blind test: an effect drawn at random from the catalogue, its recordings, and its truth under seal.

Nothing that is written except the seal depends on what was drawn: file names, columns and headers are the
same for every effect, and the noise comes from the seed alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from exoid.measurement.bench.hidden import Hidden, true_model
from exoid.measurement.bench.leg import Leg
from exoid.measurement.bench.machine import Machine
from exoid.measurement.bench.seal import write_seal
from exoid.measurement.bench.simulation import BenchRun, bench_machine
from exoid.measurement.recording import write_recording
from exoid.measurement.trajectories.trajectory import random_trajectory
from exoid.symbolic.effect import Effect, Shape
from exoid.symbolic.model import Model
from exoid.symbolic.term import Term, places_of

SEAL = "truth.seal"
"""File name of the seal beside blind recordings."""

NOTHING_HIDDEN = 0.1
"""Share of draws in which nothing is hidden, so that "adequate" is a possible answer."""

SHARE = (0.04, 0.2)
"""Smallest and largest size of a drawn effect against the torque of the leg it is hidden in."""

MOMENT = (0.0, 20.0)
"""Moments in s that are drawn: within usual recordings."""

TRIALS = 30
"""Attempts to place an effect where the leg moves; an end stop has little chance at a random angle."""


def draw_hidden(
    rng: np.random.Generator,
    effects: Iterable[Effect],
    *,
    leg: Leg | Machine | None = None,
    model: Model | None = None,
    share: tuple[float, float] = SHARE,
    nothing: float = NOTHING_HIDDEN,
    joint: str | None = None,
) -> tuple[Hidden, ...]:
    """Return one effect of `effects` at `joint` (None: a random one), of a size that fits `leg`; () with probability
    `nothing`.

    `model` (the standard leg's) has the joints. Shapes are drawn from the inner part of their range, again until the
    effect acts on a usual motion. Then the coefficients are scaled so that its torque is between `share[0]` and
    `share[1]` of the leg's own (both as standard deviations). An effect without coefficients keeps the size its shape
    gives it.
    """
    model = Model.standard() if model is None else model
    pool = [
        (effect, place)
        for effect in effects
        for place in places_of(effect, model.joints)
        if place not in effect.absorbed_on and joint in (None, place)
    ]
    if not pool or rng.random() < nothing:
        return ()
    leg = bench_machine(model) if leg is None else leg
    effect, joint = pool[int(rng.integers(len(pool)))]
    wanted = math.exp(float(rng.uniform(math.log(share[0]), math.log(share[1]))))
    for _ in range(TRIALS):
        hidden = Hidden(effect, joint, _values(rng, Term(effect, joint, model.joints)))
        usual = relative_size(hidden, leg, model)
        if usual > 1e-4:
            break
    scale = wanted / usual if usual > 1e-4 else 1.0
    values = {key: value * (scale if key in effect.coefficients else 1.0) for key, value in hidden.values.items()}
    if joint is not None and _replaces_coulomb(hidden):
        # Presliding takes the place of dry friction, so there cannot be more of it than the joint has.
        dry = leg.base[len(model.inertial) + 2 * model.joint_names.index(joint)]
        values = {key: min(value, dry) if key in effect.coefficients else value for key, value in values.items()}
    return (Hidden(effect, joint, values),)


def relative_size(hidden: Hidden, leg: Leg | Machine, model: Model | None = None) -> float:
    """Return the standard deviation of the effect's torque over that of the leg's own, on a usual motion.

    Where the effect acts on both joints, the larger of the two ratios.
    """
    model = Model.standard() if model is None else model
    motion = random_trajectory(np.random.default_rng(0), model.motion_limits).at(np.arange(0.0, 20.0, 0.02))
    own = true_model(model, leg.base, ()).torque(motion)
    added = true_model(model, leg.base, (hidden,)).torque(motion) - own
    spread = np.maximum(added.std(axis=0), np.abs(added.mean(axis=0)))
    return float((spread / own.std(axis=0)).max())


def write_runs(folder: str | Path, runs: Iterable[BenchRun]) -> tuple[tuple[Path, ...], Path]:
    """Write `runs` of one leg as `<name>.csv` and their truth as `truth.seal` into `folder`; return the
    paths.
    """
    several = tuple(runs)
    paths = tuple(write_recording(item.recording, Path(folder) / f"{item.recording.name}.csv") for item in several)
    return paths, write_seal(Path(folder) / SEAL, several[0].truth, paths)


def _values(rng: np.random.Generator, term: Term) -> dict[str, float]:
    """Draw coefficients about their typical size, with either sign where both are possible, and shapes."""
    values: dict[str, float] = {}
    sizes = (parameter.typical for parameter in term.parameters)
    for (key, coefficient), typical in zip(term.effect.coefficients.items(), sizes, strict=True):
        usual = 1.0 if typical is None else typical
        signed = (coefficient.min is None or coefficient.min < 0.0) and rng.random() < 0.5
        values[key] = (-1.0 if signed else 1.0) * float(rng.uniform(0.6, 1.4)) * usual + 0.0
    return values | {key: _shape(rng, shape) for key, shape in term.placed_shape.items()}


def _replaces_coulomb(hidden: Hidden) -> bool:
    effect = hidden.effect
    return not isinstance(effect, str) and isinstance(effect.torque, str) and "dahl(" in effect.torque


def _shape(rng: np.random.Generator, shape: Shape) -> float:
    """Draw a shape value: one of its choices, or between half and twice its typical value inside its bounds."""
    if shape.choices:
        return float(shape.choices[int(rng.integers(len(shape.choices)))])
    if shape.spacing == "time":
        return float(rng.uniform(*MOMENT))
    if shape.spacing == "log" and shape.min > 0:
        low, high = math.log(shape.min), math.log(shape.max)
        return math.exp(low + float(rng.uniform(0.2, 0.8)) * (high - low))
    return shape.min + float(rng.uniform(0.2, 0.8)) * (shape.max - shape.min)
