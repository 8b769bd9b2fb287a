"""A blind test: an effect drawn at random from the catalogue, its recordings, and its truth under seal.

Nothing that is written except the seal depends on what was drawn: file names, columns and headers are the
same for every effect, and the noise comes from the seed alone.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from pathlib import Path

import numpy as np

from measurement.bench import Bench, Run, simulate_runs
from measurement.hidden import Hidden
from measurement.leg import Leg
from measurement.recording import write_recording
from measurement.seal import write_seal
from symbolic.effect import Effect, Shape
from symbolic.model import Model

SEAL = "truth.seal"
"""File name of the seal beside blind recordings."""

NOTHING_HIDDEN = 0.1
"""Share of draws in which nothing is hidden, so that "adequate" is a possible answer."""


def draw(
    rng: np.random.Generator, effects: Iterable[Effect], *, nothing: float = NOTHING_HIDDEN
) -> tuple[Hidden, ...]:
    """Return one effect of `effects` at a random joint and size, or () with probability `nothing`.

    Coefficients lie between 0.7 and 1.8 times their typical size, shapes in the inner part of their range.
    """
    pool = [
        (effect, joint)
        for effect in effects
        for joint in ((None,) if effect.on_both else effect.joints)
        if joint not in effect.absorbed_on
    ]
    if not pool or rng.random() < nothing:
        return ()
    effect, joint = pool[int(rng.integers(len(pool)))]
    scale = float(rng.uniform(0.7, 1.8))
    values: dict[str, float] = {}
    for key, coefficient in effect.coefficients.items():
        usual = 1.0 if coefficient.typical is None else coefficient.typical
        signed = (coefficient.min is None or coefficient.min < 0.0) and rng.random() < 0.5
        values[key] = (-1.0 if signed else 1.0) * scale * float(rng.uniform(0.9, 1.1)) * usual
    for key, shape in effect.shape.items():
        values[key] = _shape(rng, shape)
    return (Hidden(effect, joint, values),)


def write_blind(
    folder: str | Path,
    hidden: Iterable[Hidden],
    *,
    count: int = 4,
    model: Model | None = None,
    leg: Leg | None = None,
    seed: int = 0,
    bench: Bench | None = None,
) -> tuple[tuple[Path, ...], Path]:
    """Simulate `count` runs with `hidden` effects into `folder`; return the recordings' paths and the seal's.

    Files are run_0.csv, run_1.csv, ... and `truth.seal`. Raises RecordingError or SealError when they cannot
    be written, and whatever `simulate` raises.
    """
    runs = simulate_runs(count, model, leg, effects=hidden, seed=seed, bench=bench)
    return write_runs(folder, runs)


def write_runs(folder: str | Path, runs: Iterable[Run]) -> tuple[tuple[Path, ...], Path]:
    """Write `runs` of one leg as `<name>.csv` and their truth as `truth.seal` into `folder`; return the
    paths.
    """
    several = tuple(runs)
    paths = tuple(
        write_recording(one.recording, Path(folder) / f"{one.recording.name}.csv") for one in several
    )
    return paths, write_seal(Path(folder) / SEAL, several[0].truth, paths)


def _shape(rng: np.random.Generator, shape: Shape) -> float:
    """Draw a shape value: one of its choices, or between half and twice its typical value inside its bounds.
    """
    if shape.choices:
        return float(shape.choices[int(rng.integers(len(shape.choices)))])
    if shape.spacing == "log" and shape.min > 0:
        low, high = math.log(shape.min), math.log(shape.max)
        return math.exp(low + float(rng.uniform(0.2, 0.8)) * (high - low))
    return shape.min + float(rng.uniform(0.2, 0.8)) * (shape.max - shape.min)
