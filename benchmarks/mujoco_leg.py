"""A second plant that is not ours: the leg in MuJoCo, in closed loop, with what real machines have built of bodies.

    python benchmarks/mujoco_leg.py                       every case once
    python benchmarks/mujoco_leg.py foot sway --seeds 3

Friction, limits, tendons, rotors, springs and contacts are MuJoCo's, its solver decides about stick and slip; nothing
here is shared with the bench. Each case is three runs of 25 s to fit and one to verify, on which `discover` is asked.
A case is right when what it names is among the answers listed with it, or when it says "unexplained" where nothing in
the catalogue is what was built. Needs the extra `peers`.
"""

from __future__ import annotations

import argparse
import importlib.util
import math
import sys
import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from exoid.diagnosis.discovery import discover  # noqa: E402 - the repository must be on the path first
from exoid.diagnosis.grading import match  # noqa: E402
from exoid.diagnosis.results import Diagnosis  # noqa: E402
from exoid.measurement.recording import Recording  # noqa: E402
from exoid.measurement.trajectories.trajectory import random_trajectory  # noqa: E402
from exoid.symbolic.model import Model  # noqa: E402

STEP = 5e-4
"""s, of MuJoCo and of the controller."""
EVERY = 20
"""Steps from one sample to the next: 100 Hz."""
LEAD_IN = 2.0
KP, KD = np.array([900.0, 320.0]), np.array([70.0, 18.0])
ROTOR = 0.012
"""kg·m², of the drive behind a spring or a gap: with a third of it KD · STEP / ROTOR is above 2, the sampled controller
makes the rotor chatter, and 3 N·m of Coulomb friction come out as 0.2."""
FOOT = 0.45
"""m below the knee."""
ENCODER_NOISE, TORQUE_NOISE = 6e-5, 0.4
"""rad and N·m, standard deviations."""


@dataclass(frozen=True)
class Leg:
    """What the leg is built of. Lengths m, masses kg, angles rad, stiffness N·m/rad.

    `soft` is the stiffness of the knee drive, `gap` half the width of the gap in it; the encoder then sits at the
    motor. `floor` is how far below the hip the ground lies, `ground` how it gives way (MuJoCo's solref, s and damping),
    `grip` its friction. `sway` is the amplitude in m/s² of the acceleration of the base, with a phase of its own in
    every run, `tendon` the stiffness in N·m/rad of one across both joints; `load` is a small body at the foot, kg.
    """

    dry: tuple[float, float] = (4.0, 3.0)
    viscous: tuple[float, float] = (2.0, 1.2)
    armature: float = 0.0
    stop: float | None = None
    tendon: float = 0.0
    soft: float | None = None
    gap: float | None = None
    floor: float | None = None
    ground: str = "0.05 1"
    grip: float = 1.0
    sway: float = 0.0
    load: float = 0.0

    def xml(self) -> str:
        """Return the model in MuJoCo's language; θ1 from the downward vertical, θ2 relative, positive to the front."""
        twist, knee, loss = "", "knee", self.dry[1]
        if self.soft is not None:
            twist = f'<joint name="twist" axis="0 -1 0" stiffness="{self.soft}" damping="{0.002 * self.soft}"/>'
        elif self.gap is not None:
            twist = (
                f'<joint name="twist" axis="0 -1 0" limited="true" range="{-self.gap} {self.gap}" '
                'damping="0.05" solreflimit="0.004 1"/>'
            )
        limit = "" if self.stop is None else f'limited="true" range="{self.stop} 3" solreflimit="-60 -2"'
        joint = (
            f'<joint name="{knee}" axis="0 -1 0" frictionloss="{loss}" damping="{self.viscous[1]}" '
            f'armature="{self.armature}" {limit}/>'
        )
        mass = 6.0 + self.load
        middle = (6.0 * 0.22 + self.load * FOOT) / mass
        inertia = 0.11 + 6.0 * (middle - 0.22) ** 2 + self.load * (FOOT - middle) ** 2
        shank = (
            f'<inertial pos="0 0 {-middle}" mass="{mass}" diaginertia="{inertia} {inertia} 0.02"/>'
            f'<geom name="foot" type="sphere" size="0.04" pos="0 0 {-FOOT}" mass="0" '
            f'friction="{self.grip} 0.005 1e-4"/>'
        )
        if twist:
            rotor = f'<inertial pos="0 0 0" mass="0.001" diaginertia="{ROTOR} {ROTOR} {ROTOR}"/>'
            lower = f'<body pos="0 0 -0.4">{joint}{rotor}<body>{twist}{shank}</body></body>'
        else:
            lower = f'<body pos="0 0 -0.4">{joint}{shank}</body>'
        ground = ""
        if self.floor is not None:
            feel = f'solref="{self.ground}" friction="{self.grip} 0.005 1e-4"'
            ground = f'<geom name="floor" type="plane" size="5 5 1" pos="0 0 {-self.floor}" {feel}/>'
        tendon = ""
        if self.tendon:
            tendon = (
                f'<tendon><fixed stiffness="{self.tendon}" springlength="0.2">'
                '<joint joint="hip" coef="1"/><joint joint="knee" coef="1"/></fixed></tendon>'
            )
        return f"""<mujoco><compiler angle="radian" autolimits="false"/>
<option timestep="{STEP}" integrator="implicitfast" gravity="0 0 -9.81" cone="elliptic" iterations="50"/>
<worldbody>{ground}<body><joint name="hip" axis="0 -1 0" frictionloss="{self.dry[0]}" damping="{self.viscous[0]}"/>
<inertial pos="0 0 -0.18" mass="9.5" diaginertia="0.14 0.14 0.02"/>{lower}</body></worldbody>{tendon}
<actuator><motor joint="hip"/><motor joint="knee"/></actuator></mujoco>"""


CASES: dict[str, tuple[Leg, tuple[str, ...]]] = {
    "nothing": (Leg(), ()),
    "armature": (Leg(armature=0.15), ("rotor_inertia:knee",)),
    "limit": (Leg(stop=-1.35), ("end_stop:knee",)),
    "tendon": (Leg(tendon=6.0), ("biarticular_spring",)),
    "elastic": (Leg(soft=400.0), ("motor_elasticity:knee",)),
    "gap": (Leg(gap=0.02), ("series_backlash:knee",)),
    "foot": (Leg(floor=0.855), ("unexplained", "check_channels")),
    "sway": (Leg(sway=0.6), ("base_motion",)),
}
"""What is built, and the answers that are right: names of terms, or a verdict."""


def simulate(leg: Leg, seed: int, index: int, duration: float = 25.0, noise: bool = True) -> tuple[Recording, Any]:
    """Return a recording and what MuJoCo knows about it: q, dq, ddq at the encoders and the drives' torque, (N, 2)."""
    import mujoco

    rng = np.random.default_rng([seed, index])
    model = mujoco.MjModel.from_xml_string(leg.xml())
    data = mujoco.MjData(model)
    path = random_trajectory(rng, Model.standard().limits)
    count = round((LEAD_IN + duration) / STEP)
    t = np.arange(count) * STEP - LEAD_IN
    wanted = path.at(t)
    joints = [model.joint(name) for name in ("hip", "knee")]
    place, speed = (np.array([getattr(j, key)[0] for j in joints]) for key in ("qposadr", "dofadr"))
    data.qpos[place] = wanted.q[0]
    data.qvel[speed] = wanted.dq[0]
    phase, frequency = rng.uniform(0.0, 2.0 * math.pi), 0.9
    rows = []
    for k in range(count):
        sway = leg.sway * math.sin(2.0 * math.pi * frequency * t[k] + phase)
        model.opt.gravity[:] = (-sway, 0.0, -9.81)  # in the frame of the base
        q, dq = data.qpos[place], data.qvel[speed]
        tau = np.clip(KP * (wanted.q[k] - q) + KD * (wanted.dq[k] - dq), -150.0, 150.0)
        data.ctrl[:] = tau
        before = (q.copy(), dq.copy())
        mujoco.mj_step(model, data)
        if t[k] >= -1e-9 and round(t[k] / STEP) % EVERY == 0:
            rows.append((t[k], *before, data.qacc[speed].copy(), tau))
    times, q, dq, ddq, tau = (np.array(part) for part in zip(*rows, strict=True))
    size = (ENCODER_NOISE, TORQUE_NOISE) if noise else (0.0, 0.0)
    seen = Recording(
        f"run_{index}", times, q + size[0] * rng.standard_normal(q.shape), tau + size[1] * rng.standard_normal(q.shape)
    )
    return seen, (q, dq, ddq, tau)


def run(name: str, seed: int) -> tuple[bool, str]:
    """Return whether the answer is right, and one line about it."""
    leg, answers = CASES[name]
    began = time.perf_counter()
    recordings = [simulate(leg, seed, index)[0] for index in range(4)]
    found = discover(Model.standard(), recordings[:3], recordings[3:])
    named = {other for one in found.accepted for other in (one.name, *one.look_alikes, *one.never_separable)}
    if answers:
        right = found.verdict in answers or (bool(named & {*answers}) and len(found.accepted) == 1)
    else:
        right = found.verdict == "adequate"
    text = ", ".join(f"{a.name} {[round(e.value, 4) for e in a.parameters.values()]}" for a in found.accepted)
    leading = [f"{s.name} {s.explained_share:.0%}" for s in found.suspects[:3]]
    left = found.steps[-1].verify_rms
    return right, (
        f"{name}/{seed}: {'right' if right else 'WRONG'}; {found.verdict} [{text}] suspects {', '.join(leading)}; "
        f"unseen {np.round(left, 3).tolist()} at a floor of {np.round(found.noise_floor, 3).tolist()} N·m; "
        f"{time.perf_counter() - began:.0f} s"
    )


def names_right(truth: Sequence[str], found: Diagnosis) -> bool:
    """Return whether what was accepted is what is hidden, and nothing else; where nothing is, whether it says so."""
    named = match(truth, [(one.name, one.look_alikes) for one in found.accepted])
    right = None not in named.values() and len(found.accepted) == len(truth)
    return right and (bool(truth) or found.verdict == "adequate")


def ask(
    doc: str | None,
    cases: Collection[str],
    run: Callable[[str, int], tuple[bool, str]],
    first: int,
    arguments: Sequence[str] | None = None,
    needs: str = "mujoco",
) -> int:
    """Run the cases of a script, print a line about each and how many are right; `first` is the usual first seed,
    `needs` the module that simulates.
    """
    text, _, rest = (doc or "").partition("\n\n")
    form = argparse.RawDescriptionHelpFormatter
    parser = argparse.ArgumentParser(description=text, epilog=rest, formatter_class=form)
    parser.add_argument("cases", nargs="*", help=f"of: {', '.join(cases)}")
    parser.add_argument("--seeds", type=int, default=1)
    parser.add_argument("--first", type=int, default=first, help=f"first seed ({first})")
    given = parser.parse_args(arguments)
    unknown = [name for name in given.cases if name not in cases]
    if unknown:
        parser.error(f"there is no case {', '.join(unknown)}; use {', '.join(cases)}")
    if importlib.util.find_spec(needs) is None:
        print(f"{needs} is not installed; pip install 'exoid[peers]'")
        return 2
    good = []
    for seed in range(given.first, given.first + given.seeds):
        for name in given.cases or cases:
            right, line = run(name, seed)
            good.append(right)
            print(line, flush=True)
    print(f"{sum(good)} of {len(good)} right")
    return 0


if __name__ == "__main__":
    sys.exit(ask(__doc__, CASES, run, first=0))
