"""Hide effects in random legs, let `discover` look for them, and count how often it is right.

    python benchmarks/blind.py FOLDER                                every kind, one seed per variant
    python benchmarks/blind.py FOLDER --kinds single none --seeds 5
    python benchmarks/blind.py FOLDER --only stribeck --jobs 1
    python benchmarks/blind.py FOLDER --show                         only print what FOLDER has already

Each case is a leg of its own: three 30 s runs to fit, one to verify, 100 Hz, the bench's usual instruments. Kinds:

    single    one effect of the catalogue at one joint. Its size is set by what a refitted base model cannot imitate:
              0.25-1.2 N·m RMS at the joint that shows it most, where the torque sensor leaves 0.15-0.25 N·m of noise
    small     the same case at 0.4 times its size
    pair      two different effects, each as in `single`
    none      nothing
    outside   an effect that the catalogue does not have

Results are appended to FOLDER/results.jsonl as they come, one JSON object per line; a case that is there already is not
run again, so a campaign may be interrupted. A case is *right* when exactly as much is accepted as was hidden, and each
hidden effect is an accepted one or among its look-alikes; `outside` is right when nothing is accepted and what is left
is reported at the right joint in the right variable.
"""

from __future__ import annotations

import argparse
import json
import math
import multiprocessing
import os
import sys
import time
import zlib
from concurrent.futures import ProcessPoolExecutor, as_completed
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")  # one thread per process; must be set before NumPy is imported
os.environ.setdefault("OMP_NUM_THREADS", "1")

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from diagnosis.discover import discover  # noqa: E402 - the repository must be on the path first
from diagnosis.evidence.fitted import fitted_model  # noqa: E402
from diagnosis.grading import match  # noqa: E402
from diagnosis.results import Diagnosis  # noqa: E402
from measurement.bench.blind import draw, relative_size  # noqa: E402
from measurement.bench.hidden import Hidden, true_model  # noqa: E402
from measurement.bench.leg import Leg, random_leg  # noqa: E402
from measurement.bench.simulation import BenchError, Run, simulate_runs  # noqa: E402
from measurement.signals.conditioning import low_pass  # noqa: E402
from measurement.trajectories.trajectory import random_trajectory  # noqa: E402
from optimisation.fitting.identify import identify  # noqa: E402
from optimisation.preparation.prepare import prepare  # noqa: E402
from symbolic.catalogue import catalogue  # noqa: E402
from symbolic.effect import Coefficient, Effect, Shape  # noqa: E402
from symbolic.model import Model  # noqa: E402
from symbolic.motion import Motion  # noqa: E402
from symbolic.quantity import JOINTS  # noqa: E402

KINDS = ("single", "small", "pair", "none", "outside")
VISIBLE = (0.25, 1.2)
"""RMS in N·m that a hidden effect leaves after the base model was refitted to it."""
RATE, BAND = 200.0, 5.0
"""Sampling and band in Hz in which that is judged."""
USUAL = {"torque_ripple": ("n", 8.0, 120.0), "stribeck": ("v_s", 0.05, 0.3)}
"""Ranges a shape is drawn from where the catalogue's is wider than what can be seen at all: a faster ripple is outside
the band but at creeping speed, a narrower Stribeck peak is inside the speeds at which a joint may stick."""
MOST_SHARE = 0.6
"""Largest effect against the torque of the leg, as standard deviations: an effect that the base model nearly contains
(a spring at the hip) would have to be absurd to be visible."""
SMALL = 0.4
LEGS_WITH_NOTHING = 6
"""Legs of kind `none` per seed, so that false alarms are counted on enough of them."""
PAIRS = 12
"""Pairs per seed, drawn from all there are."""
SHOWN_SUSPECTS = 6


def _outside(identifier: str, torque: str, joint: str, **shape: tuple[float, float, float]) -> Effect:
    own, unit = ("rad/s", "N·m") if "exp(-((dtheta" in torque else ("rad", "N·m")
    if torque.endswith(("dtheta", "dtheta2")):
        unit = "N·m·s/rad"
    numbers = {key: Shape(own, low, high, typical=usual) for key, (low, high, usual) in shape.items()}
    text = f"an effect that the catalogue does not have: {torque}"
    return Effect(identifier, text, torque, None, (joint,), {"c": Coefficient(unit)}, numbers, custom=True)


OUTSIDE: dict[str, tuple[Effect, tuple[str, ...]]] = {
    f"{effect.id}:{effect.joints[0]}": (effect, variables)
    for effect, variables in (
        (
            _outside("angle_bump", "c * exp(-((theta - m)/w)**2)", "hip", m=(0.4, 0.8, 0.6), w=(0.12, 0.25, 0.2)),
            ("q1",),
        ),
        (
            _outside("angle_bump", "c * exp(-((theta - m)/w)**2)", "knee", m=(-1.2, -0.6, -0.9), w=(0.12, 0.25, 0.2)),
            ("q2",),
        ),
        (
            _outside("speed_bump", "c * exp(-((dtheta - m)/w)**2)", "knee", m=(0.3, 0.7, 0.5), w=(0.1, 0.3, 0.2)),
            ("dq2",),
        ),
        (
            _outside("speed_bump", "c * exp(-((dtheta - m)/w)**2)", "hip", m=(0.3, 0.7, 0.5), w=(0.1, 0.3, 0.2)),
            ("dq1",),
        ),
        (_outside("angle_times_speed", "c * theta1 * dtheta2", "hip"), ("q1", "dq2")),
        (_outside("angle_wave", "c * sin(3*theta + 0.5) * dtheta", "knee"), ("q2", "dq2")),
    )
}
"""Effects beyond the catalogue, and the variables of which one must be named."""


@dataclass(frozen=True)
class Case:
    """One leg of the campaign: `variants` are the names of the hidden terms (`stribeck:knee`)."""

    kind: str
    variants: tuple[str, ...]
    seed: int

    @property
    def name(self) -> str:
        return f"{self.kind}/{'+'.join(self.variants) or 'nothing'}/{self.seed}"

    @property
    def number(self) -> int:
        """Seed of every random number; the same for `single` and `small`, so that only the size differs."""
        kind = "single" if self.kind == "small" else self.kind
        return zlib.crc32(f"{kind}/{self.variants}/{self.seed}".encode())


def singles() -> list[str]:
    """Return the name of every term that the base model does not contain already."""
    names = []
    for effect in catalogue().values():
        joints = [j for j in effect.joints if j not in effect.absorbed_on]
        names += [effect.id] if effect.on_both else [f"{effect.id}:{j}" for j in joints]
    return names


def cases(kinds: list[str], seeds: int, first: int = 0) -> list[Case]:
    """Return the campaign, seed by seed, so that an interrupted one has seen every kind."""
    out = []
    for seed in range(first, first + seeds):
        rng = np.random.default_rng([seed, 7])
        names = singles()
        by_kind = {
            "single": [Case("single", (n,), seed) for n in names],
            "small": [Case("small", (n,), seed) for n in names],
            "pair": [Case("pair", _pair(rng, names), seed) for _ in range(PAIRS)],
            "none": [Case("none", (), LEGS_WITH_NOTHING * seed + k) for k in range(LEGS_WITH_NOTHING)],
            "outside": [Case("outside", (n,), seed) for n in OUTSIDE],
        }
        out += [case for kind in kinds for case in by_kind[kind]]
    return out


def _pair(rng: np.random.Generator, names: list[str]) -> tuple[str, str]:
    """Return two terms of different effects."""
    while True:
        one, two = (names[int(k)] for k in rng.choice(len(names), 2, replace=False))
        if one.partition(":")[0] != two.partition(":")[0]:
            return one, two


def hide(case: Case, leg: Leg, rng: np.random.Generator) -> tuple[Hidden, ...]:
    """Return what is hidden in the leg of `case`, with its numbers drawn."""
    out = []
    for name in case.variants:
        identifier, _, joint = name.partition(":")
        effect = OUTSIDE[name][0] if name in OUTSIDE else catalogue()[identifier]
        alone = effect if effect.on_both else replace(effect, joints=(joint,))
        (drawn,) = draw(rng, [alone], leg=leg, nothing=0.0)
        hidden = _placed(Hidden(effect, joint or None, drawn.values), rng)
        wanted = math.exp(float(rng.uniform(*np.log(VISIBLE))))
        hidden = _scaled(hidden, min(wanted / visible(hidden, leg), MOST_SHARE / relative_size(hidden, leg)))
        out.append(_possible(_scaled(hidden, SMALL if case.kind == "small" else 1.0), leg))
    return tuple(out)


def motions() -> list[Motion]:
    """Return three usual motions, 10 s each, on which sizes are judged."""
    limits = Model.standard().limits
    return [random_trajectory(np.random.default_rng(k), limits).at(np.arange(0.0, 10.0, 1.0 / RATE)) for k in range(3)]


def visible(hidden: Hidden, leg: Leg) -> float:
    """Return the RMS in N·m (of the joint that shows it most) of what a refitted base model cannot imitate.

    Only below the band in which accelerations are usually clean: faster torque is beyond any model fitted to these.
    """
    model = Model.standard(thigh_length=leg.thigh_length)
    plain, full = true_model(model, leg.base, ()), true_model(model, leg.base, (hidden,))
    columns = [low_pass(np.moveaxis(model.columns(m), 1, 0), BAND, RATE) for m in motions()]
    added = [low_pass(full.torque(m) - plain.torque(m), BAND, RATE) for m in motions()]
    x, y = np.concatenate(columns).reshape(-1, 8), np.concatenate(added).ravel()
    left = y - x @ np.linalg.lstsq(x, y, rcond=None)[0]
    return float(np.sqrt(np.mean(left.reshape(-1, 2) ** 2, axis=0)).max()) + 1e-12


def _placed(hidden: Hidden, rng: np.random.Generator) -> Hidden:
    """Put what sits at an angle (an end stop) where the joint gets to, near its end; give others a usual shape."""
    assert isinstance(hidden.effect, Effect)
    if hidden.effect.id in USUAL:
        key, low, high = USUAL[hidden.effect.id]
        return replace(hidden, values={**hidden.values, key: math.exp(float(rng.uniform(*np.log((low, high)))))})
    places = [key for key, shape in hidden.effect.shape.items() if shape.spacing == "position"]
    if not places or hidden.joint is None:
        return hidden
    angle = np.concatenate([m.q[:, JOINTS.index(hidden.joint)] for m in motions()])
    part = float(rng.uniform(0.75, 0.92))
    part = 1.0 - part if hidden.values.get("side", 1.0) < 0.0 else part
    return replace(hidden, values={**hidden.values, **dict.fromkeys(places, float(np.quantile(angle, part)))})


def _scaled(hidden: Hidden, factor: float) -> Hidden:
    """Return the effect `factor` times as large: its coefficients, or its only number where it has none."""
    assert isinstance(hidden.effect, Effect)
    size = hidden.effect.coefficients or hidden.effect.shape
    return replace(hidden, values={k: v * (factor if k in size else 1.0) for k, v in hidden.values.items()})


def _possible(hidden: Hidden, leg: Leg) -> Hidden:
    """Keep numbers within their bounds, and presliding friction within the dry friction that it takes the place of."""
    assert isinstance(hidden.effect, Effect)
    bounds = hidden.effect.shape
    values = {k: min(max(v, bounds[k].min), bounds[k].max) if k in bounds else v for k, v in hidden.values.items()}
    if hidden.effect.id in ("friction_drift", "viscous_drift", "joint_elasticity"):
        values["c"] = abs(values["c"])  # more friction while cold, or it would drive the joint; a spring that yields
    if hidden.effect.id == "hysteresis":
        dry = leg.base[4 if hidden.joint == "hip" else 6]
        values["c"] = min(values["c"], dry)
    return replace(hidden, values=values)


def simulated(case: Case, leg: Leg, rng: np.random.Generator) -> tuple[tuple[Hidden, ...], tuple[Run, ...]]:
    """Return what is hidden and its four runs; smaller where the leg could not be moved otherwise."""
    hidden = hide(case, leg, rng)
    for _ in range(8):
        try:
            return hidden, simulate_runs(4, None, leg, effects=hidden, seed=case.number)
        except BenchError:
            hidden = tuple(_scaled(one, 0.7) for one in hidden)
    return hidden, simulate_runs(4, None, leg, effects=hidden, seed=case.number)


def run_case(case: Case) -> dict[str, Any]:
    """Return one line of the results."""
    rng = np.random.default_rng(case.number)
    leg = random_leg(rng)
    hidden, runs = simulated(case, leg, rng)
    recordings = [run.recording for run in runs]
    model = Model.standard(thigh_length=leg.thigh_length)
    began = time.perf_counter()
    found = discover(model, recordings[:3], recordings[3:])
    seconds = time.perf_counter() - began
    best, covered = _true_structure(model, runs)
    first, last = found.steps[0].verify_rms, found.steps[-1].verify_rms
    return {
        "case": case.name,
        "kind": case.kind,
        "hidden": {h.name: {k: float(v) for k, v in h.values.items()} for h in hidden},
        "size": [relative_size(h, leg) for h in hidden],
        "visible": [visible(h, leg) for h in hidden],
        "verdict": found.verdict,
        "accepted": [_accepted(a) for a in found.accepted],
        "unexplained": found.to_json()["unexplained"],
        "suspects": [
            [s.name, s.explained_share, s.p_value, s.caution]
            for s in found.suspects
            if _worth_showing(s.name, case, found)
        ],
        "rms": {"base": first.tolist(), "found": last.tolist(), "true": best},
        "floor": found.noise_floor.tolist(),
        "covered_true": covered,
        "covered_found": _covered(found.fit.estimates, runs[0]) if _exactly(found, hidden) else None,
        "saturated": max(run.saturated for run in runs),
        "seconds": seconds,
    }


def _worth_showing(name: str, case: Case, found: Diagnosis) -> bool:
    return name in case.variants or name in [s.name for s in found.suspects[:SHOWN_SUSPECTS]]


def _accepted(one: Any) -> dict[str, Any]:
    alike = sorted({*one.look_alikes, *one.never_separable})
    numbers = {name: e.value for name, e in one.parameters.items()}
    return {"name": one.name, "look_alikes": alike, "p": one.p_value, "numbers": numbers}


def _exactly(found: Diagnosis, hidden: tuple[Hidden, ...]) -> bool:
    return {a.name for a in found.accepted} == {h.name for h in hidden}


def _true_structure(model: Model, runs: tuple[Run, ...]) -> tuple[list[float], list[bool]]:
    """Return the error on unseen motion when the structure is known, and which intervals then cover the truth."""
    recordings = [run.recording for run in runs]
    prepared = prepare(model, recordings[:3], recordings[3:])
    true = runs[0].true
    fit = identify(true.model, prepared.train, optimisers=(), start=true.shape if true.shape.size else None)
    rms = fitted_model(fit, prepared).verify_rms
    assert rms is not None
    return rms.tolist(), _covered(fit.estimates, runs[0])


def _covered(estimates: Any, run: Run) -> list[bool]:
    """Return for every number that has an interval whether it contains the truth."""
    truth = run.true.numbers()
    known = [e for e in estimates if e.name in truth and math.isfinite(e.low) and math.isfinite(e.high)]
    return [bool(e.low <= truth[e.name] <= e.high) for e in known]


# -- judging ------------------------------------------------------------------------------------------------------


def matched(line: dict[str, Any]) -> tuple[int, int]:
    """Return how many hidden effects were found (each by another accepted one), and how many accepted are extra."""
    answers = match(list(line["hidden"]), [(a["name"], a["look_alikes"]) for a in line["accepted"]])
    found = sum(by is not None for by in answers.values())
    return found, len(line["accepted"]) - found


def right(line: dict[str, Any]) -> bool:
    """Whether the answer is what a user should have been told."""
    if "error" in line:
        return False
    if line["kind"] == "outside":
        (name,) = line["hidden"]
        effect, variables = OUTSIDE[name]
        rest = line["unexplained"]
        placed = rest["joint"] == effect.joints[0] and bool({*rest["variables"]} & {*variables})
        return line["verdict"] == "unexplained" and placed
    found, extra = matched(line)
    return found == len(line["hidden"]) and extra == 0 and (bool(line["hidden"]) or line["verdict"] == "adequate")


def excess(line: dict[str, Any]) -> float:
    """Return the unseen error after `discover` over that of the true structure, the worse joint."""
    return float(np.max(np.array(line["rms"]["found"]) / np.array(line["rms"]["true"])))


def table(lines: list[dict[str, Any]]) -> str:
    """Return the campaign in one row per kind, and the cases that went wrong."""
    head = ("kind", "cases", "right", "extra", "missed", "look-alikes", "error/true (median, worst)", "covered", "s")
    rows = [head]
    for kind in KINDS:
        some = [line for line in lines if line["kind"] == kind]
        good = [line for line in some if "error" not in line]
        if not some:
            continue
        pairs = [matched(line) for line in good]
        extra = sum(e > 0 for _, e in pairs)
        missed = sum(f < len(line["hidden"]) for (f, _), line in zip(pairs, good, strict=True))
        alike = [len(a["look_alikes"]) for line in good for a in line["accepted"]]
        ratios = [excess(line) for line in good] or [math.nan]
        covered = [ok for line in good for ok in line["covered_true"]]
        rows.append(
            (
                kind,
                str(len(some)),
                f"{100 * sum(map(right, some)) / len(some):.1f} %",
                str(extra),
                str(missed) if kind not in ("none", "outside") else "",
                f"{np.mean(alike):.2f}" if alike else "",
                f"{np.median(ratios):.3f}, {max(ratios):.3f}",
                f"{100 * np.mean(covered):.1f} %" if covered else "",
                f"{np.mean([line['seconds'] for line in good]):.1f}" if good else "",
            )
        )
    widths = [max(len(row[k]) for row in rows) for k in range(len(head))]
    text = ["  ".join(cell.ljust(w) for cell, w in zip(row, widths, strict=True)).rstrip() for row in rows]
    wrong = [line for line in lines if not right(line)]
    return "\n".join([*text, "", *(describe(line) for line in sorted(wrong, key=lambda w: w["case"]))])


def describe(line: dict[str, Any]) -> str:
    """Return one wrong case in a line."""
    if "error" in line:
        return f"{line['case']}: {line['error']}"
    named = [a["name"] + (f" ~ {', '.join(a['look_alikes'])}" if a["look_alikes"] else "") for a in line["accepted"]]
    rest = line["unexplained"]
    left = f"; left: {rest['joint']} {rest['variables']}" if rest["significant"] else ""
    error = f"error/true {excess(line):.2f}"
    return f"{line['case']}: {line['verdict']} [{'; '.join(named) or 'nothing accepted'}]{left}; {error}"


# -- the campaign -------------------------------------------------------------------------------------------------


def read_lines(path: Path) -> list[dict[str, Any]]:
    """Return the results so far; a line cut short by an interruption is left out."""
    out = []
    for text in path.read_text(encoding="utf-8").splitlines() if path.exists() else ():
        try:
            out.append(json.loads(text))
        except json.JSONDecodeError:
            continue
    return out


def campaign(todo: list[Case], path: Path, jobs: int) -> None:
    """Run the cases in `jobs` processes and append what each gives to `path`."""
    context = multiprocessing.get_context("spawn")
    with path.open("a", encoding="utf-8") as stream, ProcessPoolExecutor(jobs, mp_context=context) as pool:
        waiting = {pool.submit(run_case, case): case for case in todo}
        for done, future in enumerate(as_completed(waiting), start=1):
            case, error = waiting[future], future.exception()
            blank = {"case": case.name, "kind": case.kind, "hidden": dict.fromkeys(case.variants)}
            line = blank | {"error": f"{type(error).__name__}: {error}"} if error else future.result()
            stream.write(json.dumps(line, ensure_ascii=False) + "\n")
            stream.flush()
            mark = "right" if right(line) else f"WRONG  {describe(line)}"
            print(f"{done}/{len(todo)} {case.name}: {mark}", flush=True)


def main() -> int:
    text, _, rest = (__doc__ or "").partition("\n\n")
    parser = argparse.ArgumentParser(
        description=text, epilog=rest, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("folder", type=Path, help="where results.jsonl is kept, outside the repository")
    parser.add_argument("--kinds", nargs="+", choices=KINDS, default=list(KINDS))
    parser.add_argument("--seeds", type=int, default=1, help="legs per variant")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--only", default="", help="only cases whose name contains this")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    parser.add_argument("--show", action="store_true", help="run nothing, print the table")
    given = parser.parse_args()
    folder = given.folder.resolve()
    if folder.is_relative_to(ROOT):
        parser.error(f"{folder} is inside the repository; results are not part of it")
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / "results.jsonl"
    wanted = [c for c in cases(given.kinds, given.seeds, given.first) if given.only in c.name]
    known = {line["case"] for line in read_lines(path)}
    todo = [c for c in wanted if c.name not in known]
    if todo and not given.show:
        campaign(todo, path, max(1, min(given.jobs, len(todo))))
    names = {c.name for c in wanted}
    print(table([line for line in read_lines(path) if given.show or line["case"] in names]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
