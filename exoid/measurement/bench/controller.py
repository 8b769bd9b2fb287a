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

from exoid.ground.errors import ExoidError
from exoid.measurement.bench.leg import Leg
from exoid.measurement.bench.machine import Machine


@dataclass(frozen=True)
class Controller:
    """The stiffness with which the machine follows: `bandwidth` in Hz per joint (the last for all further ones),
    `damping` (ratio), `differentiator` cut-off in Hz.
    """

    bandwidth: tuple[float, ...] = (3.0, 4.5)
    damping: float = 0.8
    differentiator: float = 15.0

    def __post_init__(self) -> None:
        if min(*self.bandwidth, self.damping, self.differentiator) <= 0:
            what = "bandwidth, damping and differentiator cut-off of the controller must be positive"
            remedy = "give Hz, for example Controller(bandwidth=(3, 3), differentiator=15)"
            raise ExoidError(what, where=repr(self), remedy=remedy)

    def gains(self, machine: Leg | Machine) -> NDArray[np.float64]:
        """Return the gains (2, J) on angle and velocity in N·m/rad and N·m·s/rad for this machine's inertia."""
        inertia = np.array(machine.inertia)
        more = len(inertia) - len(self.bandwidth)
        omega = 2.0 * math.pi * np.array([*self.bandwidth, *(self.bandwidth[-1:] * more)][: len(inertia)])
        return np.array([inertia * omega**2, 2.0 * self.damping * inertia * omega])

    def smoothing(self, step: float) -> float:
        """Return the share of the newest difference quotient in the filtered velocity, for a control period
        in s.
        """
        return 1.0 - math.exp(-2.0 * math.pi * self.differentiator * step)
