"""A wearer who is not passive: forces at the thigh and the shank cuff, which the cuffs' sensors measure.

The forces stand at right angles to the segments, positive to the front of a hanging leg, at `reach` from the
segment's upper joint. They drive the leg besides the motors: `M θ'' + ... = τ + Jᵀ F` (equation (4) of the
paper) with

    (Jᵀ F)_hip = r1 f1 + (a_th cos θ2 + r2) f2,     (Jᵀ F)_knee = r2 f2.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symbolic.motion import Float


@dataclass(frozen=True)
class Wearer:
    """Cuff forces of `amplitude` N (thigh, shank) that come and go within about `period` s, at `reach` m."""

    amplitude: tuple[float, float] = (15.0, 10.0)
    period: float = 3.0
    reach: tuple[float, float] = (0.25, 0.25)

    def force(self, t: NDArray[np.floating[Any]], rng: np.random.Generator) -> Float:
        """Return forces (N, 2) in N at times `t`: three harmonics with random phases, never above the
        amplitude.
        """
        phase = rng.uniform(0.0, 2.0 * math.pi, (3, 2))
        rate = 2.0 * math.pi / self.period * np.array([0.37, 1.0, 1.83])
        waves = np.sin(np.asarray(t)[:, None, None] * rate[None, :, None] + phase)
        return np.asarray(np.array(self.amplitude) * waves.mean(axis=1))


def cuff_torque(force: Float, q: Float, reach: tuple[float, float], thigh_length: float) -> Float:
    """Return Jᵀ F (N, J) in N·m of cuff `force` (N, 2) at angles `q` (N, J)."""
    knee = reach[1] * force[:, 1]
    hip = reach[0] * force[:, 0] + thigh_length * np.cos(q[:, 1]) * force[:, 1] + knee
    return np.column_stack([hip, knee])


def cuff_force(torque: Float, q: Float, reach: tuple[float, float], thigh_length: float) -> Float:
    """Return the cuff force (N, 2) in N that makes joint `torque` (N, J) at angles `q` (N, J): J⁻ᵀ τ."""
    shank = torque[:, 1] / reach[1]
    thigh = (torque[:, 0] - torque[:, 1] - thigh_length * np.cos(q[:, 1]) * shank) / reach[0]
    return np.column_stack([thigh, shank])
