"""Recordings that differ: are the differences told, with intervals that hold the truth, and nothing else?

    python benchmarks/differences.py [--sets 50] [--first 0] [--same] [--effects] [--mujoco]

Chains of one to three joints by Newton and Euler (the arena's plant of equations), four runs of 20 s, of which one is
held out at random. Each set has one difference by turns: torque zeros, a load, a gain, a level of friction, friction
that goes with a logged temperature, a late or fast clock, a load or a zero from a moment on, the zero of an encoder.
With `--effects` an effect of the catalogue is hidden beside it; with `--same` only torque zeros, or nothing, differ.
Right is an answer that tells this difference, the hidden effect and nothing more. With `--mujoco` the runs are of
MuJoCo's leg (`mujoco_leg.py`), in which a rotor or a tendon is hidden and nothing has a temperature.
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from benchmarks import mujoco_leg
from benchmarks.arena.plants.equations import EFFECTS, NAMES, At, Links, rigid
from exoid.diagnosis import discover
from exoid.diagnosis.own_numbers.numbers import Belonging
from exoid.measurement.logged import Logged
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion

RATE, SECONDS, RUNS = 100.0, 20.0, 4
T = np.arange(round(SECONDS * RATE)) / RATE
KINDS = (
    "zeros", "load", "gain", "friction", "temperature", "late clock", "fast clock", "load from then on",
    "zero from then on", "encoder",
)  # fmt: skip
MOMENT = 0.1
"""Seconds to which a moment has to be told."""
HIDDEN = ("stribeck", "load_friction", "viscous_quadratic", "end_stop", "hardening_spring")


@dataclass(frozen=True)
class Machine:
    """Links, over how many rad/s dry friction turns round, the noise of a torque sensor in N·m, and where on its last
    link a load hangs, m.
    """

    links: Links
    width: float
    noise: float
    place: float

    @property
    def count(self) -> int:
        return len(self.links.mass)


@dataclass(frozen=True, eq=False)
class Run:
    """Numbers of one run from the time `since` s on: zeros (J,), gains (J,), frictions (J,) in parts of the usual, a
    load in kg on its last link; and how `late` s and `fast` the clock of its torques is. `warm` (N, J) is the part by
    which friction is less, since the joint is warm, `angle` (J,) by how many rad its joints stand further than is read.
    """

    zero: Float
    gain: Float
    friction: Float
    load: float = 0.0
    late: float = 0.0
    fast: float = 0.0
    since: float = 0.0
    warm: Float = field(default_factory=lambda: np.zeros(1))
    angle: Float = field(default_factory=lambda: np.zeros(1))


@dataclass(frozen=True)
class Hidden:
    """An effect of the catalogue at a joint, with its size and the numbers that were `drawn` for its shape."""

    effect: str
    joint: int
    size: float
    drawn: Float


@dataclass(frozen=True)
class Difference:
    """Difference at a joint, None for all: `values` {run: its number}, empty where each moment has its own, from
    `since` s on, from the beginning where that is 0.
    """

    what: str
    joint: str | None
    values: Mapping[str, float]
    since: float = 0.0

    def is_told(self, said: Belonging) -> bool:
        """True if a statement is about the same runs, and the same part of them."""
        starts = [start for start, stop in said.spans.values() if start is not None and stop is None]
        same = (said.what, said.joint) == (self.what, self.joint) and len(starts) == len(said.spans)
        there = all(abs(start - self.since) < MOMENT for start in starts)
        whole = {*said.spans} == ({*said.values} if self.since else set())
        return same and there and whole and (not self.values or {*said.values} == {*self.values})


def machine_of(rng: np.random.Generator) -> Machine:
    """Machine of one to three joints."""
    count = int(rng.integers(1, 4))
    mass = np.array([3.0, 2.0, 1.0])[:count] * rng.uniform(0.7, 1.3, count)
    length = np.round(np.array([0.42, 0.40, 0.2])[:count] * rng.uniform(0.9, 1.1, count), 3)
    links = Links(
        mass, length * rng.uniform(0.4, 0.6, count), length, mass * length**2 / 12.0 * rng.uniform(0.8, 1.3, count),
        rng.uniform(0.6, 1.5, count), rng.uniform(0.3, 1.2, count),
    )  # fmt: skip
    width, noise = np.exp(rng.uniform(np.log(0.002), np.log(0.03))), rng.choice([0.05, 0.15, 0.4])
    return Machine(links, float(width), float(noise), float(rng.uniform(0.4, 0.9) * length[-1]))


def waves_of(rng: np.random.Generator, count: int) -> Callable[[Float], Motion]:
    """Sums of five sines per joint, at most 0.7 rad from hanging and 2.5 rad/s, at any times (N,)."""
    w = 2.0 * np.pi * rng.uniform(0.1, 0.8, (5, count))
    size, phase = rng.uniform(0.3, 1.0, (5, count)) / w**0.5, rng.uniform(0.0, 2.0 * np.pi, (5, count))
    angle = w * T[:, None, None] + phase
    far, quick = (np.abs(x.sum(axis=1)).max(axis=0) for x in (size * np.sin(angle), size * w * np.cos(angle)))
    size = size * np.minimum(0.7 / far, 2.5 / quick)

    def motion(at: Float) -> Motion:
        turn = w * at[:, None, None] + phase
        sine, cosine = size * np.sin(turn), size * np.cos(turn)
        return Motion(at, sine.sum(axis=1), (w * cosine).sum(axis=1), -(w**2 * sine).sum(axis=1))

    return motion


def torque_of(machine: Machine, motion: Motion, run: Run, hidden: Hidden | None) -> Float:
    """Torques (N, J) of a motion, beside what a run has to itself."""
    links, there = machine.links, (motion.t >= run.since)[:, None]
    carrying = np.where(there, rigid(loaded(machine, run.load), motion), rigid(links, motion))
    friction = links.dry * np.tanh(motion.dq / machine.width) + links.viscous * motion.dq
    out = carrying + friction * np.where(there, run.friction, 1.0) * (1.0 - run.warm)
    if hidden is not None:
        at = At(hidden.joint, motion, carrying[:, hidden.joint], hidden.drawn)
        out[:, hidden.joint] += hidden.size * EFFECTS[hidden.effect][1](at)
    return np.asarray(np.where(there, out * run.gain + run.zero, out))


def loaded(machine: Machine, load: float) -> Links:
    """Links of a machine with a small body of `load` kg on the last one."""
    links, last = machine.links, machine.count - 1
    own, along, inertia = (float(x[last]) for x in (links.mass, links.along, links.inertia))
    middle = (own * along + load * machine.place) / (own + load)
    inertia += own * (along - middle) ** 2 + load * (machine.place - middle) ** 2
    new = {"mass": own + load, "along": middle, "inertia": inertia}
    return replace(links, **{name: np.append(getattr(links, name)[:last], x) for name, x in new.items()})


def some_of(rng: np.random.Generator) -> list[int]:
    """One or two runs."""
    return sorted(rng.choice(RUNS, int(rng.integers(1, 3)), replace=False).tolist())


def differing(kind: str, machine: Machine, rng: np.random.Generator) -> tuple[list[Run], list[Difference]]:
    """Runs that differ in one `kind`, and the truth that has to be told."""
    many = machine.count
    usual = Run(np.zeros(many), np.ones(many), np.ones(many))
    runs, joint = [usual] * RUNS, int(rng.integers(many))
    name, last, unit = NAMES[joint], NAMES[many - 1], np.eye(many)[joint]
    which, names = some_of(rng), [f"run_{k}" for k in range(RUNS)]
    sign = 1.0 if rng.random() < 0.5 else -1.0
    if kind == "nothing":
        return runs, []
    if kind == "zeros":
        zeros = rng.uniform(0.4, 1.5) * rng.standard_normal((RUNS, many))
        zeros *= np.ones(many) if rng.random() < 0.5 else unit
        each = [dict(zip(names, x.tolist(), strict=True)) for x in zeros.T]
        truth = [Difference("sensor_zero", NAMES[j], x) for j, x in enumerate(each) if any(x.values())]
        return [replace(usual, zero=x) for x in zeros], truth
    if kind == "fast clock":
        fast = sign * float(rng.uniform(0.001, 0.004))
        return [replace(usual, fast=fast)] * RUNS, [Difference("clock_rate", None, dict.fromkeys(names, fast))]
    if kind == "temperature":
        warm = np.array([20.0, 26.0, 33.0, 40.0])[rng.permutation(RUNS)]
        rises = warm[:, None] + rng.uniform(2.0, 8.0, (RUNS, 1)) * (1.0 - np.exp(-T / 8.0))
        slope = float(rng.uniform(0.01, 0.02))
        made = [replace(usual, warm=slope * (x[:, None] - 33.0) * unit) for x in rises]
        return made, [Difference(f"logged:temperature_{name}", name, {})]
    if kind in ("load from then on", "zero from then on"):
        since, k = float(rng.uniform(0.3, 0.7) * SECONDS), which[0]
        load, zero = float(rng.uniform(0.3, 1.0) * machine.links.mass[-1]), sign * float(rng.uniform(0.5, 1.5))
        if kind == "load from then on":
            runs[k] = replace(usual, load=load, since=since)
            return runs, [Difference("carried_load", last, {names[k]: load}, since)]
        runs[k] = replace(usual, zero=zero * unit, since=since)
        return runs, [Difference("sensor_zero", name, {names[k]: zero}, since)]
    change, what, value = {
        "load": ("load", ("carried_load", last), float(rng.uniform(0.3, 1.0) * machine.links.mass[-1])),
        "gain": ("gain", ("torque_gain", name), float(np.exp(sign * rng.uniform(0.1, 0.35)))),
        "friction": ("friction", ("friction_level", name), float(np.exp(sign * rng.uniform(0.25, 0.6)))),
        "encoder": ("angle", ("encoder_zero", name), sign * float(rng.uniform(0.05, 0.2))),
        "late clock": ("late", ("clock_offset", None), float(rng.uniform(0.008, 0.025))),
    }[kind]
    usually = {"gain": 1.0, "friction": 1.0, "angle": 0.0}  # what the other joints have
    own = usually[change] + (value - usually[change]) * unit if change in usually else value
    which = which if kind == "load" else which[:1]  # of two and two nobody knows which are usual
    for k in which:
        runs[k] = replace(usual, **{change: own})
    return runs, [Difference(*what, {names[k]: value for k in which})]


def drawn(seed: int, kind: str, *, effect: bool) -> tuple[Model, list[Recording], list[Difference], str]:
    """A model, its recordings, what differs between them, and the effect that is hidden, "" for none."""
    rng = np.random.default_rng(seed)
    machine = machine_of(rng)
    runs, truth = differing(kind, machine, rng)
    hidden = None
    if effect:
        name, j = HIDDEN[int(rng.integers(len(HIDDEN)))], int(rng.integers(machine.count))
        hidden = Hidden(name, j, float(rng.uniform(0.3, 0.8) * EFFECTS[name][0]), rng.random(2))
    joints = tuple(Joint(x, length=float(y)) for x, y in zip(NAMES, machine.links.length, strict=False))
    recordings = []
    for k, run in enumerate(runs):
        motion = waves_of(rng, machine.count)
        tau = torque_of(machine, motion((T - run.late) * (1.0 + run.fast)), run, hidden)
        far = np.where(rng.random(tau.shape) < 0.02, 12.0 * rng.standard_normal(tau.shape), 0.0)
        tau += machine.noise * (rng.standard_normal(tau.shape) + far)
        q = np.round((motion(T).q - run.angle) / 1e-4) * 1e-4
        logged = {}
        if kind == "temperature":
            at, warm = truth[0].joint, run.warm.sum(axis=1)  # of one joint: the others' are zero
            logged = {f"temperature_{at}": Logged(T[::100], 33.0 + 1000.0 * warm[::100] / 15.0, "degC", 0.05)}
        recordings.append(Recording(f"run_{k}", T, q, tau, joints=joints, logged=logged))
    model = Model("chain", limits={}, joints=joints)
    return model, recordings, truth, f"{hidden.effect}:{NAMES[hidden.joint]}" if hidden else ""


def drawn_in_mujoco(seed: int, kind: str, *, effect: bool) -> tuple[Model, list[Recording], list[Difference], str]:
    """The same of MuJoCo's leg."""
    rng, two, none = np.random.default_rng(seed), np.array([0.4, 0.44]), np.zeros(2)
    leg = mujoco_leg.Leg(dry=tuple((np.array([4.0, 3.0]) * rng.uniform(0.6, 1.6, 2)).tolist()))
    links = Links(np.array([9.5, 6.0]), 0.5 * two, two, none, none, none)
    runs, truth = differing(kind, Machine(links, 0.0, mujoco_leg.TORQUE_NOISE, mujoco_leg.FOOT), rng)
    truth = [replace(item, joint="shank") if item.what == "carried_load" else item for item in truth]
    hidden = ""
    if effect:
        rotor = bool(rng.random() < 0.5)
        hidden = "rotor_inertia:knee" if rotor else "biarticular_spring"
        more = {"armature": float(rng.uniform(0.08, 0.2))} if rotor else {"tendon": float(rng.uniform(3.0, 8.0))}
        leg = replace(leg, **more)
    recordings = []
    for k, run in enumerate(runs):
        dry, viscous = (tuple((np.array(x) * run.friction).tolist()) for x in (leg.dry, leg.viscous))
        legs = (leg, replace(leg, dry=dry, viscous=viscous, load=run.load))
        usual, own = (mujoco_leg.simulate(each, seed, k, SECONDS + 1.0, noise=False)[0] for each in legs)
        there, at = (run.since <= T)[:, None], (T - run.late) * (1.0 + run.fast)
        q = np.where(there, own.q[: len(T)], usual.q[: len(T)])
        before, after = (np.column_stack([np.interp(at, each.t, x) for x in each.tau.T]) for each in (usual, own))
        tau = np.where(there, after * run.gain + run.zero, before)
        q = q - run.angle + mujoco_leg.ENCODER_NOISE * rng.standard_normal(q.shape)
        tau = tau + mujoco_leg.TORQUE_NOISE * rng.standard_normal(q.shape)
        recordings.append(Recording(f"run_{k}", T, q, tau))
    return Model.standard(), recordings, truth, hidden


def judged(seed: int, kind: str, *, effect: bool, mujoco: bool = False) -> tuple[str, int, int]:
    """Faults of the answer to a set, "" without any; how many numbers are told, and how many of them hold the truth."""
    model, recordings, truth, hidden = (drawn_in_mujoco if mujoco else drawn)(seed, kind, effect=effect)
    held = int(np.random.default_rng(seed).integers(RUNS))
    answer = discover(model, [r for k, r in enumerate(recordings) if k != held], [recordings[held]])
    pairs = [(said, item) for said in answer.of_recordings for item in truth if item.is_told(said)]
    named = [(item.name, *item.look_alikes) for item in answer.accepted]
    wrong = []
    if not len(pairs) == len(truth) == len(answer.of_recordings):
        wrong.append(f"told {'; '.join(item.sentence for item in answer.of_recordings) or 'nothing'}")
    if (not hidden and named) or (hidden and (len(named) != 1 or hidden not in named[0])):
        wrong.append(f"named {named or 'nothing'} for {hidden or 'nothing'}")
    if answer.verdict != ("adequate" if not hidden else "missing") and not (hidden and answer.verdict == "ambiguous"):
        wrong.append(answer.verdict)
    comparable = [(said, item) for said, item in pairs if item.what != "carried_load" or said.unit == "kg"]
    numbers = [(said.values[run], x) for said, item in comparable for run, x in item.values.items()]
    return "; ".join(wrong), len(numbers), sum(e.low <= x <= e.high for e, x in numbers)


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--sets", type=int, default=50)
    parser.add_argument("--first", type=int, default=0)
    parser.add_argument("--same", action="store_true", help="nothing differs, or torque zeros alone")
    parser.add_argument("--effects", action="store_true", help="an effect is hidden, too")
    parser.add_argument("--mujoco", action="store_true", help="MuJoCo's leg; needs the extra peers")
    asked = parser.parse_args()
    kinds = ("nothing", "zeros") if asked.same else tuple(k for k in KINDS if not (asked.mujoco and k == "temperature"))
    right, of, numbers, inside = Counter[str](), Counter[str](), 0, 0
    for seed in range(asked.first, asked.first + asked.sets):
        kind = kinds[seed % len(kinds)]
        wrong, told, held = judged(seed, kind, effect=asked.effects, mujoco=asked.mujoco)
        of[kind] += 1
        right[kind] += not wrong
        numbers, inside = numbers + told, inside + held
        print(f"{seed:5d} {kind}: {wrong or 'right'} ({held} of {told} intervals)", flush=True)
    for kind in kinds:
        print(f"{kind:20} {right[kind]} of {of[kind]}")
    print(f"{right.total()} of {of.total()} right; {inside} of {numbers} intervals hold the truth")


if __name__ == "__main__":
    main()
