"""Which torque samples are hidden as spikes: of good ones how many, of spikes of eight standard deviations how many.

    python benchmarks/spikes.py                        every kind of recording, rate and noise
    python benchmarks/spikes.py bench --rates 100 --noise 0.005 0.05

Kinds: `bench`, one joint with exact angles and each of several effects; `leg`, the bench's leg with the usual encoders;
`reversing`, one joint that turns back four times a second, with Stribeck friction; `mujoco`, the leg of
`mujoco_leg.py` (extra `peers`). One sample in a hundred gets a spike, of eight deviations of the sensor's noise and the
drive's own roughness together. Judged beside the model that lacks the effect, as
everything is prepared, and anew beside the model that has it, fitted, as after an effect was found. Of several effects
the worst counts.
"""

from __future__ import annotations

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from benchmarks import mujoco_leg  # noqa: E402 - the repository must be on the path first
from exoid.diagnosis.evidence.fitted import fitted_model  # noqa: E402
from exoid.measurement.bench.hidden import parse_hidden  # noqa: E402
from exoid.measurement.bench.leg import standard_leg  # noqa: E402
from exoid.measurement.bench.sensors import Sensors  # noqa: E402
from exoid.measurement.bench.simulation import Bench, simulate_runs  # noqa: E402
from exoid.measurement.recording import Recording  # noqa: E402
from exoid.measurement.signals.conditioning import quiet_noise  # noqa: E402
from exoid.optimisation.fitting.identify import identify  # noqa: E402
from exoid.optimisation.preparation.prepare import Prepared, prepare  # noqa: E402
from exoid.symbolic.joints import Joint  # noqa: E402
from exoid.symbolic.model import Model  # noqa: E402
from exoid.symbolic.motion import Float, Motion  # noqa: E402

SIZE, SHARE = 8.0, 0.01
"""Standard deviations of the noise of a spike, and share of samples that are one."""
RUNS, SECONDS = 2, 20.0
RATES, NOISE = (100.0, 500.0, 1000.0), (0.005, 0.02, 0.1, 0.5)
AXIS = Model("bench", joints=(Joint("axis"),))
RIGID = (0.3, 3.0, 1.2, 0.5)
"""Of the one joint: inertia, weight, Coulomb and viscous friction."""
EFFECTS: dict[str, tuple[tuple[float, ...], tuple[float, ...]]] = {
    "viscous_quadratic": ((0.4,), ()),
    "viscous_cubic": ((0.2,), ()),
    "torque_ripple": ((0.3, 0.2), (20.0,)),
    "end_stop": ((20.0,), (0.9, 1.0)),
    "stribeck": ((0.8,), (0.15,)),
    "load_friction": ((0.1,), ()),
}
"""Coefficients and shape values of the effects of the one joint."""
ON_THE_LEG = ("torque_ripple:knee", "stribeck:hip", "end_stop:hip")


@dataclass(frozen=True, eq=False)
class Case:
    """Recordings without noise of the torque, the model that lacks an effect and the one that has it."""

    lacking: Model
    whole: Model
    clean: tuple[Recording, ...]


def one_joint(effect: str, rate: float, paces: tuple[float, float]) -> Case:
    """Return one joint in smooth motion, with exact angles."""
    whole = AXIS.with_effect(f"{effect}:axis")
    linear, shape = (np.array(part) for part in ((*RIGID, *EFFECTS[effect][0]), EFFECTS[effect][1]))
    runs = []
    for k in range(RUNS):
        t, parts = np.arange(0.0, SECONDS, 1.0 / rate), np.zeros((3, round(SECONDS * rate), 1))
        for size, pace, phase in ((0.8, paces[0] + 0.2 * k, 0.0), (0.4, paces[1] - 0.3 * k, float(k))):
            sine, cosine = np.sin(pace * t + phase), np.cos(pace * t + phase)
            parts[:, :, 0] += size * np.array([sine, pace * cosine, -(pace**2) * sine])
        tau = whole.torque(Motion(t, *parts), linear, shape if shape.size else None)
        runs.append(Recording(f"run_{k}", t, parts[0], tau, joints=AXIS.joints))
    return Case(AXIS, whole, tuple(runs))


def bench(rate: float) -> Iterator[Case]:
    yield from (one_joint(effect, rate, (2.0, 5.1)) for effect in EFFECTS)


def reversing(rate: float) -> Iterator[Case]:
    yield one_joint("stribeck", rate, (9.0, 13.1))


def leg(rate: float) -> Iterator[Case]:
    machine = standard_leg()
    sensors = replace(Sensors.ideal(), encoder_bits=17, encoder_noise=6e-5)
    settings = Bench(duration=SECONDS, rate=rate, sensors=sensors)
    lacking = Model.standard(thigh_length=machine.thigh_length)
    for effect in ON_THE_LEG:
        hidden = parse_hidden(effect)
        runs = simulate_runs(RUNS, lacking, machine, effects=[hidden], seed=3, bench=settings)
        yield Case(lacking, lacking.with_effect(effect), tuple(run.recording for run in runs))


def mujoco(rate: float) -> Iterator[Case]:
    every, mujoco_leg.EVERY = mujoco_leg.EVERY, round(1.0 / (rate * mujoco_leg.STEP))
    try:
        pairs = [mujoco_leg.simulate(mujoco_leg.Leg(stop=-1.35), 1, k, SECONDS) for k in range(RUNS)]
    except ImportError:
        return
    finally:
        mujoco_leg.EVERY = every
    lacking = Model.standard()
    clean = tuple(replace(seen, tau=known[3]) for seen, known in pairs)
    yield Case(lacking, lacking.with_effect("end_stop:knee"), clean)


KINDS: dict[str, Callable[[float], Iterator[Case]]] = {
    "bench": bench,
    "leg": leg,
    "reversing": reversing,
    "mujoco": mujoco,
}


def noisy(case: Case, noise: float) -> tuple[list[Recording], list[np.ndarray]]:
    """Return the recordings with white noise and spikes of the torque, and where (N, J) these are."""
    recordings, places = [], []
    for k, run in enumerate(case.clean):
        rng = np.random.default_rng([k, 7])
        hit = rng.random(run.tau.shape) < SHARE
        own = quiet_noise(run.tau, run.rate, 0.5 * run.rate)  # a drive that feels its encoders is rough itself
        size = SIZE * np.hypot(noise, own)
        spikes = np.where(hit, size * rng.choice([-1.0, 1.0], hit.shape), 0.0)
        recordings.append(replace(run, tau=run.tau + noise * rng.standard_normal(hit.shape) + spikes))
        places.append(hit)
    return recordings, places


def shares(prepared: Prepared, places: Sequence[np.ndarray]) -> tuple[float, float]:
    """Return the shares of good samples that are hidden and of spikes that are found, of those not hidden anyhow."""
    good, found = [], []
    for one, hit in zip(prepared.train, places, strict=True):
        assert one.read is not None
        factor = round(one.full_rate / one.rate)
        lost, spoilt = (np.repeat(x, factor, axis=0)[: len(hit)] for x in (one.lost, one.spikes))
        hidden = one.read.brief if factor > 1 else spoilt
        known = ~lost[: len(hidden)]
        good.append(hidden[known & ~hit[: len(hidden)]])
        found.append((hidden | spoilt[: len(hidden)])[known & hit[: len(hidden)]])
    hidden_anyhow = float(np.mean(np.concatenate(good)))
    if factor > 1:
        hidden_anyhow += float(np.mean(np.concatenate([one.spikes[~one.lost] for one in prepared.train])))
    return hidden_anyhow, float(np.mean(np.concatenate(found)))


def measured(case: Case, noise: float) -> Float:
    """Return both shares beside the model that lacks the effect, and beside the one that has it, (4,)."""
    recordings, places = noisy(case, noise)
    prepared = prepare(case.lacking, recordings)
    fit = identify(case.whole, prepared.train, optimisers=())
    return np.array([*shares(prepared, places), *shares(fitted_model(fit, prepared).judged_anew(), places)])


def main(arguments: Sequence[str] | None = None) -> int:
    text, _, rest = (__doc__ or "").partition("\n\n")
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=text, epilog=rest, formatter_class=form)
    parser.add_argument("kinds", nargs="*", help=f"of: {', '.join(KINDS)}")
    parser.add_argument("--rates", type=float, nargs="+", default=RATES)
    parser.add_argument("--noise", type=float, nargs="+", default=NOISE)
    given = parser.parse_args(arguments)
    print("| recording | Hz | noise, N·m | good samples hidden | spikes found | anew: hidden | found |")
    print("|---|---|---|---|---|---|---|")
    for kind in given.kinds or KINDS:
        for rate in given.rates:
            cases = list(KINDS[kind](rate))
            for noise in given.noise if cases else ():
                all_of = np.array([measured(case, noise) for case in cases])
                hidden, found = all_of[:, 0::2].max(axis=0), all_of[:, 1::2].min(axis=0)
                cells = (f"{100 * x:.2f} %" for pair in zip(hidden, found, strict=True) for x in pair)
                print(f"| {kind} | {rate:g} | {noise:g} | {' | '.join(cells)} |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
