"""How well `exoid watch` does: false alarms per day, rate and delay of detection, right names; and how fast it is.

    python benchmarks/watch.py --motions 6 --runs 40 --quiet-hours 8
    python benchmarks/watch.py --speed
    python benchmarks/watch.py --memory-hours 24 [--changes]

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
import resource
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import butter, sosfiltfilt

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from diagnosis.watching.events import Event
from diagnosis.watching.front import CUTOFF, FrontEnd, Samples
from diagnosis.watching.result import Differences
from diagnosis.watching.watcher import Settings, Watcher
from diagnosis.watching.window import Window, window
from measurement.bench.deflection import at_encoders, rigid_torque
from measurement.bench.equation import split_channel
from measurement.bench.hidden import Hidden, true_model
from measurement.bench.leg import standard_leg
from measurement.bench.sensors import Sensors
from measurement.bench.simulation import Bench, run_bench
from measurement.trajectories.trajectory import Fourier, random_trajectory
from symbolic.catalogue import catalogue
from symbolic.mechanics.payload import LINKS, Payload
from symbolic.model import Model
from symbolic.motion import Motion
from symbolic.quantity import Estimate

HOUR = 3600.0
LEAVE_OUT = ("drift", "base")
"""Families whose effects do not appear at a moment."""
CUSUM = 12.0
PERIOD = 47.0
"""s after which a motion repeats."""
STREAM = 2.0 * 3600.0
"""s of a stream in which nothing changes."""


def motion(seed: int) -> Fourier:
    """Return a motion that does not repeat for most of a minute."""
    return random_trajectory(np.random.default_rng([seed, 5]), period=PERIOD, harmonics=24)


@dataclass(frozen=True, eq=False)
class Truth:
    """One motion of the bench: that of the links, and the torque (N, J) it takes without any effect."""

    link: Motion
    torque: np.ndarray

    @classmethod
    def of(cls, seed: int, seconds: float, folder: Path | None = None) -> Truth:
        """Simulate motion number `seed`, or take it from `folder`, where it is kept."""
        kept = None if folder is None else folder / f"motion_{seed}_{seconds:g}.npz"
        if kept is not None and kept.exists():
            with np.load(kept) as found:
                return cls(Motion(*(found[name] for name in ("t", "q", "dq", "ddq", "sign"))), found["torque"])
        made = run_bench(seed=seed, excitation=motion(seed), bench=Bench(duration=seconds))
        if kept is not None:
            m = made.motion
            kept.parent.mkdir(parents=True, exist_ok=True)
            np.savez(kept, t=m.t, q=m.q, dq=m.dq, ddq=m.ddq, sign=m.sign, torque=made.torque)
        return cls(made.motion, made.torque)

    def repeated(self, seconds: float) -> Truth:
        """Return whole periods of the motion again and again, `seconds` long in all."""
        m, step = self.link, self.link.t[1] - self.link.t[0]
        once = round(int(self.link.t[-1] / PERIOD) * PERIOD / step)
        at = np.arange(round(seconds / step)) % once
        return Truth(Motion(step * np.arange(len(at)), m.q[at], m.dq[at], m.ddq[at], m.sign[at]), self.torque[at])

    def part(self, first: int, last: int) -> Truth:
        """Return the samples from `first` to before `last`, their time from zero on."""
        m, at = self.link, slice(first, last)
        return Truth(Motion(m.t[at] - m.t[first], m.q[at], m.dq[at], m.ddq[at], m.sign[at]), self.torque[at])

    def rows(self, seed: int, change: Change | None = None, moment: float = np.inf) -> np.ndarray:
        """Return samples (N, 5) with noise of their own; from `moment` s on with the change."""
        q, tau = self.link.q, self.torque
        if change is not None:
            after = self.link.t[:, None] >= moment
            q, tau = np.where(after, change.q, q), np.where(after, tau + change.added, tau)
        rng, sensors, rate = np.random.default_rng([seed, 7]), Sensors(), 1.0 / (self.link.t[1] - self.link.t[0])
        scale = np.array(standard_leg().sensor_scale)
        return np.column_stack([self.link.t, sensors.angle(q, rng), sensors.torque(tau, rate, rng, scale)])


@dataclass(frozen=True, eq=False)
class Change:
    """What appears in a run: its name, the angles that are read from then on and what the torque is more, (N, J).

    `numbers` are by how much which of its numbers change, none where a shape that is not told decides that as well.
    """

    name: str
    q: np.ndarray
    added: np.ndarray
    numbers: dict[str, float]


def with_effect(truth: Truth, hidden: Hidden) -> tuple[Change, float]:
    """Return what `hidden` changes of this motion, and the RMS in N·m by which the base model then misses the torque.

    That is of the joint that misses most, at the angles that are read and below the cut-off: what the controller
    chatters is seen by nobody.
    """
    base = standard_leg().base
    true, bare = true_model(Model.standard(), base, (hidden,)), true_model(Model.standard(), base, ())
    mechanical, heard = split_channel(true)
    added = heard.torque(truth.link) - bare.torque(truth.link)
    seen = at_encoders(true, mechanical, truth.link)
    if seen is not truth.link:
        sides = (mechanical.torque(at) - rigid_torque(mechanical, at) for at in (seen, truth.link))
        added = added + next(sides) - next(sides)
    missed = truth.torque + added - bare.torque(seen)
    missed -= truth.torque - bare.torque(truth.link)  # what the motion takes more by its own steps in time
    effect = true.model.terms[-1].effect
    told = {} if effect.shape and effect.coefficients else {k: float(v) for k, v in hidden.values.items()}
    return Change(hidden.name, seen.q, added, told), visible(missed, truth.link.t)


def visible(torque: np.ndarray, t: np.ndarray) -> float:
    """Return the RMS of a torque (N, J) N·m below the cut-off, at the joint where it is largest."""
    low = sosfiltfilt(butter(4, CUTOFF, fs=1.0 / (t[1] - t[0]), output="sos"), torque, axis=0)
    return float(np.sqrt(np.mean(low**2, axis=0)).max())


def sized(truth: Truth, one: Hidden, size: float) -> Change | None:
    """Return the effect for which the base model misses `size` N·m; None where that is beyond its bounds."""
    entries = one.effect.coefficients or dict([*one.effect.shape.items()][:1])
    numbers = true_model(Model.standard(), standard_leg().base, (one,)).numbers()
    values = {key: numbers[f"{one.name}.{key}"] for key in (*one.effect.coefficients, *one.effect.shape)}
    short = truth.part(0, 6000)
    for _ in range(6):
        rms = with_effect(short, replace(one, values=values))[1]
        if rms < 1e-3:
            return None
        values |= {key: values[key] * size / rms for key in entries}
    if not all(
        (e.min is None or e.min <= values[k]) and (e.max is None or values[k] <= e.max) for k, e in entries.items()
    ):
        return None
    return with_effect(truth, replace(one, values=values))[0]


def drawn(rng: np.random.Generator, size: float, truth: Truth) -> Change:
    """Return an effect of the catalogue, another friction or a load, for which the base model misses `size` N·m RMS."""
    model = Model.standard()
    numbers = [p.name for p in model.parameters[len(model.inertial) :]]
    pool: list[Any] = [
        (effect, joint)
        for effect in catalogue().values()
        if effect.family not in LEAVE_OUT
        for joint in ((None,) if effect.on_both else effect.joints)
        if joint not in effect.absorbed_on
    ]
    pool += [*numbers, *LINKS]
    while True:
        one = pool[int(rng.integers(len(pool)))]
        if isinstance(one, tuple):
            found = sized(truth, Hidden(*one), size)
            if found is not None:
                return found
            continue
        step = np.zeros(len(model.parameters))
        if one in numbers:
            step[[p.name for p in model.parameters].index(one)] = 1.0
        else:
            step[: len(model.inertial)] = Payload(1.0, float(rng.uniform(0.1, 0.4)), one).numbers(model.thigh_length)
        added = (model.columns(truth.link) @ step).T
        factor = size / visible(added, truth.link.t)
        name = one if one in numbers else f"payload:{one}"
        return Change(name, truth.link.q, factor * added, {one: factor} if one in numbers else {})


class Counted(Watcher):
    """A watcher that counts how often it asked what differs, and the s of CPU that this took."""

    asked, spent = 0, 0.0

    def _ask(self, after: Sequence[Window], most: int = 1) -> Differences:
        began = time.process_time()
        found = super()._ask(after, most)
        self.asked += 1
        self.spent += time.process_time() - began
        return found


def watched(rows: np.ndarray, moment: float = np.inf) -> tuple[list[Event], dict]:
    """Return the events of a run, what it cost, and how many of the model's numbers are inside their intervals: those
    that were told first, and those of the estimator at `moment` or at the end.
    """
    began, truth = time.process_time(), standard_leg().base
    watcher, events, held = Counted(Model.standard()), [], 0

    def inside(estimates: Sequence[Estimate]) -> int:
        return sum(e.low <= x <= e.high for e, x in zip(estimates, truth, strict=True))

    for k in range(0, len(rows), 500):
        if (
            rows[min(k + 499, len(rows) - 1), 0] < moment
            and watcher.estimator is not None
            and rows[k, 0] > moment - 10.0
        ):
            held = inside(watcher.estimator.estimates())
        events += watcher.push(rows[k : k + 500])
    if np.isinf(moment):
        held = inside(watcher.estimator.estimates())
    cost = {"cpu": time.process_time() - began, "asked": watcher.asked, "cpu_asked": watcher.spent}
    first = next(e for e in events if e.event == "reference")
    return events + watcher.finish(), cost | {"held": held, "held_first": inside(first.estimates), "of": len(truth)}


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
    """Return what became of one run in which something changes."""
    rng = np.random.default_rng([seed, 11])
    size = 1.0 if seed % 3 == 0 else float(np.exp(rng.uniform(np.log(0.2), 0.0)))
    change, moment = drawn(rng, size, truth), float(rng.uniform(180.0, truth.link.t[-1] - 120.0))
    rows = truth.rows(seed, change, moment)
    rows = rows[rows[:, 0] < moment + 120.0]  # what comes later says nothing about this change
    events, cost = watched(rows, moment)
    alarms = [e for e in events if e.alarm]
    later = [e for e in alarms if e.t >= moment]
    named = [e for e in later if e.names and e.kind != "over"]

    def names(some: list[Event]) -> tuple[set[str], set[str]]:
        found = [d for e in some for d in e.differences.found]
        return {d.name for d in found}, {n for d in found for n in d.look_alikes}

    first, last = names(named[:1]), names(named[-1:])
    filtered = Filtered.of(rows)
    left = filtered.residual()
    out = {
        "seed": seed, "effect": change.name, "size": size, "full": seed % 3 == 0, "moment": moment, **cost,
        "false": len(alarms) - len(later), "delay": later[0].t - moment if later else None,
        "delay_name": named[0].t - moment if named else None,
        "said": [(round(e.t - moment, 1), e.event, e.kind, e.names, e.more.get("nearest")) for e in later],
        "last": sorted(last[0]), "alike": sorted(last[1]),
        "first_right": change.name in first[0] | first[1], "exact": change.name in last[0],
        "right": change.name in last[0] | last[1],
        "since": [x - moment for x in (named[-1].since.low, named[-1].since.t, named[-1].since.high)]
        if named and named[-1].since else None,
        "sizes": [
            bool(e.low <= change.numbers[e.name] <= e.high)
            for d in (named[-1].differences.found if named else ()) if d.name == change.name
            for e in d.change if e.name in change.numbers
        ],
        "seconds_before": moment,
        "ruptures_off": min((abs(c - moment) for c in oracle(filtered.t, left)), default=None),
    }  # fmt: skip
    for name, signal in (("cusum", left), ("rls", filtered.innovations())):
        times = cusum(filtered.t, signal)
        caught = [a for a in times if a >= moment]
        out |= {f"{name}_false": len(times) - len(caught), f"{name}_delay": caught[0] - moment if caught else None}
    return out


def quiet_run(seed: int, truth: Truth) -> dict:
    """Return the false alarms of a run in which nothing changes."""
    rows = truth.repeated(STREAM).rows(10_000 + seed)
    events, cost = watched(rows)
    out = {
        "seed": seed, "quiet": float(rows[-1, 0]), **cost, "alarms": [repr(e) for e in events if e.alarm],
        "motion": sum(e.event == "motion" for e in events),
    }  # fmt: skip
    if seed < 3:
        filtered = Filtered.of(rows[rows[:, 0] < HOUR])
        out |= {"cusum_false": len(cusum(filtered.t, filtered.residual())),
                "rls_false": len(cusum(filtered.t, filtered.innovations()))}  # fmt: skip
    return out


def summed_up(lines: list[dict]) -> dict:
    """Return the figures of a campaign."""
    runs, quiet = [r for r in lines if "effect" in r], [r for r in lines if "quiet" in r]
    out: dict = {"quiet_hours": sum(r["quiet"] for r in quiet) / HOUR}
    out["false_alarms_quiet"] = sum(len(r["alarms"]) for r in quiet)
    out["asked_quiet"] = sum(r["asked"] for r in quiet)
    out["numbers"] = sum(r["of"] for r in lines)
    out["numbers_inside"], out["numbers_inside_first"] = (sum(r[k] for r in lines) for k in ("held", "held_first"))
    sizes = {"all": runs, "full": [r for r in runs if r["full"]]}
    for low, high in ((0.2, 0.35), (0.35, 0.6), (0.6, 1.0)):
        sizes[f"{low:g} to {high:g}"] = [r for r in runs if not r["full"] and low <= r["size"] < high]
    for name, some in sizes.items():
        seen = [r for r in some if r["delay"] is not None]
        named = [r for r in seen if r["delay_name"] is not None]
        since = [r["since"] for r in named if r["since"]]
        out[name] = {
            "runs": len(some), "detected": len(seen), "named": len(named), "right": sum(r["right"] for r in named),
            "exact": sum(r["exact"] for r in named), "first_right": sum(r["first_right"] for r in named),
            "look_alikes": float(np.median([len(r["alike"]) for r in named])) if named else None,
            "median_delay": float(np.median([r["delay"] for r in seen])) if seen else None,
            "median_delay_name": float(np.median([r["delay_name"] for r in named])) if named else None,
            "false": sum(r["false"] for r in some), "hours_before": sum(r["seconds_before"] for r in some) / HOUR,
            "missed": [(r["effect"], round(r["size"], 2)) for r in some if r["delay"] is None],
            "nameless": [(r["effect"], round(r["size"], 2)) for r in seen if r["delay_name"] is None],
            "wrong": [(r["effect"], round(r["size"], 2), r["last"]) for r in named if not r["right"]],
            "since_inside": sum(low <= 0.0 <= high for low, _, high in since), "since": len(since),
            "median_off": float(np.median([abs(s[1]) for s in since])) if since else None,
            "sizes_inside": sum(sum(r["sizes"]) for r in named), "sizes": sum(len(r["sizes"]) for r in named),
            "ruptures_within_20_s": sum((r["ruptures_off"] or np.inf) < 20.0 for r in some),
            "cusum_false": sum(r["cusum_false"] for r in some), "rls_false": sum(r["rls_false"] for r in some),
        }  # fmt: skip
    return out


CHANGES = 1200.0
"""Seconds after which friction comes, and goes again, where that is asked for."""


def exact_rows(begin: float, end: float, rate: float, changes: bool = False) -> np.ndarray:
    """Return samples (N, 5) of a leg that follows a motion exactly, with noise, from `begin` to before `end` s.

    With `changes` 0.6 N·m of dry friction come to the knee, and go, so that questions are asked.
    """
    t = np.arange(round(begin * rate), round(end * rate)) / rate
    path = motion(1).at(t)
    tau = true_model(Model.standard(), standard_leg().base, ()).torque(path)
    if changes:
        tau[:, 1] += 0.6 * np.tanh(path.dq[:, 1] / 0.02) * (t // CHANGES % 2)
    rng = np.random.default_rng(round(begin))
    return np.column_stack([t, path.q, tau + 0.5 * rng.standard_normal(tau.shape)])


def resident() -> float:
    """Return the memory of this process in MB (Linux)."""
    pages = int(Path("/proc/self/statm").read_text().split()[1])
    return pages * resource.getpagesize() / 1e6


def memory(hours: float, rate: float, changes: bool) -> dict:
    """Return the memory after each hour of a stream that is made as it is watched, and how large the state is."""
    watcher, seen, sizes = Watcher(Model.standard(), Settings()), [], []
    for k in range(round(60.0 * hours)):
        watcher.push(exact_rows(60.0 * k, 60.0 * (k + 1), rate, changes))
        if k == 4 or k % 60 == 59:
            seen.append(round(resident(), 1))
            detector = watcher.reference.detector
            held = (watcher.recent, watcher.usual, watcher.leaving, detector.quiet, detector.recent)
            sizes.append([len(one) for one in held])
            print(json.dumps({"hours": (k + 1) / 60.0, "mb": seen[-1], "held": sizes[-1]}), file=sys.stderr, flush=True)
    return {"rate": rate, "hours": hours, "mb": seen, "held": sizes[-1], "events": watcher.counts}


def speed(rate: float = 1000.0) -> dict:
    """Return how many times faster than real time a quiet stretch is watched, once what is usual is known."""
    seconds = 400.0
    rows = exact_rows(0.0, seconds, rate)
    watcher = Watcher(Model.standard(), Settings())
    learnt = int(150.0 * rate)
    watcher.push(rows[:learnt])
    began = time.process_time()
    for k in range(learnt, len(rows), 1000):
        watcher.push(rows[k : k + 1000])
    spent = time.process_time() - began
    return {"rate": rate, "times_real_time": (seconds - 150.0) / spent, "events": watcher.counts}


def main() -> None:
    """Run what is asked for; one JSON object per line, in a file as well if one is named, which is then continued."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--motions", type=int, default=6)
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--runs", type=int, default=0)
    parser.add_argument("--quiet-hours", type=float, default=0.0)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--keep", type=Path, default=None, help="folder in which simulated motions are kept")
    parser.add_argument("--to", type=Path, default=None, help="file of results; runs that it holds are not repeated")
    parser.add_argument("--speed", action="store_true")
    parser.add_argument("--memory-hours", type=float, default=0.0, help="hours of a stream over which memory is told")
    parser.add_argument("--changes", action="store_true", help="with --memory-hours: something changes every 20 min")
    parser.add_argument("--rate", type=float, default=None, help="Hz of --speed (1000) and --memory-hours (100)")
    args = parser.parse_args()
    if args.speed:
        print(json.dumps(speed(args.rate or 1000.0)), flush=True)
    if args.memory_hours:
        print(json.dumps(memory(args.memory_hours, args.rate or 100.0, args.changes)), flush=True)
    lines = [json.loads(line) for line in args.to.read_text().splitlines()] if args.to and args.to.exists() else []
    done = {(line["seed"], "quiet" in line) for line in lines}
    quiet = round(args.quiet_hours * 3600.0 / STREAM)
    for k in range(args.seed, args.seed + max(args.runs, quiet)):
        for wanted, run in ((args.runs, change_run), (quiet, quiet_run)):
            if k - args.seed < wanted and (k, run is quiet_run) not in done:
                lines.append(run(k, Truth.of(k % args.motions, args.seconds, args.keep)))
                print(json.dumps(lines[-1]), flush=True)
                if args.to:
                    with args.to.open("a", encoding="utf-8") as stream:
                        stream.write(json.dumps(lines[-1]) + "\n")
    if lines:
        print(json.dumps(summed_up(lines)), flush=True)


if __name__ == "__main__":
    main()
