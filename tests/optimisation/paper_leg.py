"""A small leg written independently of `exoid.symbolic.model`, so that the optimisation is tested on its own."""

from __future__ import annotations

from dataclasses import dataclass
from types import SimpleNamespace

import numpy as np

from exoid.symbolic.effect import Shape
from exoid.symbolic.joints import LEG
from exoid.symbolic.motion import Motion

THIGH = 0.40
PAPER = np.array([25.14, 7.42, 1.43, -10.42, 31.35, 12.53, 43.40, 28.01])
HIP_A, HIP_B = (0.99, -0.68, -16.40, 11.49, -11.03), (1.28, -9.73, -15.52, -6.58, -4.06)
KNEE_A, KNEE_B = (-4.53, 3.53, -0.73, 6.46, -7.94), (7.80, -2.91, -15.50, 10.30, -8.75)
LIMITS = {"hip": SimpleNamespace(angle=(-0.13, 1.26)), "knee": SimpleNamespace(angle=(-1.62, -0.23))}
LOWEST = (None, None, None, None, 0.0, 0.0, 0.0, 0.0)
NAMES = ("Phi1", "Phi2", "Phi3", "Phi4", "coulomb:hip", "viscous:hip", "coulomb:knee", "viscous:knee")
UNITS = ("kg·m²",) * 4 + ("N·m", "N·m·s/rad") * 2


def paper_motion(samples: int = 3500, step: float = 0.01, period: float = 10.0, late: float = 0.0) -> Motion:
    """The paper's excitation, its coefficients read as degrees; `late` shifts it in time."""
    t = np.arange(samples) * step
    k = np.arange(1, 6)[:, None] * 2.0 * np.pi / period
    sine, cosine = np.sin(k * (t + late)), np.cos(k * (t + late))
    a, b = np.deg2rad([HIP_A, KNEE_A]), np.deg2rad([HIP_B, KNEE_B])
    q = np.array([[0.61], [-0.925]]) + a @ sine + b @ cosine
    dq = (a * k.T) @ cosine - (b * k.T) @ sine
    ddq = -(a * k.T**2) @ sine - (b * k.T**2) @ cosine
    return Motion(t, q.T, dq.T, ddq.T)


@dataclass(frozen=True)
class Leg:
    """The eight-parameter leg; `stribeck` adds a shape parameter, `load` a friction with a reference."""

    stribeck: bool = False
    load: bool = False
    name: str = "test leg"

    limits = LIMITS
    joints = LEG
    chain = ()
    following_places = ()
    bent_friction = ()
    forces = ()
    wearer = None

    @property
    def needs_reference(self):
        return self.load

    @property
    def reference_places(self):
        return tuple(range(len(NAMES))) if self.load else ()

    @property
    def parameters(self):
        extra = [("stribeck:knee.c", "N·m", 0.0)] * self.stribeck + [("load_friction:knee.c", "1", 0.0)] * self.load
        rows = [*zip(NAMES, UNITS, LOWEST, strict=True), *extra]
        return tuple(SimpleNamespace(name=n, label=n, unit=u, min=low, max=None) for n, u, low in rows)

    @property
    def shapes(self):
        shape = Shape("rad/s", 0.01, 0.4, typical=0.1, spacing="log")
        return (SimpleNamespace(name="stribeck:knee.v_s", shape=shape),) * self.stribeck

    def whole_columns(self, motion, shape=None, reference=None):
        return self.columns(motion, shape, reference)

    def columns(self, motion, shape=None, reference=None):
        (q1, q2), (v1, v2), (a1, a2) = motion.q.T, motion.dq.T, motion.ddq.T
        e, s1, s12, s2, c2 = 9.81 / THIGH, np.sin(q1), np.sin(q1 + q2), np.sin(q2), np.cos(q2)
        sign1, sign2, none = motion.sign[:, 0], motion.sign[:, 1], np.zeros_like(q1)
        third = c2 * (2 * a1 + a2) - s2 * (2 * v1 * v2 + v2**2) + e * s12
        hip = [a1 + e * s1, a2 - e * s1, third, e * s1, sign1, v1, none, none]
        knee = [none, a1 + a2, c2 * a1 + s2 * v1**2 + e * s12, none, none, none, sign2, v2]
        if self.stribeck:
            width = 0.1 if shape is None else shape[0]
            hip.append(none)
            knee.append(sign2 * np.exp(-((v2 / width) ** 2)))
        if self.load:
            hip.append(none)
            rigid = np.array(knee[:4]).T @ reference[:4]
            knee.append(sign2 * np.abs(rigid))
        return np.stack([np.array(hip).T, np.array(knee).T])


@dataclass(frozen=True, eq=False)
class Recorded:
    """A prepared recording without any filter."""

    motion: Motion
    torque: np.ndarray
    used: np.ndarray
    name: str = "run"

    @property
    def kept(self):
        return np.arange(len(self.motion))

    def smooth(self, x):
        return x.T

    def smooth_columns(self, x, joints=None):
        return x

    def smooth_rows(self, x, joints, axis):
        return x


def record(leg=None, linear=PAPER, shape=None, noise=1.0, outliers=0.0, seed=0, samples=3500, late=0.0, step=0.01):
    """Simulate one recording of `leg` with parameters `linear`, white noise and a share of knocks."""
    leg = leg or Leg()
    rng = np.random.default_rng(seed)
    motion = paper_motion(samples, late=late, step=step)
    tau = (leg.columns(motion, shape, linear) @ linear).T + rng.normal(0.0, noise, (samples, 2))
    knocked = rng.random(tau.shape) < outliers
    tau[knocked] += rng.normal(0.0, 30.0 * noise, int(knocked.sum()))
    return Recorded(motion, tau.T, np.ones(tau.T.shape, dtype=bool))
