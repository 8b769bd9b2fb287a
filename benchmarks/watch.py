"""How well `exoid watch` does: false alarms per day, rate and delay of detection, right names; and how fast it is.

    python benchmarks/watch.py --motions 6 --runs 40 --quiet-hours 8
    python benchmarks/watch.py --speed

The bench is simulated once per motion (20 minutes, half a minute of CPU each); a run takes one of the motions, the
torque that it takes with the effect from a random moment on, and sensor noise of its own. Quiet runs differ by noise
and motion. The size of an effect is drawn between 0.2 and 1 N·m RMS at the joint that shows most of it; every third
run has "full size", 1 N·m. Beside it, on the same filtered samples: recursive least squares that forgets (60 s) with a
CUSUM on each innovation (its threshold would alarm once a day if innovations were white), the same CUSUM on the
residual of the model fitted first, and `ruptures` on the whole run (PELT, L2, offline, an oracle for *when*). Every
run is one JSON line; the last line sums up.
"""

from __future__ import annotations

import argparse
import json
import time
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.watching.events import Event
from diagnosis.watching.front import FrontEnd, Samples
from diagnosis.watching.watcher import Settings, Watcher
from diagnosis.watching.window import window
from measurement.bench.deflection import at_encoders, rigid_torque
from measurement.bench.equation import split_channel
from measurement.bench.hidden import Hidden, true_model
from measurement.bench.leg import standard_leg
from measurement.bench.sensors import Sensors
from measurement.bench.simulation import Bench, run_bench
from measurement.trajectories.trajectory import Fourier, random_trajectory
from symbolic.catalogue import catalogue
from symbolic.model import Model
from symbolic.motion import Motion

DAY = 86400.0
LEAVE_OUT = ("drift", "base")
"""Families whose effects do not appear at a moment."""
CUSUM = 12.0


def motion(seed: int) -> Fourier:
    """Return a motion that does not repeat for most of a minute."""
    return random_trajectory(np.random.default_rng([seed, 5]), period=47.0, harmonics=24)


@dataclass(frozen=True, eq=False)
class Truth:
    """One motion of the bench: that of the links, and the torque (N, J) it takes without any effect."""

    link: Motion
    torque: np.ndarray

    @classmethod
    def of(cls, seed: int, seconds: float) -> Truth:
        made = run_bench(seed=seed, excitation=motion(seed), bench=Bench(duration=seconds))
        return cls(made.motion, made.torque)

    def rows(self, seed: int, hidden: Hidden | None = None, moment: float = np.inf) -> np.ndarray:
        """Return samples (N, 5) with noise of their own; from `moment` s on with the effect."""
        q, tau = self.link.q, self.torque
        if hidden is not None:
            read, added = self.with_effect(hidden)
            after = self.link.t[:, None] >= moment
            q, tau = np.where(after, read, q), np.where(after, tau + added, tau)
        rng, sensors, rate = np.random.default_rng([seed, 7]), Sensors(), 1.0 / (self.link.t[1] - self.link.t[0])
        scale = np.array(standard_leg().sensor_scale)
        return np.column_stack([self.link.t, sensors.angle(q, rng), sensors.torque(tau, rate, rng, scale)])

    def with_effect(self, hidden: Hidden) -> tuple[np.ndarray, np.ndarray]:
        """Return the angles at the encoders, and what this motion takes more with the effect, both (N, J)."""
        base = standard_leg().base
        true, bare = true_model(Model.standard(), base, (hidden,)), true_model(Model.standard(), base, ())
        mechanical, heard = split_channel(true)
        added = heard.torque(self.link) - bare.torque(self.link)
        seen = at_encoders(true, mechanical, self.link)
        if seen is not self.link:
            sides = (mechanical.torque(at) - rigid_torque(mechanical, at) for at in (seen, self.link))
            added = added + next(sides) - next(sides)
        return seen.q, added


def drawn(rng: np.random.Generator, size: float, truth: Truth) -> Hidden:
    """Return an effect of the catalogue whose torque has `size` N·m RMS at the joint that shows most of it."""
    pool = [
        (effect, joint)
        for effect in catalogue().values()
        if effect.coefficients and effect.family not in LEAVE_OUT
        for joint in ((None,) if effect.on_both else effect.joints)
        if joint not in effect.absorbed_on
    ]
    while True:
        effect, joint = pool[int(rng.integers(len(pool)))]
        one = Hidden(effect, joint)
        rms = float(np.sqrt(np.mean(truth.with_effect(one)[1][:5000] ** 2, axis=0)).max())
        if rms < 1e-3:
            continue
        numbers = true_model(Model.standard(), standard_leg().base, (one,)).numbers()
        values = {
            key: numbers[f"{one.name}.{key}"] * (size / rms if key in effect.coefficients else 1.0)
            for key in (*effect.coefficients, *effect.shape)
        }
        return replace(one, values=values)


class Counted(Watcher):
    """A watcher that counts how often it asked what differs."""

    asked = 0

    def _ask(self, after):
        self.asked += 1
        return super()._ask(after)


def watched(rows: np.ndarray) -> tuple[list[Event], dict]:
    """Return the events of a run, and what it cost."""
    began = time.process_time()
    watcher = Counted(Model.standard())
    events = [e for k in range(0, len(rows), 500) for e in watcher.push(rows[k : k + 500])] + watcher.finish()
    return events, {"cpu": time.process_time() - began, "asked": watcher.asked}


@dataclass(frozen=True, eq=False)
class Filtered:
    """A run as everybody gets it: time (K,), columns (K, J, P), torque (K, J), and which can be used (K, J)."""

    t: np.ndarray
    columns: np.ndarray
    tau: np.ndarray
    use: np.ndarray

    @classmethod
    def of(cls, rows: np.ndarray) -> Filtered:
        front = FrontEnd(2)
        made = Samples.joined([front.push(rows[k : k + 5000]) for k in range(0, len(rows), 5000)])
        one = window("all", made, front.filters.settled, front.filters)
        columns = one.smooth(np.moveaxis(Model.standard().columns(one.motion), 0, 1))
        return cls(one.t, columns, one.tau, one.use)

    def residual(self, learn: float = 120.0) -> np.ndarray:
        """Return the scaled residual (K, J) of least squares fitted to the first `learn` s."""
        first = self.t < learn
        use = self.use[first].ravel()
        x, y = self.columns[first].reshape(-1, self.columns.shape[2])[use], self.tau[first].ravel()[use]
        left = self.tau - self.columns @ np.linalg.lstsq(x, y, rcond=None)[0]
        return np.where(self.use, left / left[first].std(axis=0), 0.0)

    def innovations(self, learn: float = 120.0, memory: float = 60.0) -> np.ndarray:
        """Return the scaled innovations (K, J) of textbook recursive least squares with one forgetting factor."""
        keep = 1.0 - (self.t[1] - self.t[0]) / memory
        numbers, spread = np.zeros(self.columns.shape[2]), 1e4 * np.eye(self.columns.shape[2])
        out = np.zeros(self.tau.shape)
        for k, (rows, tau, use) in enumerate(zip(self.columns, self.tau, self.use, strict=True)):
            for j in np.flatnonzero(use):
                gain = spread @ rows[j]
                gain = gain / (keep + rows[j] @ gain)
                out[k, j] = tau[j] - rows[j] @ numbers
                numbers = numbers + gain * out[k, j]
                spread = (spread - np.outer(gain, rows[j] @ spread)) / keep
        first = (self.t > 0.25 * learn) & (self.t < learn)
        return out / out[first].std(axis=0)


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


def change_run(seed: int, truth: Truth) -> dict:
    """Return what became of one run in which an effect appears."""
    rng = np.random.default_rng([seed, 11])
    size = 1.0 if seed % 3 == 0 else float(np.exp(rng.uniform(np.log(0.2), 0.0)))
    hidden, moment = drawn(rng, size, truth), float(rng.uniform(180.0, truth.link.t[-1] - 120.0))
    rows = truth.rows(seed, hidden, moment)
    rows = rows[rows[:, 0] < moment + 120.0]  # what comes later says nothing about this change
    events, cost = watched(rows)
    alarms = [e for e in events if e.alarm]
    right = [e for e in alarms if e.t >= moment]

    def names(some: list[Event]) -> tuple[set[str], set[str]]:
        found = [d for e in some if e.differences for d in e.differences.found]
        return {d.name for d in found}, {n for d in found for n in d.look_alikes}

    first, last = names(right[:1]), names(right[1:2] or right[:1])
    filtered = Filtered.of(rows)
    left = filtered.residual()
    out = {
        "seed": seed, "effect": hidden.name, "size": size, "full": seed % 3 == 0, "moment": moment, **cost,
        "false": sum(e.t < moment for e in alarms), "delay": right[0].t - moment if right else None,
        "off": abs(right[0].since.t - moment) if right and right[0].since else None,
        "first": sorted(first[0]), "last": sorted(last[0]), "alike": sorted(last[1]),
        "first_right": hidden.name in first[0] | first[1], "exact": hidden.name in last[0],
        "right": hidden.name in last[0] | last[1], "seconds_before": moment,
        "ruptures_off": min((abs(c - moment) for c in oracle(filtered.t, left)), default=None),
    }  # fmt: skip
    for name, signal in (("cusum", left), ("rls", filtered.innovations())):
        times = cusum(filtered.t, signal)
        later = [a for a in times if a >= moment]
        out |= {f"{name}_false": len(times) - len(later), f"{name}_delay": later[0] - moment if later else None}
    return out


def quiet_run(seed: int, truth: Truth) -> dict:
    """Return the false alarms of a run in which nothing changes."""
    rows = truth.rows(10_000 + seed)
    events, cost = watched(rows)
    out = {
        "seed": seed, "quiet": float(rows[-1, 0]), **cost, "alarms": [repr(e) for e in events if e.alarm],
        "motion": sum(e.event == "motion" for e in events),
    }  # fmt: skip
    if seed < 3:
        filtered = Filtered.of(rows)
        out |= {"cusum_false": len(cusum(filtered.t, filtered.residual())),
                "rls_false": len(cusum(filtered.t, filtered.innovations()))}  # fmt: skip
    return out


def summed_up(lines: list[dict]) -> dict:
    """Return the figures of a campaign."""
    runs, quiet = [r for r in lines if "effect" in r], [r for r in lines if "quiet" in r]
    out: dict = {"quiet_hours": sum(r["quiet"] for r in quiet) / 3600.0}
    out["false_alarms_quiet"] = sum(len(r["alarms"]) for r in quiet)
    out["asked_quiet"] = sum(r["asked"] for r in quiet)
    for name, some in (("all", runs), ("full", [r for r in runs if r["full"]])):
        seen = [r for r in some if r["delay"] is not None]
        out[name] = {
            "runs": len(some), "detected": len(seen), "right": sum(r["right"] for r in seen),
            "exact": sum(r["exact"] for r in seen), "first_right": sum(r["first_right"] for r in seen),
            "median_delay": float(np.median([r["delay"] for r in seen])) if seen else None,
            "false": sum(r["false"] for r in some),
            "missed": [(r["effect"], round(r["size"], 2)) for r in some if r["delay"] is None],
            "wrong": [(r["effect"], round(r["size"], 2), r["last"]) for r in seen if not r["right"]],
            "median_off": float(np.median([r["off"] for r in seen if r["off"] is not None])) if seen else None,
            "ruptures_within_20_s": sum((r["ruptures_off"] or np.inf) < 20.0 for r in some),
            "cusum_false": sum(r["cusum_false"] for r in some), "rls_false": sum(r["rls_false"] for r in some),
            "hours_before": sum(r["seconds_before"] for r in some) / 3600.0,
        }  # fmt: skip
    return out


def speed(rate: float = 1000.0) -> dict:
    """Return how many times faster than real time a quiet stretch is watched, once what is usual is known."""
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
    parser.add_argument("--motions", type=int, default=6)
    parser.add_argument("--seconds", type=float, default=1200.0)
    parser.add_argument("--runs", type=int, default=0)
    parser.add_argument("--quiet-hours", type=float, default=0.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--speed", action="store_true")
    args = parser.parse_args()
    if args.speed:
        print(json.dumps(speed()), flush=True)
    quiet = round(args.quiet_hours * 3600.0 / args.seconds)
    pool = [Truth.of(k, args.seconds) for k in range(args.motions if args.runs or quiet else 0)]
    lines = []
    for k in range(args.seed, args.seed + max(args.runs, quiet)):
        for wanted, run in ((args.runs, change_run), (quiet, quiet_run)):
            if k - args.seed < wanted:
                lines.append(run(k, pool[k % len(pool)]))
                print(json.dumps(lines[-1]), flush=True)
    if lines:
        print(json.dumps(summed_up(lines)), flush=True)


if __name__ == "__main__":
    main()
