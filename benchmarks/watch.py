"""How well `exoid watch` does: false alarms per day, rate and delay of detection, right names; and how fast it is.

    python benchmarks/watch.py --quiet-hours 1 --runs 4 --seed 1      (CPU: about 2 min per hour, 1 min per run)
    python benchmarks/watch.py --speed

Runs are of the virtual bench. An effect of the catalogue appears at a random moment: two runs along one motion,
without and with it, are joined there. Its size is drawn between 0.2 and 1 N·m RMS at the joint that shows most of it;
"full size" is 1 N·m. In a quiet run nothing changes. Beside it, least squares on the first two minutes with a CUSUM
per sample (one threshold for all runs, so that it would alarm once a day if residuals were white) and `ruptures`
(PELT, L2, offline, an oracle for *when*) get the residual of the same model.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import replace

import numpy as np

from diagnosis.watching.front import FrontEnd, Samples
from diagnosis.watching.watch import follow
from diagnosis.watching.watcher import Settings
from diagnosis.watching.window import window
from measurement.bench.hidden import Hidden, true_model
from measurement.bench.leg import standard_leg
from measurement.bench.simulation import Bench, run_bench
from measurement.trajectories.trajectory import Fourier, random_trajectory
from symbolic.catalogue import catalogue
from symbolic.model import Model

DAY = 86400.0
LEAVE_OUT = ("drift", "base")
"""Families whose effects do not appear at a moment."""
CUSUM = 12.0


def motion(seed: int) -> Fourier:
    """Return a motion that does not repeat for most of a minute."""
    return random_trajectory(np.random.default_rng([seed, 5]), period=47.0, harmonics=24)


def samples(seconds: float, seed: int, effects: tuple[Hidden, ...] = ()) -> np.ndarray:
    """Return rows (N, 5) of a run of the bench."""
    made = run_bench(effects=effects, seed=seed, excitation=motion(seed), bench=Bench(duration=seconds)).recording
    return np.column_stack([made.t, made.q, made.tau])


def drawn(rng: np.random.Generator, size: float) -> Hidden:
    """Return an effect of the catalogue whose torque has `size` N·m RMS at the joint that shows most of it."""
    pool = [
        (effect, joint)
        for effect in catalogue().values()
        if effect.coefficients and effect.family not in LEAVE_OUT
        for joint in ((None,) if effect.on_both else effect.joints)
        if joint not in effect.absorbed_on
    ]
    leg, path = standard_leg(), motion(0).at(np.arange(0.0, 40.0, 0.02))
    own = true_model(Model.standard(), leg.base, ()).torque(path)
    while True:
        effect, joint = pool[int(rng.integers(len(pool)))]
        one = Hidden(effect, joint)
        true = true_model(Model.standard(), leg.base, (one,))
        rms = float(np.sqrt(np.mean((true.torque(path) - own) ** 2, axis=0)).max())
        if rms < 1e-3:
            continue
        numbers = true.numbers()
        values = {
            key: numbers[f"{one.name}.{key}"] * (size / rms if key in effect.coefficients else 1.0)
            for key in (*effect.coefficients, *effect.shape)
        }
        return replace(one, values=values)


def watched(rows: np.ndarray) -> tuple[list, float]:
    """Return the events of a run and the CPU seconds it took."""
    began = time.process_time()
    return list(follow(Model.standard(), rows)), time.process_time() - began


def residual(rows: np.ndarray, learn: float = 120.0) -> tuple[np.ndarray, np.ndarray]:
    """Return time (K,) and scaled residual (K, J) of least squares fitted to the first `learn` s, filtered alike."""
    front = FrontEnd(2)
    made = Samples.joined([front.push(rows[k : k + 5000]) for k in range(0, len(rows), 5000)])
    one = window("all", made, front.filters.settled, front.filters)
    columns = np.moveaxis(one.smooth(np.moveaxis(Model.standard().columns(one.motion), 0, 1)), 0, 1)
    first = one.t < learn
    use = one.use[first].T.ravel()
    x, y = columns[:, first].reshape(-1, 8)[use], one.tau[first].T.ravel()[use]
    left = one.tau - (columns @ np.linalg.lstsq(x, y, rcond=None)[0]).T
    return one.t, np.where(one.use, left / left[first].std(axis=0), 0.0)


def cusum(t: np.ndarray, left: np.ndarray, learn: float = 120.0) -> list[float]:
    """Return the alarms of a two-sided CUSUM per sample, which starts again after each."""
    high, low, alarms = np.zeros(left.shape[1]), np.zeros(left.shape[1]), []
    for now, r in zip(t, left, strict=True):
        high, low = np.maximum(0.0, high + r - 0.5), np.maximum(0.0, low - r - 0.5)
        if now > learn and max(high.max(), low.max()) > CUSUM:
            alarms.append(float(now))
            high[:], low[:] = 0.0, 0.0
    return alarms


def oracle(t: np.ndarray, left: np.ndarray) -> list[float]:
    """Return where `ruptures` cuts the squared residual."""
    import ruptures

    power = np.log(np.add.reduceat(left**2, np.arange(0, len(left), 25), axis=0) + 1e-3)
    cuts = ruptures.Pelt(model="l2", min_size=5).fit(power).predict(pen=3.0 * np.log(len(power)) * power.var())
    return [float(t[min(25 * c, len(t) - 1)]) for c in cuts[:-1]]


def change_run(seed: int, seconds: float, size: float | None) -> dict:
    """Return what became of one run in which an effect appears."""
    rng = np.random.default_rng([seed, 11])
    size = float(np.exp(rng.uniform(np.log(0.2), 0.0))) if size is None else size
    hidden, moment = drawn(rng, size), float(rng.uniform(150.0, seconds - 90.0))
    before, after = samples(seconds, seed), samples(seconds, seed, (hidden,))
    rows = np.concatenate([before[before[:, 0] < moment], after[after[:, 0] >= moment]])
    events, cpu = watched(rows)
    alarms = [e for e in events if e.alarm]
    right = [e for e in alarms if e.t >= moment]
    named = {n for e in right[:2] for n in e.names}
    alike = {n for e in right[:2] if e.differences for d in e.differences.found for n in d.look_alikes}
    t, left = residual(rows)
    simple = cusum(t, left)
    later = [a for a in simple if a >= moment]
    return {
        "seed": seed, "effect": hidden.name, "size": size, "moment": moment, "cpu": cpu,
        "false": sum(e.t < moment for e in alarms), "delay": right[0].t - moment if right else None,
        "named": sorted(named), "right": hidden.name in named, "alike": hidden.name in alike,
        "cusum_false": len(simple) - len(later), "cusum_delay": later[0] - moment if later else None,
        "ruptures_off": min((abs(c - moment) for c in oracle(t, left)), default=None),
    }  # fmt: skip


def quiet_run(seed: int, seconds: float) -> dict:
    """Return the false alarms of a run in which nothing changes."""
    rows = samples(seconds, seed)
    events, cpu = watched(rows)
    alarms = [e for e in events if e.alarm]
    t, left = residual(rows)
    return {
        "seed": seed, "seconds": seconds, "cpu": cpu, "alarms": [repr(e) for e in alarms],
        "cusum_alarms": len(cusum(t, left)), "motion": sum(e.event == "motion" for e in events),
    }  # fmt: skip


def speed(rate: float = 1000.0) -> dict:
    """Return how many times faster than real time a quiet stretch is watched, once what is usual is known."""
    from diagnosis.watching.watcher import Watcher

    seconds = 400.0
    t = np.arange(0.0, seconds, 1.0 / rate)
    path = motion(1).at(t)
    tau = true_model(Model.standard(), standard_leg().base, ()).torque(path)
    rng = np.random.default_rng(0)
    rows = np.column_stack([t, path.q, tau + 0.5 * rng.standard_normal(tau.shape)])
    watcher = Watcher(Model.standard(), Settings())
    learnt = int(150.0 * rate)
    watcher.push(rows[:learnt])
    began = time.process_time()
    for k in range(learnt, len(rows), 1000):
        watcher.push(rows[k : k + 1000])
    spent = time.process_time() - began
    return {"rate": rate, "times_real_time": (seconds - 150.0) / spent, "events": watcher.counts}


def main() -> None:
    """Run what is asked for; one JSON object per line."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quiet-hours", type=float, default=0.0)
    parser.add_argument("--runs", type=int, default=0)
    parser.add_argument("--seconds", type=float, default=1200.0)
    parser.add_argument("--size", type=float, default=None, help="N·m RMS (default: drawn between 0.2 and 1)")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--speed", action="store_true")
    args = parser.parse_args()
    if args.speed:
        print(json.dumps(speed()), flush=True)
    for k in range(round(args.quiet_hours * 2)):
        print(json.dumps(quiet_run(1000 + args.seed + k, 1800.0)), flush=True)
    for k in range(args.runs):
        print(json.dumps(change_run(args.seed + k, args.seconds, args.size)), flush=True)


if __name__ == "__main__":
    main()
