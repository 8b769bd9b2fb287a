"""A plant of equations alone: a planar chain by Newton and Euler, forces first; motion is prescribed.

    JOINTSj@NOISE,RATE/WHAT/SEED: WHAT is hidden, one or two of EFFECTS with "+", or nothing, or outside the catalogue

Angles are relative, from hanging; every link is a body with its centre of mass on it. Nothing here is shared with
exoid's mechanics or with its bench.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from benchmarks.arena.task import Run, Sealed, measured, number_of
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion

SECONDS = 20.0
NAMES = ("hip", "knee", "ankle")
VISIBLE = (1.5, 12.0)
"""What an effect leaves beside the refitted model, in units of the noise in the band, as far as MOST allows."""


@dataclass(frozen=True)
class Links:
    """Masses kg, centres of mass and lengths m, inertias kg·m², dry N·m and viscous N·m·s/rad friction, each (J,)."""

    mass: Float
    along: Float
    length: Float
    inertia: Float
    dry: Float
    viscous: Float


def rigid(links: Links, motion: Motion) -> Float:
    """Return the torques (N, J) of rigid links: accelerations from the base outwards, then forces inwards."""
    phi, omega, alpha = (np.cumsum(x, axis=1) for x in (motion.q, motion.dq, motion.ddq))
    count, joints = phi.shape
    down = np.stack([np.sin(phi), -np.cos(phi)], axis=-1)
    front = np.stack([np.cos(phi), np.sin(phi)], axis=-1)
    turn = alpha[..., None] * front - (omega**2)[..., None] * down
    start, com = np.zeros((count, 2)), []
    for j in range(joints):
        com.append(start + links.along[j] * turn[:, j])
        start = start + links.length[j] * turn[:, j]
    force, moment, out = np.zeros((count, 2)), np.zeros(count), np.zeros((count, joints))
    for j in reversed(range(joints)):
        own = links.mass[j] * (com[j] + np.array([0.0, 9.81]))
        moment = (
            moment
            + links.inertia[j] * alpha[:, j]
            + _cross(links.along[j] * down[:, j], own)
            + _cross(links.length[j] * down[:, j], force)
        )
        force = force + own
        out[:, j] = moment
    return out


def _cross(a: Float, b: Float) -> Float:
    return np.asarray(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0])


@dataclass(frozen=True)
class At:
    """The joint `j` an effect is at, the whole motion, and the rigid torque (N,) there."""

    j: int
    motion: Motion
    load: Float
    drawn: Float

    @property
    def q(self) -> Float:
        return np.asarray(self.motion.q[:, self.j])

    @property
    def v(self) -> Float:
        return np.asarray(self.motion.dq[:, self.j])


Torque = Callable[[At], Float]
EFFECTS: dict[str, tuple[float, Torque]] = {
    "stribeck": (4.0, lambda a: np.exp(-((a.v / (0.08 + 0.12 * a.drawn[0])) ** 2)) * np.sign(a.v)),
    "load_friction": (0.35, lambda a: np.abs(a.load) * np.sign(a.v)),
    "viscous_quadratic": (3.0, lambda a: a.v * np.abs(a.v)),
    "viscous_power": (3.0, lambda a: np.sign(a.v) * np.abs(a.v) ** (0.3 + 0.4 * a.drawn[0])),
    "viscous_asymmetry": (2.0, lambda a: np.abs(a.v)),
    "torque_ripple": (1.5, lambda a: np.sin(round(10 + 25 * a.drawn[0]) * a.q + 6.0 * a.drawn[1])),
    "hardening_spring": (12.0, lambda a: a.q**3),
    "end_stop": (60.0, lambda a: np.maximum(a.q - (0.25 + 0.15 * a.drawn[0]), 0.0)),
    "position_friction": (2.0, lambda a: np.sin(a.q) * np.sign(a.v)),
    "friction_drift": (3.0, lambda a: np.exp(-a.motion.t / (4.0 + 4.0 * a.drawn[0])) * np.sign(a.v)),
    "rotor_inertia": (0.2, lambda a: np.asarray(a.motion.ddq[:, a.j])),
}
"""Largest coefficient, and the torque in N·m at a coefficient of one."""
OUTSIDE: dict[str, tuple[float, Torque]] = {
    "angle_bump": (8.0, lambda a: np.exp(-(((a.q - 0.3 * a.drawn[0]) / 0.12) ** 2))),
    "speed_bump": (8.0, lambda a: np.exp(-(((a.v - 0.4 - 0.3 * a.drawn[0]) / 0.15) ** 2))),
}
"""The same of what the catalogue does not have."""
KINDS = {
    "1j@0.02,100": "nothing viscous_quadratic:axis stribeck:axis torque_ripple:axis load_friction:axis",
    "1j@0.1,500": "nothing stribeck:axis end_stop:axis position_friction:axis viscous_power:axis",
    "1j@0.5,200": "nothing viscous_asymmetry:axis load_friction:axis angle_bump:axis speed_bump:axis",
    "2j@0.02,200": "nothing load_friction:knee stribeck:hip rotor_inertia:knee viscous_quadratic:hip+end_stop:knee",
    "2j@0.1,100": "nothing torque_ripple:knee friction_drift:hip end_stop:hip stribeck:hip+load_friction:knee",
    "2j@0.5,500": "nothing viscous_quadratic:knee load_friction:hip viscous_power:knee angle_bump:knee",
    "3j@0.05,100": "nothing stribeck:ankle load_friction:hip rotor_inertia:ankle viscous_asymmetry:knee",
    "3j@0.3,100": "nothing end_stop:ankle torque_ripple:hip load_friction:knee+viscous_quadratic:ankle speed_bump:hip",
}
"""Joints, noise N·m and rate Hz, and what is hidden."""


def names(other: int = 0) -> list[str]:
    """Return every case of this plant; with `other`, of other motions and machines."""
    seeds = (1 + other, 2 + other)
    return [f"{kind}/{what}/{seed}" for kind, all_ in KINDS.items() for seed in seeds for what in all_.split()]


def draw(name: str) -> Sealed:
    """Return the case of this name."""
    head, what, _ = name.split("/")
    count, (noise, rate) = int(head[0]), map(float, head.partition("@")[2].split(","))
    rng = np.random.default_rng(number_of(name))
    labels = ("axis",) if count == 1 else NAMES[:count]
    usual = np.array([3.0, 2.0, 1.0])[:count] * rng.uniform(0.7, 1.3, count)
    length = np.array([0.42, 0.40, 0.2])[:count] * rng.uniform(0.9, 1.1, count)
    links = Links(
        usual,
        length * rng.uniform(0.4, 0.6, count),
        np.round(length, 3),
        usual * length**2 / 12.0 * rng.uniform(0.8, 1.3, count),
        rng.uniform(0.6, 1.5, count),
        rng.uniform(0.3, 1.2, count),
    )
    motions = [_motion(rng, count, rate) for _ in range(5)]
    torques = [rigid(links, m) + links.dry * np.sign(m.dq) + links.viscous * m.dq for m in motions]
    joints = tuple(Joint(label, length=float(one)) for label, one in zip(labels, links.length, strict=True))
    model = Model("chain", limits={}, joints=joints)
    small = np.full(count, noise)

    def sealed(added: list[Float], hidden: tuple[str, ...]) -> Sealed:
        runs = (
            Run(Recording(f"run_{k}", m.t, m.q, base + more, joints=joints), m, base + more)
            for k, (m, base, more) in enumerate(zip(motions, torques, added, strict=True))
        )
        return Sealed(model, tuple(runs), hidden, small)

    added, hidden = [np.zeros_like(torque) for torque in torques], []
    for term in [] if what == "nothing" else what.split("+"):
        effect, _, joint = term.partition(":")
        most, torque = (EFFECTS | OUTSIDE)[effect]
        j, drawn = labels.index(joint), rng.random(2)
        mine = [np.zeros_like(x) for x in torques]
        for own, m in zip(mine, motions, strict=True):
            own[:, j] = torque(At(j, m, rigid(links, m)[:, j], drawn))
        wanted = math.exp(rng.uniform(*np.log(VISIBLE))) / sealed(mine, ()).size
        added = [x + min(wanted, most) * own for x, own in zip(added, mine, strict=True)]
        hidden += [term] if effect in EFFECTS else []
    clean = sealed(added, tuple(hidden))
    return Sealed(model, tuple(measured(run, small, rng, step=2e-5) for run in clean.runs), clean.hidden, small)


def _motion(rng: np.random.Generator, joints: int, rate: float) -> Motion:
    """Return a sum of five sines per joint, at most 0.6 rad from hanging and 2.2 rad/s."""
    t = np.arange(round(SECONDS * rate)) / rate
    parts = []
    for _ in range(joints):
        w = 2.0 * math.pi * rng.uniform(0.1, 0.7, 5)
        size, phase = rng.uniform(0.3, 1.0, 5) / w**0.5, rng.uniform(0.0, 2.0 * math.pi, 5)
        wave, slope = np.sin(w * t[:, None] + phase), np.cos(w * t[:, None] + phase)
        q, v, a = wave @ size, slope @ (size * w), -wave @ (size * w**2)
        scale = min(0.6 / np.abs(q).max(), 2.2 / np.abs(v).max())
        parts.append((scale * q, scale * v, scale * a))
    q, v, a = (np.column_stack(part) for part in zip(*parts, strict=True))
    return Motion(t, q, v, a)
