"""The joint controller of the bench: PD on the encoder, the velocity from a noisy differentiator, motors that
saturate.

    τ = kp (θ_d - θ) + kd (θ_d' - θ̂'),   θ̂' = filtered difference quotient of the encoder

The difference quotient turns encoder steps into torque chatter: with 17 bit at 1 kHz one step is 0.048 rad/s.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ground.errors import ExoidError

from .leg import Leg


@dataclass(frozen=True)
class Controller:
    """How stiffly the leg follows: `bandwidth` in Hz and `damping` (ratio) per joint, `differentiator`
    cut-off in Hz.
    """

    bandwidth: tuple[float, float] = (3.0, 4.5)
    damping: float = 0.8
    differentiator: float = 15.0

    def __post_init__(self) -> None:
        if min(*self.bandwidth, self.damping, self.differentiator) <= 0:
            raise ExoidError(
                "bandwidth, damping and differentiator cut-off of the controller must be positive",
                where=repr(self),
                remedy="give Hz, for example Controller(bandwidth=(3, 3), differentiator=15)",
            )

    def gains(self, leg: Leg, knee: float = -0.925) -> NDArray[np.float64]:
        """Return [[kp hip, kp knee], [kd hip, kd knee]] in N·m/rad and N·m·s/rad for this leg's inertia."""
        inertia = np.diag(leg.mass_matrix(knee))
        omega = 2.0 * math.pi * np.array(self.bandwidth)
        return np.array([inertia * omega**2, 2.0 * self.damping * inertia * omega])

    def smoothing(self, step: float) -> float:
        """Return the share of the newest difference quotient in the filtered velocity, for a control period
        in s.
        """
        return 1.0 - math.exp(-2.0 * math.pi * self.differentiator * step)
