"""Our own bench, as the blind trials draw its machines, with instruments of several qualities.

KIND[@NOISE]/WHAT/SEED: a kind of `exoid/apps/campaign/trials`, or short (8 s a run); NOISE N·m of the torque sensors
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from benchmarks.arena.task import Run, Sealed, number_of
from exoid.apps.campaign.trials.cases import CONVENTION, PASSIVE, Case, cases, hide, singles, subject
from exoid.apps.campaign.trials.chains import CHAINS
from exoid.apps.campaign.trials.machines import MACHINES, kept_in, without_knee_drive
from exoid.measurement.bench.hidden import Hidden
from exoid.measurement.bench.leg import Leg
from exoid.measurement.bench.sensors import Sensors
from exoid.measurement.bench.simulation import Bench, BenchError, BenchRun, simulate_runs
from exoid.symbolic.effect import Effect

SEED = 5100
"""First seed of the arena: the campaign and the tests draw others."""
MANY = {"single": 24, "small": 16, "pair": 16, "none": 8, "outside": 6, "short": 8, CONVENTION: 5, "drive": 5}
"""Cases of a kind; of others 4."""
NOISES = (0.5, 0.1, 0.02)
"""N·m; effects are smaller by the root of what the noise is smaller: the same ones, and weaker ones, seen better."""
SHORT = 8.0
"""s of a short run."""


def names(other: int = 0) -> list[str]:
    """Return every case of this plant, kind by kind; with `other`, of other machines."""
    out, first = [], SEED + other
    rng = np.random.default_rng(first)
    for kind in ("single", "small", "pair", "none", "outside", "short", *MACHINES, PASSIVE, CONVENTION, *CHAINS):
        if kind == "short":
            drawn = [Case(kind, (str(n),), first) for n in rng.permutation(singles())]
        else:
            drawn = [c for seed in (first, first + 1) for c in cases([kind], 1, seed)]
            drawn = [drawn[int(k)] for k in rng.permutation(len(drawn))]
        varied = kind in ("single", "small", "pair", "none", "drive", "chain")
        for k, case in enumerate(drawn[: MANY.get(kind, 4)]):
            noise = NOISES[k % len(NOISES)] if varied else NOISES[0]
            out.append(case.name.replace("/", f"@{noise:g}/", 1))
    return out


def draw(name: str) -> Sealed:
    """Return the case of this name."""
    head, variants, seed = name.split("/")
    kind, _, size = head.partition("@")
    noise, asked = float(size), Case(kind, () if variants == "nothing" else tuple(variants.split("+")), int(seed))
    case = replace(asked, kind="single") if kind == "short" else asked
    rng = np.random.default_rng(number_of(name))
    model, leg = subject(case, rng)
    hidden = hide(case, model, leg, rng)
    if kind == PASSIVE and isinstance(leg, Leg):
        leg = without_knee_drive(leg)
    usual = Sensors()
    scale = noise / usual.torque_noise
    sensors = replace(
        usual,
        torque_noise=noise,
        outlier_size=usual.outlier_size * scale,
        burst_size=usual.burst_size * scale,
        encoder_noise=usual.encoder_noise * max(scale, 0.1),
    )
    bench = Bench(duration=SHORT if kind == "short" else 30.0, sensors=sensors)
    hidden = tuple(_scaled(h, scale**0.5) for h in hidden)
    while True:
        try:
            runs = list(simulate_runs(5, model, leg, effects=hidden, seed=number_of(name), bench=bench))
            break
        except BenchError:
            hidden = tuple(_scaled(h, 0.7) for h in hidden)
    runs = MACHINES.get(kind, lambda runs, _: list(runs))(runs, rng)
    if kind == CONVENTION:
        runs = kept_in(variants, runs)
    wanted = () if kind == CONVENTION or kind == "outside" else tuple(h.name for h in hidden)
    made = tuple(_run(run, kind) for run in runs)
    return Sealed(model, made, wanted, noise * np.asarray(leg.sensor_scale), kind != CONVENTION)


def _scaled(hidden: Hidden, factor: float) -> Hidden:
    """Return an effect `factor` times as large: its coefficients, or its only number where it has none."""
    assert isinstance(hidden.effect, Effect)
    size = hidden.effect.coefficients or hidden.effect.shape
    return replace(hidden, values={k: v * (factor if k in size else 1.0) for k, v in hidden.values.items()})


def _run(run: BenchRun, kind: str) -> Run:
    """Return a run with the torque that a faultless sensor of that gain would have shown."""
    torque = run.torque
    if kind == "current":
        torque = torque * float(np.sum(run.recording.tau * torque) / np.sum(torque**2))
    return Run(run.recording, run.motion, torque)
