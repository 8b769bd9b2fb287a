"""The virtual test bench: a leg in closed loop, measured by imperfect instruments, with an effect hidden in
it.

    excitation -> controller -> motors -> leg with its effects -> instruments -> Recording

The leg obeys the torque of the given model plus the hidden effects, so the same equation that is later
identified produces the data; how it is integrated is told in `plant.py`. Effects that are not in the leg but
in the torque channel (a drive's gain, a delay, anything written with `tau_model`) are applied to the measured
torque, and what gives way between link and encoder to the measured angle.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from exoid.ground.errors import EffectError, ExoidError
from exoid.measurement.bench.controller import Controller
from exoid.measurement.bench.deflection import at_encoders, rigid_torque
from exoid.measurement.bench.equation import split_channel, stepper
from exoid.measurement.bench.hidden import Hidden, TrueModel, hidden_in, true_model
from exoid.measurement.bench.leg import Leg, standard_leg
from exoid.measurement.bench.machine import Machine, standard_machine
from exoid.measurement.bench.seal import HiddenTruth, Truth
from exoid.measurement.bench.sensors import Sensors
from exoid.measurement.bench.sway import ACCELERATION_NOISE, base_motion
from exoid.measurement.bench.walk import Gait, Walk
from exoid.measurement.bench.wearer import Wearer, borne, pushed_leg, pushes, recorded, sensed, switch
from exoid.measurement.recording import Recording
from exoid.measurement.selection import swings
from exoid.measurement.trajectories.trajectory import Fourier, random_trajectory
from exoid.symbolic.effect import Effect
from exoid.symbolic.joints import is_leg, machine_word
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion

STEP = 1e-3
"""s. Longest inner step; the control loop runs at the same rate, as drives do."""

LEAD_IN = 1.0
"""s of motion before the recording starts, in which the controller settles."""

BLOCK = 500
"""Inner steps that one call of the compiled step runs through."""


FeedForward = Callable[[Motion], Float]
"""From a wanted motion to torques (N, J) in N·m."""


class BenchError(ExoidError):
    """A simulation that makes no sense: impossible settings, or a leg that ran away."""


LONGEST, FASTEST, MOST_SAMPLES = 1e5, 1e5, 1e7
"""s, Hz, and samples of one run."""


@dataclass(frozen=True, eq=False)
class BenchRun:
    """One run of the bench: the `recording` a user gets, and what only the bench knows.

    `motion` is the true motion at the recording's times (with the true sign of friction, fractional where a
    joint sticks), `torque` (N, J) N·m what faultless torque sensors would have shown, `true` the model obeyed
    and `saturated` the share of time in which a motor was at its limit.
    """

    recording: Recording
    motion: Motion
    torque: Float
    true: TrueModel
    truth: Truth
    saturated: float


@dataclass(frozen=True)
class Bench:
    """Settings that stay the same from run to run; see `Controller`, `Sensors` and `simulate`."""

    duration: float = 30.0
    rate: float = 100.0
    controller: Controller = field(default_factory=Controller)
    sensors: Sensors = field(default_factory=Sensors)
    step: float = STEP
    lead_in: float = LEAD_IN
    wearer: Wearer | None = None
    """Someone who pushes at the cuffs."""
    walk: Walk | None = None
    """Instead of a motion that is drawn, a leg that walks, and the ground under its foot."""
    measured: tuple[str, ...] | None = None
    """What recordings have of what pushes: of "cuffs", "plate" and "switch"; None: every force that acts."""

    def __post_init__(self) -> None:
        if self.measured is not None:
            object.__setattr__(self, "measured", sensed(self.measured))
        if not (self.rate > 0 and self.lead_in >= 0 and 0 < self.step <= STEP):
            what = f"rate {self.rate} Hz, step {self.step} s, lead-in {self.lead_in} s"
            raise BenchError(what, remedy=f"the rate must be positive and the step at most {STEP} s")
        if not (math.isfinite(self.duration) and self.duration * self.rate >= 2):
            raise BenchError(f"{self.duration} s at {self.rate} Hz is less than two samples")
        if self.duration * self.rate > MOST_SAMPLES or self.duration > LONGEST or self.rate > FASTEST:
            what = f"{self.duration:g} s at {self.rate:g} Hz"
            raise BenchError(what, remedy=f"give at most {LONGEST:g} s, {FASTEST:g} Hz and {MOST_SAMPLES:g} samples")

    @property
    def steps_per_sample(self) -> int:
        """Inner steps from one sample to the next."""
        return max(1, math.ceil(1.0 / (self.rate * self.step) - 1e-9))


def simulate(
    model: Model | None = None,
    leg: Leg | Machine | None = None,
    *,
    effects: str | Hidden | Iterable[str | Hidden] = (),
    seed: int = 0,
    excitation: Fourier | None = None,
    bench: Bench | None = None,
    duration: float | None = None,
    rate: float | None = None,
    name: str = "run",
) -> Recording:
    """Return a Recording of `leg` moving along `excitation` with `effects` ("stribeck:knee", "stribeck:knee=0.8" or
    Hidden, one or many) hidden in it.

    `model` (the standard leg's) gives geometry, limits and the terms known already; `excitation` None draws a
    fresh motion from `seed`; `duration` in s and `rate` in Hz override those of `bench`. The same arguments
    give the same numbers. As on reading, torques of stance are left out where a foot switch says when that is and no
    plate what the ground does. Raises EffectError for an unknown effect and BenchError when the leg runs away.
    """
    settings = _settings(bench, duration, rate)
    run = run_bench(model, leg, effects=effects, seed=seed, excitation=excitation, bench=settings, name=name)
    return swings(run.recording)


def simulate_runs(
    count: int,
    model: Model | None = None,
    leg: Leg | Machine | None = None,
    *,
    effects: str | Hidden | Iterable[str | Hidden] = (),
    seed: int = 0,
    excitation: Fourier | None = None,
    bench: Bench | None = None,
    name: str = "run",
) -> tuple[BenchRun, ...]:
    """Return `count` runs of the same leg with the same hidden effects, each on a motion of its own.

    With `excitation` all follow that motion; only noise and disturbances then differ.
    """
    hidden = hidden_in(effects)
    return tuple(
        run_bench(
            model, leg, effects=hidden, seed=seed, index=k, excitation=excitation, bench=bench, name=f"{name}_{k}"
        )
        for k in range(count)
    )


def run_bench(
    model: Model | None = None,
    leg: Leg | Machine | None = None,
    *,
    effects: str | Hidden | Iterable[str | Hidden] = (),
    seed: int = 0,
    index: int = 0,
    excitation: Fourier | None = None,
    bench: Bench | None = None,
    name: str = "run",
    feed_forward: FeedForward | None = None,
) -> BenchRun:
    """Return the result of `simulate` together with the truth; `index` numbers the runs that share one `seed`.

    `feed_forward` gives the torque (N, J) in N·m that the drives add to the controller's along the wanted motion.
    """
    model = Model.standard() if model is None else model
    if isinstance(leg, (str, Effect, Hidden)):
        raise EffectError("an effect is hidden by `effects`", remedy='simulate(model, effects="stribeck:knee")')
    leg = bench_machine(model) if leg is None else leg
    bench = Bench() if bench is None else bench
    _check_fits(model, leg, bench, excitation)
    hidden = hidden_in(effects)
    # Motion, control noise and instrument noise have streams of their own: hiding an effect leaves the noise
    # as it is.
    motion_rng, control_rng, sensor_rng = (np.random.default_rng([seed, index, stream]) for stream in range(3))
    gait = None if bench.walk is None else bench.walk.drawn(motion_rng)
    path = gait or excitation or random_trajectory(motion_rng, model.motion_limits)
    model = pushed_leg(model, bench.wearer, gait)
    base_seed = [seed, index, 3]
    true = true_model(model, _carried(model, leg), hidden)
    mechanical, heard = split_channel(true)
    trace = _drive(mechanical, true, leg, path, bench, control_rng, feed_forward, base_seed)
    link, motion, torque = trace.link, trace.read, trace.motor
    if heard is not mechanical:
        torque = torque + heard.torque(link) - mechanical.torque(link)
    if motion is not link:
        sides = (mechanical.torque(at) - rigid_torque(mechanical, at) for at in (motion, link))
        torque = torque + next(sides) - next(sides)
    return BenchRun(
        recording=_measure(motion, torque, bench, sensor_rng, name, leg, model),
        motion=motion,
        torque=torque,
        true=true,
        truth=_truth(true, leg, hidden, seed),
        saturated=trace.saturated,
    )


def _carried(model: Model, leg: Leg | Machine) -> tuple[float, ...]:
    """Return the numbers of a leg with the limb of its wearer, where the model knows one."""
    own = np.array(leg.base)
    if model.wearer is not None:
        own[: len(model.inertial)] += model.wearer.added(model)
    return tuple(own.tolist())


def bench_machine(model: Model) -> Leg | Machine:
    """Return the machine that the bench moves for `model`: the standard leg, or a machine of its joints."""
    return standard_machine(model) if model.chain else standard_leg()


def _check_fits(model: Model, leg: Leg | Machine, bench: Bench, excitation: Fourier | None) -> None:
    """Refuse a leg for another machine, a wearer of anything but a leg, and a walk along another motion."""
    if len(leg.base) != model.base_count:
        what = f"{leg.name} has {len(leg.base)} base parameters, the model {model.base_count}"
        raise BenchError(what, where=model.name, remedy="leave it out: the bench makes a machine for every model")
    if bench.wearer is not None and model.chain and not model.forces:
        raise BenchError("only the leg has cuffs that a wearer pushes at", where=model.name, remedy="leave wearer out")
    if bench.walk is not None and not is_leg(model.joints):
        raise BenchError("only a leg of hip and knee walks", where=model.name, remedy="leave the walk out")
    if bench.walk is not None and excitation is not None:
        raise BenchError("a leg that walks follows no other motion", remedy="leave the walk or the motion out")


@dataclass(frozen=True, eq=False)
class _Trace:
    """The result of the integration at the sample times; `motor` (N, J)."""

    link: Motion
    read: Motion
    """The motion at the encoders: that of the links, unless a drive gives way."""
    motor: Float
    saturated: float


def _settings(bench: Bench | None, duration: float | None, rate: float | None) -> Bench:
    bench = Bench() if bench is None else bench
    bench = bench if duration is None else replace(bench, duration=duration)
    return bench if rate is None else replace(bench, rate=rate)


def _drive(
    mechanical: TrueModel,
    true: TrueModel,
    leg: Leg | Machine,
    path: Fourier | Gait,
    bench: Bench,
    rng: np.random.Generator,
    feed_forward: FeedForward | None,
    base_seed: Sequence[int],
) -> _Trace:
    """Integrate the closed loop through lead-in and recording."""
    per_sample = bench.steps_per_sample
    dt = 1.0 / (bench.rate * per_sample)
    before = round(bench.lead_in / dt)
    count = before + (round(bench.duration * bench.rate) - 1) * per_sample + 1
    t = (np.arange(count) - before) * dt
    # The controller acts at the start of a step, half a step before the time stamp the step is centred on.
    wanted = path.at(t - 0.5 * dt)
    joints = mechanical.model.joints
    reach = np.array([joint.reach for joint in joints])
    noise = bench.sensors.encoder_noise * reach * rng.standard_normal((count, len(joints)))
    model, outside = mechanical.model, []
    added = np.zeros((count, len(joints))) if feed_forward is None else np.asarray(feed_forward(wanted), dtype=float)
    base = None
    if mechanical.model.moving_base:
        base = base_motion(np.asarray(t, dtype=float), np.random.default_rng(base_seed), model.spatial)
        outside.append(base)
    gait = path if isinstance(path, Gait) else None
    force = pushes(model, bench.wearer, gait, np.asarray(t, dtype=float), rng) if model.forces else None
    if gait is not None and force is not None:
        added = added + borne(model, wanted, force)
    outside += [] if force is None else [force]
    given = np.column_stack([t, wanted.q, wanted.dq, noise, added, *outside]).T
    numbers = _numbers(mechanical, leg, bench, dt)
    plant = stepper(mechanical.model, dt)
    begin = (float(t[0]), wanted.q[0], wanted.dq[0], wanted.ddq[0])
    first = (np.zeros(0) if part is None else part[0] for part in (base, force))
    record = integrate(plant.step, plant.start(*begin, mechanical.linear, mechanical.shape, *first), given, numbers)
    states = record.reshape(6, len(joints), -1)
    where = ", ".join(term.name for term in mechanical.model.terms) or leg.name
    _check_sane(states, reach, machine_word(joints), where)
    kept = slice(before, None, per_sample)
    at_limit = np.abs(states[4][:, kept]) >= np.array(leg.torque_limit)[:, None] * (1.0 - 1e-12)
    q, dq, ddq, sign = (states[k].T for k in range(4))
    whole = Motion(np.asarray(t, dtype=float), q, dq, ddq, sign, base=base, force=force)
    seen = at_encoders(true, mechanical, whole)
    link = _sampled(whole, kept)
    read = link if seen is whole else _sampled(seen, kept)
    return _Trace(link, read, states[4][:, kept].T + added[kept], float(at_limit.any(axis=0).mean()))


def _sampled(motion: Motion, kept: slice) -> Motion:
    base, force = (None if part is None else part[kept] for part in (motion.base, motion.force))
    t, q, dq, ddq, sign = (part[kept] for part in (motion.t, motion.q, motion.dq, motion.ddq, motion.sign))
    return Motion(t, q, dq, ddq, sign, base=base, force=force)


def _check_sane(states: Float, reach: Float, machine: str, where: str) -> None:
    """Raise BenchError when the machine ran away, or when too many steps do not satisfy the equation of motion.

    `states` (6, J, N) are those of `plant.step_function`.
    """
    wild = not np.isfinite(states).all() or np.abs(states[1] / reach[:, None]).max() > 100.0
    if wild or np.mean(np.abs(states[5]) > 0.1) > 0.01:
        what = f"the {machine} ran away: faster than 100 rad/s, or its equation of motion has no sensible solution"
        remedy = "make the hidden effects smaller or give them their other sign, or stiffen the controller"
        raise BenchError(what, where=where, remedy=remedy)


def integrate(step: Any, state: Float, given: Float, numbers: Float) -> Float:
    """Run `step` (see `plant.step_function`) from `state` along `given` (1 + 4J, N); return records (6J, N)."""
    count = given.shape[1]
    blocks = -(-count // BLOCK)
    # Every block has the same length, so that one compiled map serves; the tail repeats the last input.
    padded = np.concatenate([given, np.repeat(given[:, -1:], blocks * BLOCK - count, axis=1)], axis=1)
    run_block = step.mapaccum("block", BLOCK)
    records = []
    for k in range(blocks):
        states, record = run_block(state, padded[:, k * BLOCK : (k + 1) * BLOCK], numbers)
        state = states[:, -1]
        records.append(record.full())
    return np.concatenate(records, axis=1)[:, :count]


def _numbers(true: TrueModel, leg: Leg | Machine, bench: Bench, dt: float) -> Float:
    """Return the vector `numbers` of `plant.step_function`."""
    fixed = [bench.controller.smoothing(dt), bench.sensors.resolution]
    gains = bench.controller.gains(leg).ravel()
    return np.concatenate([gains, leg.torque_limit, fixed, true.linear, true.shape])


def _measure(
    motion: Motion,
    torque: Float,
    bench: Bench,
    rng: np.random.Generator,
    name: str,
    leg: Leg | Machine,
    model: Model,
) -> Recording:
    """Return the recording that the instruments and the logger make of the truth."""
    sensors = bench.sensors
    reach = np.array([joint.reach for joint in model.joints])
    t, q = sensors.clock(motion.t, rng), sensors.angle(motion.q, rng, reach)
    tau = sensors.torque(torque, bench.rate, rng, np.array(leg.sensor_scale))
    forces: dict[str, Float] = {}
    contact: Float | None = None
    if motion.force is not None:
        noisy = motion.force + sensors.of_forces(model.forces) * rng.standard_normal(motion.force.shape)
        channels = zip(model.channels, recorded(model, bench.measured), sensors.logged(noisy, fewer=2).T, strict=True)
        forces = {name: values for name, there, values in channels if there}
        contact = switch(model, motion.force) if "switch" in (bench.measured or ()) else None
    logged = sensors.logged(t), sensors.logged(q), sensors.logged(tau, fewer=2)
    base: Float | None = None
    if motion.base is not None:
        turns = motion.base.shape[1] // 4  # one angle with five columns, three with twelve
        leaning = sensors.angle(motion.base[:, :turns], rng, np.ones(turns))
        carried = motion.base[:, 3 * turns :]
        carried = carried + ACCELERATION_NOISE * rng.standard_normal(carried.shape)
        base = sensors.logged(np.column_stack([leaning, carried]))
    return Recording(name, *logged, forces=forces, joints=model.joints, base=base, contact=contact)


def _truth(true: TrueModel, leg: Leg | Machine, hidden: tuple[Hidden, ...], seed: int) -> Truth:
    numbers = true.numbers()
    names = {entry.name for entry in hidden}
    effects = tuple(
        HiddenTruth(
            term.effect.id,
            term.joint,
            {key.rpartition(".")[2]: value for key, value in numbers.items() if key.startswith(f"{term.name}.")},
        )
        for term in true.model.terms
        if term.name in names
    )
    return Truth(leg.name, leg.base, effects, seed)
