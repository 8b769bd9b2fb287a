"""Small recordings made from a model's own torque, for tests of what is decided about recordings."""

from __future__ import annotations

import numpy as np

from exoid.measurement.recording import Recording
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion

BETA = np.array([1.8, 0.4, 0.5, 0.2, 4.0, 2.0, 3.0, 1.2])
"""Φ1..Φ4, then Coulomb and viscous friction of hip and knee, of a plausible leg."""


def motion(seed: int, seconds: float = 12.0, rate: float = 100.0, moving: tuple[bool, bool] = (True, True)) -> Motion:
    """Return a smooth random motion inside Table 1; a joint that is not `moving` stands where its range is halved."""
    rng = np.random.default_rng(seed)
    t = np.arange(int(seconds * rate)) / rate
    middle = np.array([0.55, -0.9])
    q, dq, ddq = (np.zeros((t.size, 2)) for _ in range(3))
    q += middle
    for joint in (0, 1):
        if not moving[joint]:
            continue
        for w in 2 * np.pi * rng.uniform(0.08, 0.75, 6):
            size, phase = 0.42 / (1.0 + w) * rng.uniform(0.4, 1.0), rng.uniform(0, 2 * np.pi)
            q[:, joint] += size * np.sin(w * t + phase)
            dq[:, joint] += size * w * np.cos(w * t + phase)
            ddq[:, joint] -= size * w**2 * np.sin(w * t + phase)
    return Motion(t, q, dq, ddq)


def recording(
    seed: int,
    *,
    moving: tuple[bool, bool] = (True, True),
    undriven: tuple[bool, bool] = (False, False),
    noise: float = 0.3,
    angle_noise: float = 1e-5,
    seconds: float = 12.0,
    rate: float = 100.0,
    model: Model | None = None,
    beta: Float = BETA,
    extra: Float | None = None,
    name: str = "",
) -> Recording:
    """Return a recording whose torque is that of `model` (default: the standard leg) plus noise; `extra` (N, 2) N·m.

    The channel of an `undriven` joint reads zero (its motion is then not what physics would make it).
    """
    path = motion(seed, seconds, rate, moving)
    rng = np.random.default_rng(1000 + seed)
    tau = (model or Model.standard()).torque(path, beta)
    tau = tau + (0.0 if extra is None else extra) + noise * rng.normal(size=tau.shape)
    tau[:, np.array(undriven)] = 0.0
    q = path.q + angle_noise * rng.normal(size=path.q.shape)
    return Recording(name or f"run {seed}", path.t, q, tau)
