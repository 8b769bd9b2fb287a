"""Machines for the virtual bench that are not the leg: links of plausible mass, dry and viscous friction, drives.

A link carries two thirds of the mass of the one before it, its centre of mass a little before its middle. What a
recording can show of masses, first moments and inertias are the base parameters of the machine.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from exoid.symbolic.columns import model_torque
from exoid.symbolic.joints import HERE, Joint, ancestors, parents
from exoid.symbolic.mechanics.base_parameters import base_parameters
from exoid.symbolic.mechanics.payload import Payload
from exoid.symbolic.mechanics.spatial import about_joint, rotation
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion

MASS, LIGHTER, LENGTH = 4.0, 0.65, 0.30
"""kg of the first link, the share of it that the next one has, and m of a link that carries nothing."""
FRICTION = {True: (4.0, 2.0), False: (15.0, 40.0)}
"""Coulomb and viscous friction of the first joint, where it turns (N·m, N·m·s/rad) and where it slides (N, N·s/m)."""
SHORT = 0.03
"""m to the next joint below which a link in space is of half the length `LENGTH`."""
RESERVE = 5.0
"""Largest torque of a drive over what the machine needs on a usual motion."""
BRAKED = 160.0
"""rad/s² at which dry friction alone brakes what a drive is made for at most: that of a small wrist, made for its link
alone, would not overcome its friction."""
STRONG = 100.0
"""N·m or N of a drive from which on its torque sensor has all of the bench's noise; of weaker ones it is finer."""


@dataclass(frozen=True)
class Machine:
    """The machine of the bench: `base` are the parameters of the model without terms, in its order.

    `torque_limit` (J,) N·m or N is where the drives saturate, `inertia` (J,) kg·m² or kg what each is for.
    """

    name: str
    base: tuple[float, ...]
    torque_limit: tuple[float, ...]
    inertia: tuple[float, ...]

    def with_payload(self, payload: Payload, model: Model) -> Machine:
        """Return the machine of `model` with a known mass; PayloadError where there is no such link."""
        added = payload.added(model)
        base = np.add(self.base, [*added, *(0.0 for _ in self.base[len(added) :])])
        return replace(self, base=tuple(base.tolist()))

    @property
    def sensor_scale(self) -> tuple[float, ...]:
        """Noise of each torque sensor over that of a strong drive's (J,)."""
        return tuple(min(1.0, limit / STRONG) for limit in self.torque_limit)


@lru_cache(maxsize=16)
def standard_machine(model: Model) -> Machine:
    """Return a machine with the joints, lengths and gravity of `model`, without its terms."""
    return _machine(model.base(), np.ones((len(model.joints), 5)))


def random_machine(model: Model, rng: np.random.Generator) -> Machine:
    """Draw a machine of `model`: the standard one with every mass, length and friction varied as those of a leg are."""
    spread = np.array([0.3, 0.12, 0.3, 0.45, 0.45])
    return _machine(model.base(), rng.uniform(1.0 - spread, 1.0 + spread, (len(model.joints), 5)))


def _machine(model: Model, factors: np.ndarray) -> Machine:
    """Return the machine with mass, centre of mass, inertia, dry and viscous friction times `factors` (J, 5)."""
    joints = model.joints
    depth = [len(ancestors(joints, j)) - 1 for j in range(len(joints))]
    own: dict[tuple[int, str], float] = {}
    for j, joint in enumerate(joints):
        heavier, longer, thicker = factors[j, :3]
        mass = heavier * MASS * LIGHTER ** depth[j]
        if model.spatial:
            own |= {(j, kind): value for kind, value in _body(joints, j, mass, longer, thicker).items()}
            continue
        length = joint.length or LENGTH
        along = longer * 0.45 * length
        about = mass * (along**2 + thicker * 0.1 * length**2)
        own |= {(j, "m"): mass, (j, "X"): mass * along, (j, "J"): about}
    found = base_parameters(joints, model.pull, model.moving_base)
    inertial = [own[p.link, p.kind] + sum(factor * own[link, kind] for link, kind, factor in p.parts) for p in found]
    friction = [
        factor * part * LIGHTER ** depth[j]
        for j, joint in enumerate(joints)
        for factor, part in zip(factors[j, 3:], FRICTION[joint.turns], strict=True)
    ]
    base = np.array([*inertial, *friction])
    motion = _usual(model)
    still = np.zeros_like(motion.q)
    rest = model_torque(model, Motion(motion.t, motion.q, still, still), base)
    eye = np.eye(len(joints))
    pushed = (model_torque(model, Motion(motion.t, motion.q, still, still + row), base) - rest for row in eye)
    felt = (float(np.median(torque[:, j])) for j, torque in enumerate(pushed))
    least = (dry / (BRAKED * joint.reach) for dry, joint in zip(friction[::2], joints, strict=True))
    inertia = [max(own, dry) for own, dry in zip(felt, least, strict=True)]
    need = np.abs(model_torque(model, motion, base)).max(axis=0)
    return Machine(model.name, tuple(base.tolist()), tuple((RESERVE * need).tolist()), tuple(inertia))


def _body(joints: Sequence[Joint], index: int, mass: float, longer: float, thicker: float) -> dict[str, float]:
    """Return the ten parameters of a link in space: a thick rod towards the next joint, of the last one straight on
    from the joint before, or along its own axis where these are at one place.
    """
    joint, below = joints[index], [k for k, above in enumerate(parents(joints)) if above == index]
    origin = joint.origin or HERE
    onwards = np.array(rotation(origin)).T @ origin.xyz
    size = float(np.linalg.norm(onwards))
    straight = LENGTH / 2.0 * (onwards / size if size >= SHORT else np.array(joint.axis or (0.0, 0.0, 1.0)))
    way = np.array((joints[below[0]].origin or HERE).xyz) if below else straight
    way = way if np.linalg.norm(way) >= SHORT else straight
    length = float(np.linalg.norm(way))
    centre = longer * 0.45 * way
    # Of the rod's gyration 0.1 length² lie across it, as of a planar link, and a fifth of that along it.
    unit = way / length
    own = mass * thicker * 0.1 * length**2 * (np.eye(3) - 0.8 * np.outer(unit, unit))
    return about_joint(mass, centre.tolist(), own.tolist())


def _usual(model: Model) -> Motion:
    """Return 200 states all over the limits of `model`."""
    rng = np.random.default_rng(0)
    limits = [model.motion_limits[name] for name in model.joint_names]
    low, high = np.array([limit.angle for limit in limits]).T
    size = np.array([(limit.velocity, limit.acceleration) for limit in limits]).T
    q = low + (high - low) * rng.random((200, len(limits)))
    dq, ddq = (bound * rng.uniform(-1.0, 1.0, q.shape) for bound in size)
    return Motion(0.01 * np.arange(200.0), q, dq, ddq)
