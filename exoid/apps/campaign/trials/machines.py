"""Properties that real machines have and the bench does not: recordings of blind trials made worse, kind by kind.

    rough      an unmodelled smooth torque of 5 to 20 times the noise in its band, another in every run
    current    torques from motor current, with a constant that is wrong by up to a fifth
    uneven     quiet and loud runs in one set: noise and outliers differ by up to a factor of ten
    locked     a run in which the knee is locked
    turns      one joint moves in each run; the other is held, and its friction carries some of its load
    passive    a leg whose knee has no drive, and swings; the effect is one of the hip
    convention recordings that keep another convention than exoid's, named by the case; nothing is hidden

One effect is hidden in each of the others, as in `single`.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType

import numpy as np

from exoid.measurement.bench.leg import Leg
from exoid.measurement.bench.simulation import BenchRun
from exoid.measurement.reading.conventions import combined_map, conventions
from exoid.measurement.signals.conditioning import low_pass
from exoid.symbolic.motion import Float

LEFT = 0.06
"""N·m that the noise of the bench's torque sensor (0.5 N·m at 100 Hz) leaves below SLOW."""
TIMES = (5.0, 20.0)
SLOW = 0.7
"""Hz; model error of real machines follows the motion, which is as slow."""
GAIN = (0.8, 1.2)
LEANT = (-1.5, 1.5)
"""N·m, within the dry friction of the bench's legs."""
NOISE = (0.3, 3.0)
"""Times the noise of the bench that a run of `uneven` has."""


def _with_torque(run: BenchRun, torque: Float) -> BenchRun:
    return replace(run, recording=replace(run.recording, tau=torque))


def _rough(runs: Sequence[BenchRun], rng: np.random.Generator) -> list[BenchRun]:
    size = LEFT * float(np.exp(rng.uniform(*np.log(TIMES))))
    out = []
    for run in runs:
        count, edge = len(run.recording.tau), int(3.0 * run.recording.rate / SLOW)
        slow = low_pass(rng.standard_normal((count + 2 * edge, 2)), SLOW, run.recording.rate)[edge : edge + count]
        out.append(_with_torque(run, run.recording.tau + size * slow / slow.std(axis=0)))
    return out


def _current(runs: Sequence[BenchRun], rng: np.random.Generator) -> list[BenchRun]:
    gain = float(rng.uniform(*GAIN))
    return [_with_torque(run, gain * run.recording.tau) for run in runs]


def _uneven(runs: Sequence[BenchRun], rng: np.random.Generator) -> list[BenchRun]:
    factors = np.exp(rng.permutation(np.linspace(float(np.log(NOISE[0])), float(np.log(NOISE[1])), len(runs))))
    return [
        _with_torque(run, run.torque + factor * (run.recording.tau - run.torque))
        for run, factor in zip(runs, factors, strict=True)
    ]


def _held(run: BenchRun, joint: int, leant: float = 0.0) -> BenchRun:
    """Return a run with a joint held; of its load, friction or a lock carries `leant` N·m more than it should."""
    moving, still = np.arange(2) != joint, np.array(run.motion.q)
    still[:, joint] = still[0, joint]
    rates = {key: getattr(run.motion, key) * moving for key in ("dq", "ddq", "sign")}
    motion = replace(run.motion, q=still, **rates)
    torque = run.true.torque(motion) + leant * ~moving
    noise = run.recording.tau - run.torque
    steps = run.recording.q - run.motion.q
    held = replace(run.recording, q=still + steps, tau=torque + noise)
    return replace(run, recording=held, motion=motion, torque=torque)


def _locked(runs: Sequence[BenchRun], rng: np.random.Generator) -> list[BenchRun]:
    """Return the runs with the knee of the second held: what its lock takes up is nobody's torque."""
    return [runs[0], _held(runs[1], 1), *runs[2:]]


def _turns(runs: Sequence[BenchRun], rng: np.random.Generator) -> list[BenchRun]:
    """Return the runs with hip and knee held by turns, and friction that carries some of what is held."""
    return [_held(run, k % 2, float(rng.uniform(*LEANT))) for k, run in enumerate(runs)]


def without_knee_drive(leg: Leg) -> Leg:
    """Return the leg with a knee motor that gives nothing."""
    return replace(leg, torque_limit=(leg.torque_limit[0], 1e-9))


def kept_in(convention: str, runs: Sequence[BenchRun]) -> list[BenchRun]:
    """Return the runs as a lab would log them that keeps `convention`."""
    to = combined_map(conventions(convention))
    logged = (to.undone(run.recording.q, run.recording.tau) for run in runs)
    pairs = zip(runs, logged, strict=True)
    return [replace(run, recording=replace(run.recording, q=q, tau=tau)) for run, (q, tau) in pairs]


CONVENTION, PASSIVE = "convention", "passive"
CONVENTIONS = (
    "flexion-positive",
    "absolute-shank",
    "hip-from-upright",
    "knee-torque-negated",
    "swapped-joints",
    "flexion-positive,hip-from-horizontal",
    "degrees,flexion-positive",
)
"""Conventions from which those of the trials are drawn."""

MACHINES: Mapping[str, Callable[[Sequence[BenchRun], np.random.Generator], list[BenchRun]]] = MappingProxyType(
    {"rough": _rough, "current": _current, "uneven": _uneven, "locked": _locked, "turns": _turns}
)
"""Kind of trial -> what becomes of its runs."""
