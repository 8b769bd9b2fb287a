"""Criteria of a motion, from the information it carries.

With G_j = Σ y y^T / N per joint (exoid/symbolic/codegen/information.py), n independent samples and noise
of standard deviation σ_j:

    condition   sqrt(λ_max / λ_min) of Σ_j G_j                      cond(Ȳ), the paper's
    d_optimal   -log det F,  F = Σ_j n_j G_j / σ_j²                  volume of the confidence ellipsoid (squared)
    worst       max_i sqrt((F⁻¹)_ii) / |Φ_i|                         largest relative standard deviation

All are minimised. The first depends on the units of the parameters (it is the paper's choice), the second does not.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

import numpy as np

from exoid.ground.plain import AsJson
from exoid.measurement.bench.sensors import Sensors
from exoid.measurement.trajectories.trajectory import TrajectoryError
from exoid.symbolic.joints import LEG, Joint, units
from exoid.symbolic.motion import Float

TINY = 1e-300

LOST = 1e-13
"""Share of the largest eigenvalue (columns scaled alike) below which a direction carries no information."""


LEAST_NOISE, MOST_NOISE = 1e-6, 1e6
"""N·m; no torque sensor is better or worse."""


@dataclass(frozen=True, eq=False)
class Noise(AsJson):
    """Torque noise: `sd` (J,) N·m of a sample, `per_second` (J,) independent samples, and where this is known from."""

    sd: Float
    per_second: Float
    source: str
    joints: tuple[Joint, ...] = LEG

    @classmethod
    def white(
        cls, sd: Sequence[float] | float | None = None, rate: float = 100.0, joints: Sequence[Joint] = LEG
    ) -> Noise:
        """Return white noise on samples of `joints` at `rate` Hz; default the virtual bench's torque sensors, 0.5 N·m
        (0.5 N where a joint slides).

        `sd` is one standard deviation for all joints or one each.
        """
        source = "as given"
        given = np.ravel(np.asarray(1.0 if sd is None else sd, dtype=float))
        if given.size not in (1, len(joints)):
            raise TrajectoryError(
                f"{given.size} numbers of noise for {len(joints)} joints", remedy="give one, or one per joint"
            )
        if not (np.all((given >= LEAST_NOISE) & (given <= MOST_NOISE)) and 1e-3 <= rate <= 1e7):
            what = f"noise of {', '.join(f'{x:g}' for x in given)} {units(joints, 'tau')} at {rate:g} Hz"
            remedy = f"give {LEAST_NOISE:g} to {MOST_NOISE:g} {units(joints, 'tau')}, and a rate of 0.001 to 1e7 Hz"
            raise TrajectoryError(what, remedy=remedy)
        if sd is None:
            sd, source = Sensors().torque_noise, "the torque sensors of the virtual bench"
        each = np.broadcast_to(np.ravel(np.asarray(sd, dtype=float)), (len(joints),))
        return cls(each, np.full(len(joints), float(rate)), source, tuple(joints))

    @property
    def weight(self) -> Float:
        """Information (J,) per second in 1/(N·m)² s: independent samples over variance."""
        return self.per_second / self.sd**2

    def __str__(self) -> str:
        parts = ", ".join(
            f"{joint.name} {sd:.3g} {joint.unit('tau')} on {count:.3g} independent samples/s"
            for joint, sd, count in zip(self.joints, self.sd, self.per_second, strict=True)
        )
        return f"{parts} ({self.source})"

    def _json(self) -> dict[str, Any]:
        return {"sd": self.sd, "independent_per_second": self.per_second, "source": self.source}


def eigenvalues(gram: Float) -> Float:
    """Return the eigenvalues (I, M) of Σ_j G_j for `gram` (I, J, M, M), ascending, not below a tiny number."""
    return np.maximum(np.linalg.eigvalsh(gram.sum(axis=1)), TINY)


def condition(gram: Float) -> Float:
    """Return cond(Ȳ) (I,) for `gram` (I, J, M, M)."""
    values = eigenvalues(gram)
    return np.sqrt(values[:, -1] / values[:, 0])


def fisher(gram: Float, noise: Noise, duration: float) -> Float:
    """Return the information F (I, M, M) of `duration` s of the motion."""
    return np.asarray(np.einsum("ijpr,j->ipr", gram, noise.weight * duration))


def log_det(information: Float) -> Float:
    """Return log det F (I,); -∞ where a direction is not informed about."""
    sign, value = np.linalg.slogdet(information)
    return np.where(sign > 0.0, value, -np.inf)


def deviations(information: Float) -> Float:
    """Return the standard deviation (I, M) of each number; infinite where nothing is known of it."""
    scale = np.sqrt(np.maximum(np.einsum("ipp->ip", information), TINY))
    values, axes = np.linalg.eigh(information / (scale[:, :, None] * scale[:, None, :]))
    lost = values <= LOST * values[:, -1:]
    spread = np.einsum("ipk,ik->ip", axes**2, np.where(lost, 0.0, 1.0 / np.maximum(values, TINY)))
    blind = np.einsum("ipk,ik->ip", axes**2, lost.astype(float)) > 1e-9
    return np.asarray(np.where(blind, np.inf, np.sqrt(spread)) / scale)


def softened(gram: Float, power: float = 4.0) -> Float:
    """Return a smooth upper bound of 2 log cond(Ȳ) (I,): all eigenvalues take part, the extreme ones most."""
    logs = np.log(eigenvalues(gram))
    above = np.log(np.sum(np.exp(power * (logs - logs[:, -1:])), axis=1)) / power + logs[:, -1]
    below = np.log(np.sum(np.exp(-power * (logs - logs[:, :1])), axis=1)) / power - logs[:, 0]
    return np.asarray(above + below)


@dataclass(frozen=True, eq=False)
class Aim:
    """Context in which a motion is evaluated: `size` (M,) of each number (0: it has none), noise, duration in s."""

    size: Float
    noise: Noise
    duration: float

    def relative(self, gram: Float) -> Float:
        """Return relative standard deviations (I, M); zero for numbers without a size, which do not count."""
        spread = deviations(fisher(gram, self.noise, self.duration))
        return np.where(self.size > 0.0, spread / np.maximum(self.size, TINY), 0.0)


CRITERIA: Mapping[str, Callable[[Float, Aim], Float]] = MappingProxyType(
    {
        "condition": lambda gram, aim: condition(gram),
        "d_optimal": lambda gram, aim: -log_det(fisher(gram, aim.noise, aim.duration)),
        "worst": lambda gram, aim: aim.relative(gram).max(axis=1),
    }
)
"""Name -> (gram (I, J, M, M), aim) -> values (I,) to minimise."""

PIECES: Mapping[str, Callable[[Float, Aim], Float]] = MappingProxyType(
    {
        "condition": lambda gram, aim: np.log(condition(gram))[:, None],
        "d_optimal": lambda gram, aim: -log_det(fisher(gram, aim.noise, aim.duration))[:, None],
        "worst": lambda gram, aim: np.log(np.maximum(aim.relative(gram)[:, aim.size > 0.0], TINY)),
    }
)
"""Name -> values (I, K) of which the largest falls and rises as the criterion does, each smooth almost everywhere."""
