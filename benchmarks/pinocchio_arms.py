"""Arms of three to seven joints in space by Pinocchio, a plant that is not ours, with one effect built into each.

    python benchmarks/pinocchio_arms.py                            every case once
    python benchmarks/pinocchio_arms.py joint_spring:5:2 --seeds 3 --first 7
    python benchmarks/pinocchio_arms.py nothing:6:0 --seeds 5

A case is effect:joints:index. Each arm is a URDF of drawn lengths, masses and axes at right angles; exoid makes its
model of that file, and Pinocchio the rigid torque of motions that are tracked exactly: nothing here sticks. Dry and
viscous friction, noise of encoders and torque sensors, and the effect are added. Each case is three runs of 30 s to fit
and one to verify. A case is right when what was built in is named, or is a look-alike of what is named, and nothing
else. Needs the extra `peers`.
"""

from __future__ import annotations

import sys
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from benchmarks.mujoco_chains import EFFECTS, Now  # noqa: E402 - the repository must be on the path first
from benchmarks.mujoco_leg import ask, names_right  # noqa: E402
from exoid.diagnosis.discovery import discover  # noqa: E402
from exoid.measurement.recording import Recording  # noqa: E402
from exoid.symbolic.model import Model, model_of  # noqa: E402
from exoid.symbolic.robot_file import parse_robot  # noqa: E402
from exoid.symbolic.spatial_machine import spatial_machine  # noqa: E402

Float = NDArray[np.float64]
RATE, SECONDS, WAVES = 100.0, 30.0, 5
"""Hz and s of a recording; harmonics of 0.1 Hz of every joint's motion."""
ENCODER, SENSOR = 1e-4, 0.06
"""rad; noise of a torque sensor over the dry friction of its joint."""
STRONG = 2.25
"""N·m of dry friction at the joints for which the sizes of `mujoco_chains.EFFECTS` are."""
CASES = [
    *(f"nothing:{count}:0" for count in (3, 4, 5, 6, 7)),
    "stribeck:3:1", "stribeck:6:3", "load_friction:4:1", "load_friction:6:1", "joint_spring:3:2", "joint_spring:7:3",
    "rotor_inertia:4:2", "rotor_inertia:6:5", "torque_ripple:3:0", "torque_ripple:7:4", "torque_offset:4:3",
    "torque_offset:6:0", "viscous_quadratic:5:4", "viscous_quadratic:7:1", "viscous_asymmetry:3:0",
    "viscous_asymmetry:6:2", "hardening_spring:4:0", "hardening_spring:5:3", "end_stop:4:2", "end_stop:6:4",
    "passive_exponential:5:1", "position_friction:4:1", "position_friction:7:2", "encoder_offset:4:1",
    "encoder_offset:6:2", "time_delay:3:1", "time_delay:6:1", "friction_drift:5:0", "torque_drift:5:2",
    "cross_viscous:4:1",
]  # fmt: skip
"""What is built, in an arm of how many joints, and at which of them."""


@dataclass(frozen=True)
class Arm:
    """An arm: its URDF, dry and viscous friction of its joints (J,), what is built at joint `j`, and its numbers."""

    text: str
    dry: Float
    viscous: Float
    effect: str
    j: int
    numbers: Mapping[str, float]

    @classmethod
    def of(cls, case: str, rng: np.random.Generator) -> Arm:
        """Return an arm drawn for a case "effect:joints:index"."""
        effect, many, at = case.split(":")
        count, j = int(many), int(at)
        text = arm_text(count, rng)
        falling = np.linspace(6.0, 1.0, count)
        dry, viscous = falling * rng.uniform(0.7, 1.3, count), falling * rng.uniform(0.7, 1.3, count)
        numbers: dict[str, float] = {}
        built = EFFECTS.get(effect)
        for name, (low, high) in {} if built is None else built.ranges.items():
            drawn = float(rng.uniform(low, high))
            numbers[name] = drawn * float(dry[j]) / STRONG if built is not None and name in built.sized else drawn
        if effect == "rotor_inertia":
            numbers = {"c": float(rng.uniform(0.08, 0.16)) * float(dry[j])}
        if "n" in numbers:
            numbers["n"] = round(numbers["n"])
        return cls(text, dry, viscous, effect, j, numbers)

    def part(self, where: str) -> float:
        """Return the number of what is built in at `where`, 0 where nothing is."""
        built = EFFECTS.get(self.effect)
        return self.numbers["c"] if built is not None and built.where == where else 0.0


def arm_text(count: int, rng: np.random.Generator) -> str:
    """Return a URDF of `count` joints: each turns about its z axis, which is turned by a right angle or none from the
    last one's, as those of arms for sale are; never three in parallel.
    """
    parts, parallel = ['<link name="base"/>'], 0
    for k in range(count):
        heavy = 8.0 * 0.65**k
        long = float(rng.uniform(0.15, 0.4)) if k < count - 2 else float(rng.uniform(0.06, 0.12))
        turn = 0.0 if k == 0 or (parallel < 1 and rng.random() < 0.35) else 0.5 * np.pi * float(rng.choice([-1.0, 1.0]))
        parallel = parallel + 1 if turn == 0.0 else 0
        place = rng.choice([-1.0, 1.0], 3) * np.array([long, 0.1 * long, 0.4 * long]) if k else np.array([0, 0, 0.3])
        centre = rng.uniform(-0.5, 0.5, 3) * long
        gyration = np.sort(rng.uniform(0.2, 0.32, 3)) * long
        own = heavy * np.diag(gyration @ gyration - gyration**2)
        names = zip(("ixx", "iyy", "izz"), own.diagonal().tolist(), strict=True)
        entries = " ".join(f'{name}="{value!r}"' for name, value in names)
        parts.append(
            f'<link name="link{k}"><inertial><origin xyz="{_text(centre)}" rpy="{_text(rng.normal(size=3))}"/>'
            f'<mass value="{heavy!r}"/><inertia {entries} ixy="0" ixz="0" iyz="0"/></inertial></link>'
            f'<joint name="j{k}" type="revolute"><parent link="{f"link{k - 1}" if k else "base"}"/>'
            f'<child link="link{k}"/><origin xyz="{_text(place)}" rpy="{turn!r} 0 0"/><axis xyz="0 0 1"/>'
            '<limit lower="-3" upper="3" velocity="3" effort="100"/></joint>'
        )
    return f'<robot name="arm">{"".join(parts)}</robot>'


def _text(values: Float) -> str:
    return " ".join(repr(float(value)) for value in values)


def simulate(
    arm: Arm, rng: np.random.Generator, name: str, model: Model, seconds: float = SECONDS, hertz: float = RATE
) -> Recording:
    """Return a recording of an arm that follows a drawn motion."""
    import pinocchio as pin

    robot = pin.buildModelFromXML(arm.text)
    data, t, j = robot.createData(), np.arange(round(seconds * hertz)) / hertz, arm.j
    q, v, a = (np.zeros((len(t), robot.nv)) for _ in range(3))
    q += rng.uniform(-0.6, 0.6, robot.nv)
    for k in range(1, WAVES + 1):
        turn = 2.0 * np.pi * 0.1 * k * rng.uniform(0.9, 1.1, robot.nv)
        size, phase = 0.35 * rng.normal(size=robot.nv) / k**0.7, rng.uniform(0.0, 2.0 * np.pi, robot.nv)
        angle = t[:, None] * turn + phase
        q, v, a = q + size * np.sin(angle), v + size * turn * np.cos(angle), a - size * turn**2 * np.sin(angle)
    rigid = np.array([pin.rnea(robot, data, *state) for state in zip(q, v, a, strict=True)])
    tau = rigid + arm.dry * np.sign(v) + arm.viscous * v
    built = EFFECTS.get(arm.effect)
    if built is not None and built.where in ("load", "loss", "across"):
        joints = (j, j + 1) if built.where == "across" else (j,)
        angle, rate = q[:, joints].sum(axis=1), v[:, joints].sum(axis=1)
        middle, half = 0.5 * (angle.max() + angle.min()), 0.5 * np.ptp(angle)
        if arm.effect in ("end_stop", "hardening_spring", "passive_exponential"):
            middle, half = 0.0, 0.8  # where they sit is the arm's, and not a run's
        values = np.array([
            built.value(arm.numbers, Now(*now, middle, half)) for now in zip(t, angle, rate, rigid[:, j], strict=True)
        ])
        for joint in joints:
            tau[:, joint] += values * (np.sign(v[:, joint]) if built.where == "loss" else 1.0)
    tau[:, j] += arm.part("rotor") * a[:, j]
    q[:, j] -= arm.part("angle")
    tau[:, j] *= 1.0 + arm.part("gain")
    tau[:, j] = np.interp(t - arm.part("delay"), t, tau[:, j])
    read = q + ENCODER * rng.standard_normal(q.shape)
    return Recording(name, t, read, tau + SENSOR * arm.dry * rng.standard_normal(tau.shape), joints=model.joints)


def run(case: str, seed: int) -> tuple[bool, str]:
    """Return whether the answer is right, and one line about it."""
    rng = np.random.default_rng([seed, zlib.crc32(case.encode())])
    arm = Arm.of(case, rng)
    model = model_of(spatial_machine(parse_robot(arm.text.encode())).model)
    runs = [simulate(arm, rng, f"run_{k}", model) for k in range(4)]
    found = discover(model, runs[:3], runs[3:])
    truth = [] if arm.effect == "nothing" else [f"{arm.effect}:j{arm.j}"]
    right = names_right(truth, found)
    numbers = {name: round(value, 3) for name, value in arm.numbers.items()}
    text = ", ".join(f"{one.name} {[round(e.value, 4) for e in one.parameters.values()]}" for one in found.accepted)
    answer = f"{'right' if right else 'WRONG'}; {found.verdict} [{text}] {found.seconds:.0f} s"
    return right, f"{case}/{seed} {numbers}: {answer}"


if __name__ == "__main__":
    sys.exit(ask(__doc__, CASES, run, first=1, needs="pinocchio"))
