"""Direction of joints, and where they stick: dry friction takes any value there, and no function of motion does."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.thresholds import Threshold
from exoid.measurement.signals.conditioning import velocity_noise
from exoid.measurement.signals.masks import widen
from exoid.optimisation.linear.loss import Bool
from exoid.symbolic.motion import Float

SIGN_WIDTH = (1e-4, 5e-2)
"""Bounds in rad/s of the velocity below which the sign of a measured velocity fades, as its noise demands."""
STICK: Threshold = 0.03
"""rad/s below which a joint may stick and is not fitted: dry friction takes any value there, which no function of
motion tells
"""
STICK_REACH: Threshold = 0.5
"""periods of the cut-off by which such samples reach further: direction is smeared there"""
DWELL: Threshold = 0.9
"""part of its change before and after that a velocity keeps where a joint turns back at once: one that sticks for a
moment, between two samples, passes for one with a late torque or a soft drive
"""
BESIDE = 3
"""Samples before and after a reversal, of which the outer ones say how a velocity changes there usually."""
DIRECTION = 1 / 3
"""Part of that speed which the noise of a velocity may be that tells the direction of motion."""


@dataclass(frozen=True, eq=False)
class Direction:
    """The velocities (N, J) below `band` Hz from which it is taken which way a joint moves, and whether. Smoothed as
    accelerations need it, they pass quickly where a joint sticks for a moment, and turn some samples too early or late.
    """

    velocity: Float
    band: float


def sticking(dq: Float, reach: Float, near: int) -> Bool:
    """Return the samples (N, J) at which joints with velocities `dq` (N, J) may stick, and `near` samples around where
    they do; `reach` (J,) as of a PreparedRecording.

    A joint that turns back at once does not stick. One that does, if only between two samples, is told by its velocity,
    which changes less there than before and after.
    """
    slow = np.abs(dq) < STICK * reach
    steps = np.abs(np.diff(dq, axis=0))
    count = max(0, len(dq) - 2 * BESIDE - 1)

    def at(shift: int, x: NDArray[Any]) -> NDArray[Any]:
        """Return `x` from so many samples after the one before each reversal that has room on either side."""
        return x[BESIDE + shift : BESIDE + shift + count]

    usual = 0.5 * np.minimum(at(-3, steps) + at(-2, steps), at(2, steps) + at(3, steps))
    least = np.minimum(np.minimum(at(-1, steps), at(0, steps)), at(1, steps))
    back = np.signbit(at(0, dq)) != np.signbit(at(1, dq))
    stays = back & (least < DWELL * usual)
    passes = back & ~stays & ~at(-BESIDE, slow) & ~at(BESIDE + 1, slow)
    there, passing = np.zeros(dq.shape, dtype=bool), np.zeros(dq.shape, dtype=bool)
    for shift in range(-BESIDE, BESIDE + 2):
        at(shift, passing)[:] |= passes
    for shift in (0, 1):
        at(shift, there)[:] |= stays
    there |= slow & ~passing
    return slow | np.column_stack([widen(column, near) for column in there.T])


def around_reversals(dq: Float) -> Bool:
    """Return the working samples (N, J) that are means over both directions of motion (`averaged`): friction jumps in
    between, however fast the joint turns back.
    """
    back = np.signbit(dq[1:]) != np.signbit(dq[:-1])
    around = np.zeros((len(dq) + 3, dq.shape[1]), dtype=bool)
    for shift in range(4):
        around[shift : shift + len(back)] |= back
    return around[1 : 1 + len(dq)]


def sign_width(noise: Float, band: float, reach: Float) -> Float:
    """Return the velocity (J,) in rad/s over which the sign fades: a part of the noise of a velocity.

    `noise` (J,) is the density of the angle noise in rad²/Hz, `band` in Hz what is left of it, `reach` (J,) as of a
    PreparedRecording.
    """
    low, high = SIGN_WIDTH
    return np.clip(0.3 * velocity_noise(noise, band), low * reach, high * reach)
