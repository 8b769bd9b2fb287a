"""The leg that `benchmarks/watch.py` watches: its motions, what changes in it and when, and the samples it gives."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.signal import butter, sosfiltfilt

from exoid.apps.watch.front import CUTOFF
from exoid.measurement.bench.deflection import at_encoders, rigid_torque
from exoid.measurement.bench.equation import split_channel
from exoid.measurement.bench.hidden import Hidden, true_model
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.sensors import Sensors
from exoid.measurement.bench.simulation import Bench, run_bench
from exoid.measurement.trajectories.trajectory import CENTRE, Fourier, random_trajectory
from exoid.symbolic.effect_catalogue import catalogue
from exoid.symbolic.mechanics.payload import LINKS, Payload
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion

LEAVE_OUT = ("drift", "base")
"""Families whose effects do not appear at a moment."""
PERIOD = 47.0
"""s after which a motion repeats."""


STILL, BLEND, SOME = 2.0, 5.0, (60.0, 300.0)
"""s at rest before and after a motion that wanders, s in which it becomes another one, and how long it stays one."""


def motion(seed: int) -> Fourier:
    """Return a motion that does not repeat for most of a minute."""
    return random_trajectory(np.random.default_rng([seed, 5]), period=PERIOD, harmonics=24)


@dataclass(frozen=True, eq=False)
class Wandering:
    """A motion that becomes another one every few minutes: other angles, 0.3 to 1 of the size, half to all of the
    speed.

    From `begins` (S,) s on it goes to and then along paths[k], `sizes` (S,) about the centre of each and `speeds` (S,).
    The first and the last are rest, at one place for all, so that one such motion can follow another.
    """

    begins: np.ndarray
    paths: tuple[Fourier, ...]
    sizes: np.ndarray
    speeds: np.ndarray

    @classmethod
    def of(cls, seed: int, seconds: float) -> Wandering:
        """Draw motion number `seed`."""
        rng = np.random.default_rng([seed, 17])
        begins = [0.0, STILL]
        while begins[-1] < seconds - SOME[1]:
            begins.append(begins[-1] + float(rng.uniform(*SOME)))
        begins[-1] = seconds - STILL - BLEND
        count = len(begins)
        rest = Fourier(np.array(CENTRE), np.zeros((2, 1)), np.zeros((2, 1)), PERIOD)
        paths = (rest, *(motion(int(rng.integers(1_000_000))) for _ in range(count - 2)), rest)
        sizes = np.exp(rng.uniform(np.log(0.3), 0.0, count))
        return cls(np.array(begins), paths, sizes, rng.uniform(0.5, 1.0, count))

    def at(self, t: np.ndarray) -> Motion:
        """Return angle, velocity and acceleration at times `t` (N,) in s."""
        q, dq, ddq = self._along(0, t)
        for k, begin in enumerate(self.begins[1:], start=1):
            here = t > begin
            x = np.clip((t[here] - begin) / BLEND, 0.0, 1.0)[:, None]
            share = x**3 * (10.0 - 15.0 * x + 6.0 * x**2)
            rate, bend = 30.0 * (x * (1.0 - x)) ** 2 / BLEND, 60.0 * x * (1.0 - x) * (1.0 - 2.0 * x) / BLEND**2
            more = [new - old[here] for new, old in zip(self._along(k, t[here]), (q, dq, ddq), strict=True)]
            q[here] += share * more[0]
            dq[here] += share * more[1] + rate * more[0]
            ddq[here] += share * more[2] + 2.0 * rate * more[1] + bend * more[0]
        return Motion(t, q, dq, ddq)

    def _along(self, k: int, t: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        path, size, speed = self.paths[k], float(self.sizes[k]), float(self.speeds[k])
        m = path.at(speed * (t - self.begins[k]))
        return path.offset + size * (m.q - path.offset), size * speed * m.dq, size * speed**2 * m.ddq


@dataclass(frozen=True, eq=False)
class Truth:
    """One motion of the bench: that of the links, and the torque (N, J) it takes without any effect."""

    link: Motion
    torque: np.ndarray

    @classmethod
    def of(cls, seed: int, seconds: float, folder: Path | None = None, *, wanders: bool = False) -> Truth:
        """Simulate motion number `seed`, or take it from `folder`, where it is kept."""
        kind = "wandering" if wanders else "motion"
        kept = None if folder is None else folder / f"{kind}_{seed}_{seconds:g}.npz"
        if kept is not None and kept.exists():
            with np.load(kept) as found:
                return cls(Motion(*(found[name] for name in ("t", "q", "dq", "ddq", "sign"))), found["torque"])
        path: Any = Wandering.of(seed, seconds) if wanders else motion(seed)
        made = run_bench(seed=seed, excitation=path, bench=Bench(duration=seconds))
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

    @classmethod
    def joined(cls, parts: Sequence[Truth]) -> Truth:
        """Return several one after the other."""
        step = parts[0].link.t[1] - parts[0].link.t[0]
        q, dq, ddq, sign = (np.concatenate([getattr(p.link, n) for p in parts]) for n in ("q", "dq", "ddq", "sign"))
        return cls(Motion(step * np.arange(len(q)), q, dq, ddq, sign), np.concatenate([p.torque for p in parts]))

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
        for effect in catalogue(worn=False).values()
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
