"""A leg that walks: strides of which no two are alike, and a foot that the ground pushes during most of each."""

from dataclasses import replace

import numpy as np

from exoid.measurement.recording import Recording
from tests.newton_euler import Leg, torque

LEG = Leg(m=(6.5, 4.0), inertia=(0.12, 0.06), along=(0.18, 0.2))
REACH = 0.43
"""m from the knee to the foot."""


def walked(seed=0, seconds=20.0, rate=100.0, noise=0.4, pelvis=0.0):
    """Return (recording without any force, torque (N, 2) that the ground takes off the drives, which samples are stance
    (N,), force (N, 2) on the foot). The hip is accelerated with up to `pelvis` m/s² twice in a stride.
    """
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * rate)) / rate
    cycle = _strides(t, rng)
    stance = (cycle % 1.0) < 0.62
    size = 1.0 + 0.12 * np.sin(0.9 * t + rng.uniform(0.0, 6.0)) + 0.08 * np.sin(2.1 * t + rng.uniform(0.0, 6.0))
    turn = 2.0 * np.pi * cycle
    hip = 0.15 + 0.4 * size * np.cos(turn - 0.4)
    knee = -0.55 - size * (0.2 * np.cos(2.0 * turn) + 0.35 * np.sin(turn - 0.6))
    q = np.column_stack([hip, knee])
    dq = np.gradient(q, t, axis=0)
    ddq = np.gradient(dq, t, axis=0)
    base = pelvis * np.column_stack([0.6 * np.sin(2.0 * turn), np.cos(2.0 * turn + 0.4)])
    tau = np.array([torque(LEG, *state) for state in zip(q, dq, ddq, base, strict=True)])
    tau += np.array([1.5, 1.0]) * np.tanh(dq / 0.02) + np.array([0.8, 0.5]) * dq
    force = _ground(cycle, stance, rng)
    q1, q12 = q[:, 0], q.sum(axis=1)
    knee_arm = REACH * np.column_stack([np.cos(q12), np.sin(q12)])
    hip_arm = LEG.length * np.column_stack([np.cos(q1), np.sin(q1)]) + knee_arm
    pushed = np.column_stack([np.sum(arm * force, axis=1) for arm in (hip_arm, knee_arm)])
    tau += noise * rng.standard_normal(tau.shape)
    read = q + 1e-4 * rng.standard_normal(q.shape)
    return Recording(f"walk{seed}", t, read, tau), pushed, stance, force


def _strides(t, rng):
    """Return the cycles (N,) that have passed, at a pace that changes slowly."""
    pace = 0.75 * (1.0 + 0.08 * np.sin(0.7 * t + rng.uniform(0.0, 6.0)))
    return np.cumsum(pace) * (t[1] - t[0]) + rng.uniform()


def _ground(cycle, stance, rng):
    """Return the force (N, 2) of the ground, forwards and upwards, another in every stride."""
    number = np.floor(cycle).astype(int)
    number -= number.min()
    high, late, brake = (1.0 + s * rng.standard_normal(number.max() + 1) for s in (0.15, 0.2, 0.3))
    part = np.clip((cycle % 1.0) / 0.62, 0.0, 1.0)
    humps = 1.0 + 0.3 * late[number] * np.sin(2.0 * np.pi * part)
    upwards = 200.0 * high[number] * np.sqrt(np.sin(np.pi * part)) * humps
    forwards = -40.0 * brake[number] * np.sin(2.0 * np.pi * part)
    return np.where(stance[:, None], np.column_stack([forwards, upwards]), 0.0)


def on_the_ground(seed=0, **told):
    """Return a recording of a walk without a word of the ground."""
    recording, pushed, _, _ = walked(seed, **told)
    return replace(recording, tau=recording.tau - pushed)
