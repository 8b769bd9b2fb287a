"""Add effects to recordings of a real (or anybody's) machine and count how often `discover` names them.

    python benchmarks/transplant.py FOLDER run_0.csv run_1.csv run_2.csv --verify run_3.csv
    python benchmarks/transplant.py FOLDER run_?.csv --known stribeck:hip --size 0.2 --only torque_ripple

The motion, the noise, the outliers and whatever else these recordings contain are theirs; only the torque of one
effect, computed along their own motion with a fit of their own parameters, is added to the measured torque. So this
asks what no simulation can: *on my machine, with my motion and my sensors, would an effect of this size be found?*
`--known` names what is already in the recordings (accepted before); it must then be found beside what was added.

The size is the RMS in N·m, at the joint that shows it most and below 5 Hz, of what a refitted base model cannot
imitate on these recordings. Results go to FOLDER/results.jsonl as they come; a case that is there is not run again.
"""

from __future__ import annotations

import argparse
import json
import multiprocessing
import os
import sys
import time
import zlib
from collections.abc import Sequence
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one thread per process; must be set before NumPy is imported
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path[:0] = [str(ROOT), str(ROOT / "benchmarks")]

import blind  # noqa: E402 - the repository must be on the path first

from exoid.diagnosis.discovery import discover  # noqa: E402
from exoid.diagnosis.grading import match  # noqa: E402
from exoid.measurement.bench.blind import draw_hidden  # noqa: E402
from exoid.measurement.bench.hidden import Hidden, true_model  # noqa: E402
from exoid.measurement.bench.leg import Leg  # noqa: E402
from exoid.measurement.reading.read import read_recording  # noqa: E402
from exoid.measurement.recording import Recording  # noqa: E402
from exoid.measurement.signals.conditioning import derivatives, low_pass, uniform_sampling  # noqa: E402
from exoid.measurement.signals.masks import widen  # noqa: E402
from exoid.optimisation.fitting.identify import identify  # noqa: E402
from exoid.optimisation.preparation.prepare import prepare  # noqa: E402
from exoid.optimisation.preparation.sticking import STICK, STICK_REACH  # noqa: E402
from exoid.symbolic.effect_catalogue import catalogue  # noqa: E402
from exoid.symbolic.model import Model  # noqa: E402
from exoid.symbolic.motion import Float, Motion  # noqa: E402
from exoid.symbolic.quantity import JOINTS  # noqa: E402

SMOOTH = 8.0
"""Cut-off in Hz of the angles along which an effect is computed; joints driven by motors hardly move faster."""
STANDSTILL = 2e-3
"""Velocity in rad/s over which the direction of motion changes along smoothed angles."""


@dataclass(frozen=True)
class Task:
    """One effect `name` of `size` N·m to be added to recordings; `known` is in them already. `thigh` in m."""

    name: str
    size: float
    seed: int
    train: tuple[str, ...]
    verify: tuple[str, ...]
    known: tuple[str, ...]
    thigh: float

    @property
    def label(self) -> str:
        return f"{'+'.join((self.name, *self.known))}/{self.size:g}/{self.seed}"


def smooth_motion(recording: Recording) -> Motion:
    """Return the motion (uniformly sampled) along which effects are computed."""
    even = uniform_sampling(recording)
    q = low_pass(even.q, min(SMOOTH, 0.4 * even.rate), even.rate)
    dq, ddq = derivatives(q, even.rate)
    return Motion(even.t, q, dq, ddq, np.tanh(dq / STANDSTILL))


def added_torque(hidden: Hidden, base: Sequence[float], thigh: float, motion: Motion) -> Float:
    """Return the torque (N, J) in N·m that the effect adds to a leg with these base parameters."""
    model = Model.standard(thigh_length=thigh)
    return true_model(model, base, (hidden,)).torque(motion) - true_model(model, base, ()).torque(motion)


def with_effect(recording: Recording, motion: Motion, torque: Float) -> Recording:
    """Return the recording with `torque` (given along `motion`) added to what was measured."""
    own = [np.interp(recording.t, motion.t, torque[:, j]) for j in range(len(JOINTS))]
    return replace(recording, tau=recording.tau + np.column_stack(own))


def left_over(base: Model, motions: Sequence[Motion], torques: Sequence[Float]) -> float:
    """Return the RMS in N·m of what a refitted base model cannot imitate below the band, at the joint with more.

    Where a joint may be sticking nobody can tell anything; there it does not count.
    """
    rows, values, moving = [], [], []
    for motion, torque in zip(motions, torques, strict=True):
        rate = 1.0 / float(motion.t[1] - motion.t[0])
        rows.append(low_pass(np.moveaxis(base.columns(motion), 1, 0), blind.BAND, rate))
        values.append(low_pass(torque, blind.BAND, rate))
        reach = int(np.ceil(STICK_REACH * rate / blind.BAND))
        moving.append(np.column_stack([~widen(np.abs(v) < STICK, reach) for v in motion.dq.T]))
    x, y, use = (np.concatenate(parts) for parts in (rows, values, moving))
    rest = np.where(use, y, 0.0)
    rest[use] -= x[use] @ np.linalg.lstsq(x[use], y[use], rcond=None)[0]
    return float(np.sqrt(np.sum(rest**2, axis=0) / np.maximum(use.sum(axis=0), 1)).max()) + 1e-12


def own_leg(task: Task, recordings: Sequence[Recording]) -> Leg:
    """Return the leg of the recordings: a fit of the base model with what is known to be in them."""
    model = Model.standard(thigh_length=task.thigh)
    prepared = prepare(model, recordings)
    for name in task.known:
        identifier, _, joint = name.partition(":")
        model = model.with_effect(catalogue()[identifier], joint or None)
    fit = identify(model, prepared.train, optimisers=())
    base = np.asarray(fit.linear)[:8].copy()
    base[4:] = np.maximum(base[4:], 0.0)
    return Leg("the recordings' leg", tuple(base), (1e3, 1e3), task.thigh)


def hidden_in(task: Task, leg: Leg, motions: Sequence[Motion], rng: np.random.Generator) -> Hidden:
    """Return the effect of `task` with drawn shape, scaled to its size on these motions."""
    identifier, _, joint = task.name.partition(":")
    effect = catalogue()[identifier]
    alone = effect if effect.on_both else replace(effect, joints=(joint,))
    (drawn,) = draw_hidden(rng, [alone], leg=leg, nothing=0.0)
    hidden = placed(Hidden(effect, joint or None, drawn.values), motions, rng)
    base = Model.standard(thigh_length=task.thigh)
    for _ in range(3):  # effects that change the model's inputs are not quite linear in their size
        torques = [added_torque(hidden, leg.base, task.thigh, m) for m in motions]
        hidden = blind._possible(blind._scaled(hidden, task.size / left_over(base, motions, torques)), leg)
    return hidden


def placed(hidden: Hidden, motions: Sequence[Motion], rng: np.random.Generator) -> Hidden:
    """Put what sits at an angle where these motions get to, near their end; give others a usual shape."""
    values = dict(hidden.values)
    effect = hidden.effect
    assert not isinstance(effect, str)
    if effect.id in blind.USUAL:
        key, low, high = blind.USUAL[effect.id]
        values[key] = float(np.exp(rng.uniform(*np.log((low, high)))))
    places = [key for key, shape in effect.shape.items() if shape.spacing == "position"]
    if places and hidden.joint is not None:
        angle = np.concatenate([m.q[:, JOINTS.index(hidden.joint)] for m in motions])
        part = float(rng.uniform(0.75, 0.92))
        part = 1.0 - part if values.get("side", 1.0) < 0.0 else part
        values |= dict.fromkeys(places, float(np.quantile(angle, part)))
    return replace(hidden, values=values)


def run(task: Task) -> dict[str, Any]:
    """Return one line of the results."""
    rng = np.random.default_rng(zlib.crc32(task.label.encode()))
    train = [read_recording(path) for path in task.train]
    verify = [read_recording(path) for path in task.verify]
    motions = [smooth_motion(r) for r in (*train, *verify)]
    leg = own_leg(task, train)
    hidden = hidden_in(task, leg, motions, rng)
    torques = [added_torque(hidden, leg.base, task.thigh, m) for m in motions]
    mixed = [with_effect(r, m, x) for r, m, x in zip((*train, *verify), motions, torques, strict=True)]
    began = time.perf_counter()
    found = discover(Model.standard(thigh_length=task.thigh), mixed[: len(train)], mixed[len(train) :])
    alike = [(a.name, sorted({*a.look_alikes, *a.never_separable})) for a in found.accepted]
    return {
        "case": task.label,
        "hidden": [task.name, *task.known],
        "values": {k: float(v) for k, v in hidden.values.items()},
        "visible": left_over(Model.standard(thigh_length=task.thigh), motions, torques),
        "size": task.size,
        "verdict": found.verdict,
        "accepted": alike,
        "suspects": [[s.name, s.explained_share, s.p_value, s.caution] for s in found.suspects[:6]],
        "unexplained": found.to_json()["unexplained"]["significant"],
        "seconds": time.perf_counter() - began,
    }


def verdict(line: dict[str, Any]) -> str:
    """Return `right`, `missed`, `extra` or both, and `too small` where bounds kept the effect below half its size."""
    if "error" in line:
        return str(line["error"])
    if line["visible"] < 0.5 * line["size"]:
        return "too small"
    answers = match(line["hidden"], line["accepted"])
    found = sum(by is not None for by in answers.values())
    parts = ["missed"] * (found < len(line["hidden"])) + ["extra"] * (len(line["accepted"]) > found)
    return " and ".join(parts) or "right"


def summary(lines: Sequence[dict[str, Any]]) -> str:
    """Return how often it was right, size by size, and every case that was not."""
    out = []
    for size in sorted({line["size"] for line in lines if "size" in line}, reverse=True):
        some = [verdict(line) for line in lines if line.get("size") == size]
        counted = [text for text in some if text != "too small"]
        rate = 100 * counted.count("right") / max(len(counted), 1)
        out.append(f"{size:g} N·m: right {counted.count('right')} of {len(counted)} ({rate:.0f} %)")
        if len(some) > len(counted):
            out[-1] += f"; {len(some) - len(counted)} cannot be that large within their bounds"
    for line in sorted(lines, key=lambda each: str(each["case"])):
        text = verdict(line)
        if text not in ("right", "too small"):
            named = [a + (f" ~ {', '.join(b)}" if b else "") for a, b in line.get("accepted", [])]
            out.append(f"{line['case']}: {text}; {line.get('values')} {line.get('verdict')} [{'; '.join(named)}]")
    return "\n".join(out)


def main() -> int:
    text, _, rest = (__doc__ or "").partition("\n\n")
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=text, epilog=rest, formatter_class=form)
    parser.add_argument("folder", type=Path, help="where results.jsonl is kept, outside the repository")
    parser.add_argument("recordings", nargs="+", help="recordings to fit")
    parser.add_argument("--verify", nargs="*", default=[], help="recordings kept unseen")
    parser.add_argument("--known", nargs="*", default=[], help="effects already in them (stribeck:hip)")
    parser.add_argument("--thigh", type=float, default=0.40, help="length of the first link in m")
    parser.add_argument("--size", nargs="+", type=float, default=[0.5, 0.2], help="N·m that the base cannot imitate")
    parser.add_argument("--only", default="", help="only effects whose name contains this")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    given = parser.parse_args()
    folder = given.folder.resolve()
    if folder.is_relative_to(ROOT):
        parser.error(f"{folder} is inside the repository; results are not part of it")
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "results.jsonl"
    files = tuple(given.recordings), tuple(given.verify), tuple(given.known)
    names = [n for n in blind.singles() if given.only in n and n not in given.known]
    wanted = [Task(n, size, given.seed, *files, given.thigh) for size in given.size for n in names]
    known = {line["case"] for line in blind.read_lines(path)}
    todo = [task for task in wanted if task.label not in known]
    context = multiprocessing.get_context("spawn")
    with path.open("a", encoding="utf-8") as stream, ProcessPoolExecutor(given.jobs, mp_context=context) as pool:
        waiting = {pool.submit(run, task): task for task in todo}
        for done, future in enumerate(as_completed(waiting), start=1):
            error = future.exception()
            line = {"case": waiting[future].label, "error": str(error)} if error else future.result()
            stream.write(json.dumps(line, ensure_ascii=False) + "\n")
            stream.flush()
            print(f"{done}/{len(todo)} {line['case']}: {verdict(line)}", flush=True)
    labels = {task.label for task in wanted}
    print(summary([line for line in blind.read_lines(path) if line["case"] in labels]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
