"""Chains of one and of three joints in MuJoCo, a plant that is not ours, with one effect built into each.

    python benchmarks/mujoco_chains.py                                     every case once
    python benchmarks/mujoco_chains.py end_stop:ankle --seeds 3 --first 7

Rigid bodies, dry friction and rotors are MuJoCo's, its solver decides about stick and slip; what else is built in is
a load, or a loss of friction, written here. Each case is three runs of 30 s to fit and one to verify, under PD control
with a feedforward, with quantised angles, noise and outliers; masses, motion and sizes are drawn. A case is right when
what was built in is named, or is a look-alike of what is named, and nothing else. Needs the extra `peers`.
"""

from __future__ import annotations

import math
import sys
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from benchmarks.mujoco_leg import ask, names_right  # noqa: E402 - the repository must be on the path first
from exoid.diagnosis.discovery import discover  # noqa: E402
from exoid.measurement.recording import Recording  # noqa: E402
from exoid.symbolic.joints import Joint  # noqa: E402
from exoid.symbolic.model import Model  # noqa: E402
from exoid.symbolic.motion import Motion  # noqa: E402

Float = NDArray[np.float64]
STEP, EVERY, SECONDS = 5e-4, 20, 30.0
"""s of MuJoCo and of the controller; steps from one sample to the next, 100 Hz; s of a run."""
QUANTUM, OUTLIERS = 1e-4, 0.04
"""rad of the encoders; share of torques that are off by some twelve times the noise."""


@dataclass(frozen=True)
class Link:
    """A joint and its link, in SI units: ranges of motion, and what mass, damping and dry friction are drawn from.

    `size` is that of an effect here beside one at a hip.
    """

    name: str
    length: float
    position: tuple[float, float]
    velocity: float
    acceleration: float
    mass: tuple[float, float]
    viscous: tuple[float, float]
    dry: tuple[float, float]
    noise: float
    gains: tuple[float, float]
    size: float


LEG = (
    Link("hip", 0.42, (-0.3, 1.2), 1.9, 5.0, (4.0, 8.0), (0.5, 2.0), (1.5, 3.0), 0.5, (400.0, 25.0), 1.0),
    Link("knee", 0.40, (-1.6, -0.2), 1.7, 5.0, (2.0, 4.0), (0.3, 1.2), (0.75, 1.5), 0.35, (250.0, 15.0), 0.8),
    Link("ankle", 0.20, (-0.5, 0.6), 2.5, 8.0, (0.8, 1.5), (0.3, 1.2), (0.75, 1.5), 0.2, (80.0, 4.0), 0.5),
)
DRIVE = (Link("axis", 0.40, (-1.1, 1.1), 2.2, 6.0, (2.0, 4.0), (0.5, 1.5), (1.0, 2.0), 0.2, (400.0, 25.0), 1.0),)


@dataclass(frozen=True)
class Now:
    """The state of the joint that an effect is at: s, rad, rad/s, its rigid-body torque in N·m; rad, the `middle` of
    its range and `half` of its width.
    """

    t: float
    q: float
    v: float
    rigid: float
    middle: float
    half: float


@dataclass(frozen=True)
class Built:
    """How an effect is built: `where` it acts, the ranges of its numbers, and its value.

    Where: "load" and "loss" of friction at its joint in N·m, "across" the joint and the next one (a load of both, the
    angles added), a part of the bodies ("rotor" kg·m², "sideways" m, "tilt" rad), or a channel ("angle" rad, "gain",
    "delay" s). Numbers in `sized` are smaller at a smaller joint.
    """

    where: str
    ranges: Mapping[str, tuple[float, float]]
    value: Callable[[Mapping[str, float], Now], float] = lambda p, now: p["c"]
    sized: tuple[str, ...] = ("c",)


EFFECTS = {
    "stribeck": Built(
        "loss", {"c": (1.5, 3.0), "v_s": (0.08, 0.25)}, lambda p, now: p["c"] * math.exp(-((now.v / p["v_s"]) ** 2))
    ),
    "load_friction": Built("loss", {"c": (0.12, 0.3)}, lambda p, now: p["c"] * abs(now.rigid), ()),
    "position_friction": Built("loss", {"c": (0.6, 1.2)}, lambda p, now: p["c"] * math.sin(now.q)),
    "friction_drift": Built(
        "loss", {"c": (1.5, 2.5), "T": (8.0, 15.0)}, lambda p, now: p["c"] * math.exp(-now.t / p["T"])
    ),
    "joint_spring": Built(
        "load", {"k": (3.0, 6.0), "c": (-1.0, 1.0)}, lambda p, now: p["k"] * now.q + p["c"], ("k", "c")
    ),
    "hardening_spring": Built("load", {"c": (6.0, 12.0)}, lambda p, now: p["c"] * (now.q - now.middle) ** 3),
    "end_stop": Built(
        "load",
        {"c": (25.0, 50.0), "at": (0.43, 0.67)},
        lambda p, now: p["c"] * max(0.0, now.q - now.middle - p["at"] * now.half),
    ),
    "passive_exponential": Built(
        "load", {"c": (0.15, 0.3), "k": (4.0, 8.0)}, lambda p, now: p["c"] * math.exp(p["k"] * (now.q - now.middle))
    ),
    "torque_ripple": Built(
        "load", {"a": (0.6, 1.2), "n": (8.0, 40.0)}, lambda p, now: p["a"] * math.sin(p["n"] * now.q), ("a",)
    ),
    "torque_offset": Built("load", {"c": (0.8, 1.6)}),
    "torque_drift": Built("load", {"c": (0.03, 0.06)}, lambda p, now: p["c"] * now.t),
    "viscous_quadratic": Built("load", {"c": (0.8, 1.6)}, lambda p, now: p["c"] * now.v * abs(now.v)),
    "viscous_asymmetry": Built("load", {"c": (0.7, 1.5)}, lambda p, now: p["c"] * abs(now.v)),
    "biarticular_spring": Built("across", {"k": (3.0, 6.0)}, lambda p, now: p["k"] * now.q, ()),
    "cross_viscous": Built("across", {"c": (0.8, 1.6)}, lambda p, now: p["c"] * now.v, ()),
    "rotor_inertia": Built("rotor", {"c": (0.03, 0.08)}, sized=()),
    "com_offset": Built("sideways", {"c": (0.015, 0.03)}, sized=()),
    "gravity_tilt": Built("tilt", {"c": (0.04, 0.08)}, sized=()),
    "encoder_offset": Built("angle", {"c": (0.05, 0.1)}, sized=()),
    "drive_gain": Built("gain", {"c": (0.08, 0.15)}, sized=()),
    "time_delay": Built("delay", {"c": (0.015, 0.03)}, sized=()),
}
JOINTS = {
    "nothing": "axis hip",
    "stribeck": "axis knee",
    "load_friction": "axis hip",
    "joint_spring": "ankle axis",
    "rotor_inertia": "knee ankle",
    "torque_ripple": "axis hip",
    "torque_offset": "axis knee",
    "viscous_quadratic": "ankle axis",
    "viscous_asymmetry": "hip axis",
    "hardening_spring": "axis knee",
    "end_stop": "axis ankle hip",
    "passive_exponential": "ankle axis",
    "position_friction": "axis",
    "encoder_offset": "knee ankle",
    "time_delay": "axis knee",
    "friction_drift": "axis hip",
    "torque_drift": "axis",
    "com_offset": "knee ankle",
    "gravity_tilt": "axis",
    "biarticular_spring": "hip knee",
    "cross_viscous": "hip",
    "drive_gain": "knee",
}
"""Joints of the drive or of the leg at which an effect is built."""
CASES = [f"{effect}:{joint}" for effect, joints in JOINTS.items() for joint in joints.split()]
"""What is built, and at which joint."""


@dataclass(frozen=True)
class Chain:
    """A chain of `links` with the effect `built` at joint `j` (None: nothing), its `numbers`, and drawn bodies."""

    links: tuple[Link, ...]
    j: int
    built: Built | None
    numbers: Mapping[str, float]
    xml: str

    @classmethod
    def of(cls, case: str, rng: np.random.Generator) -> Chain:
        """Return a chain drawn for a case "effect:joint"."""
        effect, joint = case.split(":")
        links = DRIVE if joint == DRIVE[0].name else LEG
        j = [link.name for link in links].index(joint)
        built = EFFECTS.get(effect)
        numbers = {}
        for name, (low, high) in {} if built is None else built.ranges.items():
            drawn = float(rng.uniform(low, high))
            numbers[name] = drawn * links[j].size if built is not None and name in built.sized else drawn
        if "n" in numbers:
            numbers["n"] = round(numbers["n"])
        made = cls(links, j, built, numbers, "")
        return cls(links, j, built, numbers, made._bodies(rng))

    @property
    def joints(self) -> tuple[Joint, ...]:
        """Its joints, as a model has them."""
        return tuple(Joint(link.name, length=link.length) for link in self.links)

    def part(self, where: str) -> Float:
        """Return (J,): the constant that is built in at `where`, 0 at joints that have none."""
        found = np.zeros(len(self.links))
        if self.built is not None and self.built.where == where:
            found[self.j] = self.numbers["c"]
        return found

    def acts(self, t: float, q: Float, v: Float, rigid: Float) -> tuple[Float, Float]:
        """Return what loads the drives and what friction takes beside the dry one, both (J,) in N·m."""
        load, loss = np.zeros(len(q)), np.zeros(len(q))
        if self.built is None or self.built.where not in ("load", "loss", "across"):
            return load, loss
        at = [self.j, self.j + 1] if self.built.where == "across" else [self.j]
        low, high = self.links[self.j].position
        middle, half = 0.5 * (low + high), 0.5 * (high - low)
        now = Now(t, float(q[at].sum()), float(v[at].sum()), float(rigid[self.j]), middle, half)
        (loss if self.built.where == "loss" else load)[at] = self.built.value(self.numbers, now)
        return load, loss

    def _bodies(self, rng: np.random.Generator) -> str:
        """Return the model in MuJoCo's language: angles from hanging, each relative to its parent, to the front."""
        opened, places = "", (0.0, *(-link.length for link in self.links[:-1]))
        for link, place, y, rotor in zip(self.links, places, self.part("sideways"), self.part("rotor"), strict=True):
            mass, along = rng.uniform(*link.mass), link.length * rng.uniform(0.4, 0.55)
            inertia = mass * link.length**2 / 12.0 * rng.uniform(0.8, 1.3)
            opened += (
                f'<body pos="0 0 {place}"><joint name="{link.name}" axis="0 -1 0" armature="{rotor}" '
                f'damping="{rng.uniform(*link.viscous)}" frictionloss="{rng.uniform(*link.dry)}" '
                'solreffriction="0.002 1" solimpfriction="0.97 0.999 0.001"/>'
                f'<inertial pos="{y} 0 {-along}" mass="{mass}" diaginertia="{inertia} {inertia} {0.2 * inertia}"/>'
            )
        tilt = float(self.part("tilt").sum())
        gravity = f"{9.81 * math.sin(tilt)} 0 {-9.81 * math.cos(tilt)}"
        return (
            f'<mujoco><option timestep="{STEP}" integrator="implicitfast" gravity="{gravity}"/>'
            f"<worldbody>{opened}{'</body>' * len(self.links)}</worldbody></mujoco>"
        )


def wanted(links: Sequence[Link], rng: np.random.Generator, t: Float) -> tuple[Float, Float, Float]:
    """Return angles, velocities and accelerations (N, J): five harmonics of about 0.1 Hz within the joints' limits."""
    found = []
    for link in links:
        k = np.arange(1, 6)
        w = 2.0 * math.pi * 0.1 * k * rng.uniform(0.95, 1.05)
        a, phase = rng.normal(size=5) / k**0.3, w * t[:, None] + rng.uniform(0.0, 2.0 * math.pi, 5)
        q, v, acc = np.sin(phase) @ a, np.cos(phase) @ (a * w), -np.sin(phase) @ (a * w**2)
        low, high = link.position
        limits = 0.5 * (high - low), link.velocity, link.acceleration
        most = 0.5 * np.ptp(q), abs(v).max(), abs(acc).max()
        scale = 0.95 * min(limit / peak for limit, peak in zip(limits, most, strict=True))
        found.append((0.5 * (low + high) + scale * (q - 0.5 * (q.max() + q.min())), scale * v, scale * acc))
    q, v, acc = (np.column_stack(part) for part in zip(*found, strict=True))
    return q, v, acc


def simulate(
    chain: Chain, rng: np.random.Generator, name: str, seconds: float = SECONDS, noise: bool = True
) -> tuple[Recording, Motion]:
    """Return a recording, and the motion as MuJoCo knows it."""
    import mujoco

    model = mujoco.MjModel.from_xml_string(chain.xml)
    data, links = mujoco.MjData(model), chain.links
    t = np.arange(round(seconds / STEP)) * STEP
    q_w, v_w, a_w = wanted(links, rng, t)
    data.qpos[:], data.qvel[:] = q_w[0], v_w[0]
    dry, gains = model.dof_frictionloss.copy(), np.array([link.gains for link in links]).T
    mujoco.mj_forward(model, data)
    rows, product = [], np.zeros(len(links))
    for k, now in enumerate(t):
        q, v = data.qpos.copy(), data.qvel.copy()
        mujoco.mj_mulM(model, data, product, data.qacc)
        load, loss = chain.acts(now, q, v, product + data.qfrc_bias)
        mujoco.mj_mulM(model, data, product, a_w[k])
        tau = product + data.qfrc_bias + dry * np.tanh(20.0 * v_w[k])
        tau += gains[0] * (q_w[k] - q) + gains[1] * (v_w[k] - v)
        model.dof_frictionloss[:] = np.maximum(dry + loss, 0.0)
        data.qfrc_applied[:] = tau - load
        mujoco.mj_step(model, data)
        if k % EVERY == 0:
            rows.append((q, v, data.qacc.copy(), tau))
    t = t[::EVERY]
    q, v, acceleration, tau = (np.array(part) for part in zip(*rows, strict=True))
    motion = Motion(t, q, v, acceleration)
    q, tau = q - chain.part("angle"), tau * (1.0 + chain.part("gain"))
    tau = np.column_stack([np.interp(t - d, t, x) for d, x in zip(chain.part("delay"), tau.T, strict=True)])
    if noise:
        size = np.array([link.noise for link in links])
        far = 12.0 * (rng.random(tau.shape) < OUTLIERS) * rng.standard_normal(tau.shape)
        q, tau = np.round(q / QUANTUM) * QUANTUM, tau + size * (rng.standard_normal(tau.shape) + far)
    return Recording(name, t, q, tau, joints=chain.joints), motion


def run(case: str, seed: int) -> tuple[bool, str]:
    """Return whether the answer is right, and one line about it."""
    rng = np.random.default_rng([seed, zlib.crc32(case.encode())])
    chain = Chain.of(case, rng)
    runs = [simulate(chain, rng, f"run_{k}")[0] for k in range(4)]
    found = discover(Model("chain", limits={}, joints=chain.joints), runs[:3], runs[3:])
    truth = [] if chain.built is None else [case.split(":")[0] if chain.built.where == "tilt" else case]
    right = names_right(truth, found)
    numbers = {name: round(value, 3) for name, value in chain.numbers.items()}
    text = ", ".join(f"{a.name} {[round(e.value, 4) for e in a.parameters.values()]}" for a in found.accepted)
    errors = f"{np.round(found.steps[-1].evaluation_rms, 3).tolist()} at {np.round(found.noise_floor, 3).tolist()} N·m"
    return right, f"{case}/{seed} {numbers}: {'right' if right else 'WRONG'}; {found.verdict} [{text}] {errors}"


if __name__ == "__main__":
    sys.exit(ask(__doc__, CASES, run, first=1))
