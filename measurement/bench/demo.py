"""The recordings that `exoid demo` ships: a standard leg whose knee friction grows with its load.

Three runs to fit and one to verify, each on a motion of its own. Load-dependent friction is a clear pick:
real gears show it, it is invisible to Coulomb plus viscous friction, and no other entry of the catalogue
looks like it.
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from measurement.bench.blind import write_runs
from measurement.bench.hidden import Hidden
from measurement.bench.simulation import Bench, BenchRun, simulate_runs

SEED = 20
HIDDEN = Hidden("load_friction", "knee", {"c": 0.22})
NAMES = ("train_1", "train_2", "train_3", "verify")
DURATION = 20.0


def demo_runs() -> tuple[BenchRun, ...]:
    """Return the four demo runs; the same numbers on every call."""
    runs = simulate_runs(len(NAMES), effects=[HIDDEN], seed=SEED, bench=Bench(duration=DURATION))
    return tuple(
        replace(one, recording=replace(one.recording, name=name)) for name, one in zip(NAMES, runs, strict=True)
    )


def write_demo(folder: str | Path) -> tuple[Path, ...]:
    """Write the demo's recordings and the seal with their truth into `folder`; return every path written."""
    recordings, seal = write_runs(folder, demo_runs())
    return (*recordings, seal)
