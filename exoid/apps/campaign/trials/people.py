"""Legs of blind trials that a person wears, or that walk: what pushes them, and what their recordings have of it.

walk_plate      walks; a force plate measures the ground
walk_switch     walks; a foot switch says when the foot is on the ground
walk_nothing    walks; nothing is measured: that something pushes in part of the time is the answer
worn_cuffs      on a stand, a person in it who pushes; cuffs measure how
worn_nothing    the same, and nothing is measured: that something is left that no effect explains is the answer

An effect is hidden in each, or nothing. Paces, loads, and where cuffs and foot are differ from leg to leg.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from exoid.measurement.bench.simulation import Bench, BenchRun
from exoid.measurement.bench.walk import Walk
from exoid.measurement.bench.wearer import Wearer
from exoid.measurement.recording import Recording
from exoid.measurement.selection import swings


def _walk(rng: np.random.Generator) -> Bench:
    steps = Walk(stride=rng.uniform(1.2, 1.8), load=rng.uniform(150.0, 300.0), foot=rng.uniform(0.39, 0.47))
    return Bench(walk=steps)


def _worn(rng: np.random.Generator) -> Bench:
    size = rng.uniform(0.5, 1.5)
    reach = float(rng.uniform(0.2, 0.32)), float(rng.uniform(0.15, 0.3))
    return Bench(wearer=Wearer((20.0 * size, 14.0 * size), rng.uniform(2.0, 4.0), reach))


PEOPLE: Mapping[str, tuple[Callable[[np.random.Generator], Bench], tuple[str, ...]]] = MappingProxyType({
    "walk_plate": (_walk, ("plate",)),
    "walk_switch": (_walk, ("switch",)),
    "walk_nothing": (_walk, ()),
    "worn_cuffs": (_worn, ("cuffs",)),
    "worn_nothing": (_worn, ()),
})  # fmt: skip
"""Kind of trial -> how its bench is drawn, and what of what pushes is measured."""
UNMEASURED = tuple(kind for kind, (_, measured) in PEOPLE.items() if not measured)
"""Kinds in which what pushes is not known at all."""
WALKING = tuple(kind for kind, (draw, _) in PEOPLE.items() if draw is _walk)
SUSPECTED = "outside the model pushes"
"""What has to be said of a walk whose ground nobody measured."""


def bench_of(kind: str, rng: np.random.Generator) -> Bench:
    """Return the bench of a case of one of PEOPLE, drawn."""
    drawn, measured = PEOPLE[kind]
    return replace(drawn(rng), measured=measured)


def as_read(runs: Sequence[BenchRun]) -> list[Recording]:
    """Return the recordings of `runs` as they are read from files: stance is left out where a switch alone knows it."""
    return [swings(run.recording) for run in runs]


def as_measured(runs: Sequence[BenchRun]) -> list[Recording]:
    """Return the recordings of `runs` with everything that pushes in them."""
    channels = runs[0].true.model.channels
    forces = [dict(zip(channels, run.motion.force.T, strict=True)) for run in runs if run.motion.force is not None]
    return [replace(run.recording, forces=own) for run, own in zip(runs, forces, strict=True)]
