"""How well `exoid watch` does: false alarms per day, rate and delay of detection, right names; and how fast it is.

    python benchmarks/watch.py --motions 6 --runs 40 --quiet-hours 8
    python benchmarks/watch.py --changing-hours 48
    python benchmarks/watch.py --speed
    python benchmarks/watch.py --memory-hours 24 [--changes]

The bench is simulated once per motion (20 minutes, half a minute of CPU each); a run takes one of the motions, the
torque that it takes with the effect from a random moment on, and sensor noise of its own. Quiet runs differ by noise
and motion. In changing runs the motion becomes another one every few minutes, in size, speed and angles; three of
twelve such motions of 40 minutes follow each other in an order of their own. The size of an effect is drawn between
0.2 and 1 N·m RMS at the joint that shows most of it; every third run has "full size", 1 N·m. Beside it, on the same
filtered samples: recursive least squares that forgets (60 s) with a CUSUM on each innovation (its threshold would
alarm once a day if innovations were white), the same CUSUM on the residual of the model fitted first, and `ruptures`
on the whole run (PELT, L2, offline, an oracle for *when*). Every run is one JSON line; the last line sums up.
"""

from __future__ import annotations

import argparse
import json
import resource
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from benchmarks.watch_rivals import Filtered, cusum, oracle
from benchmarks.watched_leg import Truth, drawn, exact_rows
from exoid.apps.watch.acting import Applied
from exoid.apps.watch.events import Event
from exoid.apps.watch.settings import Settings
from exoid.apps.watch.watcher import Watcher
from exoid.apps.watch.window import Window
from exoid.diagnosis.against.result import Differences
from exoid.measurement.bench.leg import standard_leg
from exoid.symbolic.model import Model
from exoid.symbolic.quantity import Estimate

HOUR = 3600.0
STREAM = 2.0 * 3600.0
"""s of a stream in which nothing changes."""
WANDERINGS, TOGETHER = 12, 3
"""Motions that change, and how many of them make one stream."""


class Counted(Watcher):
    """A watcher that counts how often it asked what differs, and the s of CPU that this took."""

    asked, spent = 0, 0.0

    def _ask(self, after: Sequence[Window], most: int = 1, but: Applied | None = None) -> Differences:
        began = time.process_time()
        found = super()._ask(after, most, but)
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
        return sum(e.low <= x <= e.high for e, x in zip(estimates, truth, strict=False))

    for k in range(0, len(rows), 500):
        if (
            rows[min(k + 499, len(rows) - 1), 0] < moment
            and watcher.numbers is not None
            and rows[k, 0] > moment - 10.0
        ):
            held = inside(watcher.numbers.estimates())
        events += watcher.push(rows[k : k + 500])
    if np.isinf(moment):
        held = inside(watcher.numbers.estimates())
    cost = {"cpu": time.process_time() - began, "asked": watcher.asked, "cpu_asked": watcher.spent}
    first = next(e for e in events if e.event == "reference")
    return events + watcher.finish(), cost | {"held": held, "held_first": inside(first.estimates), "of": len(truth)}


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
    words = [e.t for e in events if e.t >= moment and (e.alarm or e.event == "suspected")]
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
        "delay_word": words[0] - moment if words else None,
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


def changing_run(seed: int, folder: Path | None) -> dict:
    """Return the false alarms of a run in which nothing but the motion changes."""
    chosen = np.random.default_rng([seed, 19]).permutation(WANDERINGS)[:TOGETHER]
    parts = [Truth.of(int(k), STREAM / TOGETHER, folder, wanders=True) for k in chosen]
    rows = Truth.joined(parts).rows(20_000 + seed)
    events, cost = watched(rows)
    told = [(round(e.t, 1), e.event, e.kind, e.names, repr(e)) for e in events if e.alarm]
    calm = [(round(e.t, 1), e.event) for e in events if e.event in ("motion", "suspected", "push", "reference")]
    return {"seed": seed, "changing": float(rows[-1, 0]), **cost, "alarms": told, "calm": calm}


def summed_up(lines: list[dict]) -> dict:
    """Return the figures of a campaign."""
    runs, quiet, changing = ([r for r in lines if kind in r] for kind in ("effect", "quiet", "changing"))
    out: dict = {"quiet_hours": sum(r["quiet"] for r in quiet) / HOUR}
    out["changing_hours"] = sum(r["changing"] for r in changing) / HOUR
    out["false_alarms_changing"] = sum(len(r["alarms"]) for r in changing)
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
        words = [r["delay_word"] for r in some if r.get("delay_word") is not None]
        out[name] = {
            "runs": len(some), "detected": len(seen), "named": len(named), "right": sum(r["right"] for r in named),
            "exact": sum(r["exact"] for r in named), "first_right": sum(r["first_right"] for r in named),
            "look_alikes": float(np.median([len(r["alike"]) for r in named])) if named else None,
            "median_delay_word": float(np.median(words)) if words else None,
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
            kept = watcher.memory
            held = (kept.recent, kept.usual, kept.leaving, detector.quiet, detector.recent)
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
    parser.add_argument("--changing-hours", type=float, default=0.0, help="hours in which only the motion changes")
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
    done = {(line["seed"], kind) for line in lines for kind in ("effect", "quiet", "changing") if kind in line}
    quiet, changing = (round(hours * HOUR / STREAM) for hours in (args.quiet_hours, args.changing_hours))
    runs = {
        "effect": (args.runs, lambda k: change_run(k, Truth.of(k % args.motions, args.seconds, args.keep))),
        "quiet": (quiet, lambda k: quiet_run(k, Truth.of(k % args.motions, args.seconds, args.keep))),
        "changing": (changing, lambda k: changing_run(k, args.keep)),
    }
    for k in range(args.seed, args.seed + max(args.runs, quiet, changing)):
        for kind, (wanted, run) in runs.items():
            if k - args.seed < wanted and (k, kind) not in done:
                lines.append(run(k))
                print(json.dumps(lines[-1]), flush=True)
                if args.to:
                    with args.to.open("a", encoding="utf-8") as stream:
                        stream.write(json.dumps(lines[-1]) + "\n")
    if lines:
        print(json.dumps(summed_up(lines)), flush=True)


if __name__ == "__main__":
    main()
