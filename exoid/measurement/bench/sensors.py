"""Instruments of the bench, which spoil the truth: encoder steps, noise, outliers and bursts of chatter.

Defaults are those of an instrumented exoskeleton leg: a 17-bit encoder (4.8e-5 rad), torque sensors with 0.5
N·m of noise, 6 % of torque samples spoilt, and now and then a fraction of a second of chatter on a torque
channel.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from exoid.ground.errors import ExoidError
from exoid.symbolic.force import VERTICAL, WORLD, Force
from exoid.symbolic.motion import Float


@dataclass(frozen=True)
class Sensors:
    """Instruments of the bench. Every number may be 0, which switches that fault off.

    `encoder_bits` per turn (0: ideal), `encoder_noise` rad, `torque_noise` N·m (standard deviations),
    `outlier_share` of torque samples, with standard deviation `outlier_size` N·m, `burst_rate` bursts per
    second and joint lasting about `burst_length` s with amplitude `burst_size` N·m, `jitter` s (standard
    deviation of the logged clock), `force_noise` N of the cuff sensors (N·m of a torque that a person applies),
    `plate_noise` N of the force plate. `decimals` is how many the logger keeps of rad and s (two fewer of N·m and N);
    None: all.
    """

    encoder_bits: int = 17
    encoder_noise: float = 6e-5
    torque_noise: float = 0.5
    outlier_share: float = 0.06
    outlier_size: float = 8.0
    burst_rate: float = 0.1
    burst_length: float = 0.15
    burst_size: float = 6.0
    jitter: float = 0.0
    force_noise: float = 0.3
    plate_noise: float = 1.0
    decimals: int | None = 6

    def __post_init__(self) -> None:
        for entry in fields(self):
            value = getattr(self, entry.name)
            if value is not None and not (math.isfinite(value) and value >= 0):
                raise ExoidError(f"sensor property {entry.name} = {value} must be finite and not negative")
        if self.outlier_share > 0.5 or self.encoder_bits > 32:
            what = "an outlier share above 0.5 or an encoder above 32 bit is not a measurement"
            raise ExoidError(what, where=f"outlier_share = {self.outlier_share}, encoder_bits = {self.encoder_bits}")

    @classmethod
    def ideal(cls) -> Sensors:
        """Return instruments without any fault."""
        return cls(0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, None)

    @property
    def resolution(self) -> float:
        """One encoder step in rad, 0 for an ideal encoder."""
        return 2.0 * math.pi / 2**self.encoder_bits if self.encoder_bits else 0.0

    def angle(self, q: Float, rng: np.random.Generator, reach: Float | float = 1.0) -> Float:
        """Return the encoder's reading of angles `q` (N, J) in rad: noise first, then whole steps.

        `reach` (J,) is what of its own unit each joint moves where a turning one moves 1 rad.
        """
        noisy = q + self.encoder_noise * reach * rng.standard_normal(q.shape)
        step = self.resolution * reach
        return np.round(noisy / step) * step if self.resolution else noisy

    def torque(self, tau: Float, rate: float, rng: np.random.Generator, scale: Float | float = 1.0) -> Float:
        """Return the torque sensors' reading of `tau` (N, J) in N·m sampled at `rate` Hz, faults times `scale` (J,)."""
        out = tau + scale * (self.torque_noise * rng.standard_normal(tau.shape))
        spoilt = rng.random(tau.shape) < self.outlier_share
        out = out + scale * np.where(spoilt, self.outlier_size * rng.standard_normal(tau.shape), 0.0)
        return out + scale * self._bursts(tau.shape, rate, rng)

    def of_forces(self, forces: Sequence[Force]) -> Float:
        """Return the noise (C,) of each channel of `forces`, N or N·m."""
        plates = [force.frame in (WORLD, VERTICAL) for force in forces for _ in force.columns]
        return np.where(plates, self.plate_noise, self.force_noise)

    def logged(self, values: Float, fewer: int = 0) -> Float:
        """Return `values` as the logger writes them, with `decimals` - `fewer` decimals."""
        # Adding 0.0 turns -0.0 into 0.0, which would print differently.
        return values if self.decimals is None else np.round(values, max(self.decimals - fewer, 0)) + 0.0

    def clock(self, t: Float, rng: np.random.Generator) -> Float:
        """Return logged times for sample times `t` (N,) in s; jitter never turns the clock back."""
        spread = self.jitter * rng.standard_normal(t.shape)
        return t + np.clip(spread, -0.4 * float(t[1] - t[0]), 0.4 * float(t[1] - t[0]))

    def _bursts(self, shape: tuple[int, ...], rate: float, rng: np.random.Generator) -> Float:
        """Return chatter (N, J) in N·m: sign-changing, with a period of 2 to 4 samples, at random moments."""
        out = np.zeros(shape)
        for j in range(shape[1]):
            for _ in range(rng.poisson(self.burst_rate * shape[0] / rate)):
                start = int(rng.integers(0, shape[0]))
                length = max(2, round(rate * self.burst_length * float(rng.uniform(0.5, 1.5))))
                k = np.arange(min(length, shape[0] - start))
                phase, per_sample = rng.uniform(0.0, 2.0 * math.pi), rng.uniform(math.pi / 2.0, math.pi)
                out[start : start + k.size, j] += self.burst_size * np.sin(per_sample * k + phase)
        return out
