"""Space of a search for motions: numbers in a box, each of them a motion inside the limits.

The coefficients of one joint are W N y with y in [-1, 1]: W holds for each harmonic the amplitude with which it alone
would meet the first limit, so that all directions weigh alike, and the columns of N span the coefficients that obey
the linear conditions exactly (for a start and an end at rest: velocity Σ k a_k = 0 and acceleration Σ k² b_k = 0 at t
= 0, hence also after whole periods). A motion is then stretched to the first limit it meets, so only the direction of
y matters, and no search can leave the limits. A free offset is a number between the angle limits; the room left
around it is what the swing is stretched into.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from exoid.ground.ties import tied
from exoid.measurement.trajectories.trajectory import CENTRE, LONGEST_PERIOD, SHORTEST_PERIOD, Fourier, TrajectoryError
from exoid.optimisation.excitation.settings import OFFSETS
from exoid.symbolic.codegen.information import largest_factor
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import JOINTS

SHIFTS = 64
"""Shifts in time per period that are tried to make two motions resemble each other."""
EDGE = 0.02
"""Share of the range that a free offset keeps from its ends."""


@dataclass(frozen=True, eq=False)
class MotionSpace:
    """Motions of `period` s inside `limits` (J, 4); `basis` (J, 2K, m) leads from the search's numbers to swings.

    `centre` (J,) is the fixed offset in rad, None where it is free.
    """

    period: float
    harmonics: int
    limits: Float
    basis: Float
    centre: Float | None
    joints: tuple[str, ...] = JOINTS
    whole: bool = True
    """Whether all coefficients are free, so that a motion may be shifted in time."""

    @property
    def size(self) -> int:
        """Number of variables of the search."""
        return int(self.basis.shape[0] * self.basis.shape[2] + (len(self.limits) if self.centre is None else 0))

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the numbers."""
        own = tuple(f"{joint}.y{k + 1}" for joint in self.joints for k in range(self.basis.shape[2]))
        return own + (tuple(f"{joint}.offset" for joint in self.joints) if self.centre is None else ())

    def split(self, y: Float) -> tuple[Float, Float]:
        """Return swings (I, J, 2K) before stretching and offsets (I, J) in rad for points `y` (I, n)."""
        count, (joints, _, width) = len(y), self.basis.shape
        swings = np.einsum("jkm,ijm->ijk", self.basis, y[:, : joints * width].reshape(count, joints, width))
        if self.centre is not None:
            return swings, np.broadcast_to(self.centre, (count, joints))
        low, high = self.limits[:, 0], self.limits[:, 1]
        part = 0.5 + (0.5 - EDGE) * y[:, joints * width :]
        return swings, low + part * (high - low)

    def aligned(self, y: Float, to: Float) -> Float:
        """Return points (I, n) as the same motions, begun later or run backwards so as to resemble the point `to` (n,).

        Only for spaces that are `whole`: harmonic k of all joints turns by k times one angle.
        """
        count, joints, width = len(y), len(self.limits), 2 * self.harmonics
        angle = np.arange(SHIFTS) * (2.0 * np.pi / SHIFTS)
        turns = np.exp(1j * np.outer(angle, np.arange(1, self.harmonics + 1)))
        waves = _waves(y[:, : joints * width].reshape(count, joints, 2, self.harmonics))
        wanted = _waves(to[: joints * width].reshape(1, joints, 2, self.harmonics))[0]
        both = np.stack([waves, -np.conj(waves)], axis=1)  # backwards: sines change sign
        alike = np.einsum("idjk,sk,jk->ids", both, turns, np.conj(wanted), optimize=True).real.reshape(count, -1)
        way, shift = np.divmod(tied(-alike, axis=1).argmax(axis=1), SHIFTS)
        best = both[np.arange(count), way] * turns[shift][:, None, :]
        out = y.copy()
        out[:, : joints * width] = np.stack([best.real, best.imag], axis=2).reshape(count, joints * width)
        return out

    def inside(self, swing: Float, offset: Float, grid: int = 500) -> Fourier:
        """Return the motion of one swing (J, 2K) about `offset` (J,), stretched to the first limit it meets."""
        motion = self.trajectory(swing, offset)
        along = motion.at(np.arange(grid) * (self.period / grid))
        return motion.scaled(largest_factor(along.q - offset, along.dq, along.ddq, offset, self.limits))

    def trajectory(self, swing: Float, offset: Float) -> Fourier:
        """Return the motion with swing (J, 2K) about `offset` (J,)."""
        return Fourier(offset, swing[:, : self.harmonics], swing[:, self.harmonics :], self.period)


def _waves(coefficients: Float) -> np.ndarray:
    """Return sines + i cosines (I, J, K) of coefficients (I, J, 2, K): a shift in time multiplies them."""
    return np.asarray(coefficients[:, :, 0] + 1j * coefficients[:, :, 1])


def motion_space(
    limits: Float,
    *,
    period: float = 10.0,
    harmonics: int = 5,
    offsets: str = "paper",
    rest: bool = False,
    joints: tuple[str, ...] = JOINTS,
) -> MotionSpace:
    """Return the space of motions inside `limits` (J, 4) (low and high angle, speed, acceleration).

    `offsets` is one of OFFSETS; `rest` makes velocity and acceleration zero at the start. TrajectoryError where no
    motion is left or the paper's centre is outside the limits.
    """
    if not (SHORTEST_PERIOD <= period <= LONGEST_PERIOD and 1 <= harmonics <= 20):
        remedy = f"give a period of {SHORTEST_PERIOD:g} to {LONGEST_PERIOD:g} s and 1 to 20 harmonics"
        raise TrajectoryError(f"a motion of {period:g} s with {harmonics} harmonics", remedy=remedy)
    if rest and harmonics < 2:
        what = "with one harmonic nothing but standing still starts at rest"
        raise TrajectoryError(what, remedy="use at least two harmonics")
    if offsets not in OFFSETS:
        raise TrajectoryError(f"offsets {offsets!r}", remedy=f"one of: {', '.join(OFFSETS)}")
    rates = np.arange(1, harmonics + 1) * (2.0 * np.pi / period)
    bases = []
    for low, high, speed, pull in limits:
        alone = np.minimum(np.minimum(0.5 * (high - low), speed / rates), pull / rates**2)
        weights = np.diag(np.tile(alone, 2))
        bases.append(weights @ (_at_rest(alone, harmonics) if rest else np.eye(2 * harmonics)))
    middle = 0.5 * (limits[:, 0] + limits[:, 1])
    centre = {"paper": np.array(CENTRE), "middle": middle, "free": None}[offsets]
    space = MotionSpace(float(period), harmonics, limits, np.array(bases), centre, joints)
    space = replace(space, whole=not rest)
    return space if centre is None else replace(space, centre=_inside(centre, limits, joints))


def _inside(centre: Float, limits: Float, joints: Sequence[str]) -> Float:
    for joint, value, (low, high, *_) in zip(joints, centre, limits, strict=True):
        if not low < value < high:
            what = f"the motion's centre {value:g} rad lies outside [{low:g}, {high:g}] rad"
            raise TrajectoryError(what, where=joint, remedy="use the middle of the range or free offsets")
    return centre


def _at_rest(alone: Float, harmonics: int) -> Float:
    """Return an orthonormal basis (2K, 2K - 2) of weighted coefficients with Σ k a_k = 0 and Σ k² b_k = 0."""
    k = np.arange(1, harmonics + 1)
    free = []
    for row in (k * alone, k**2 * alone):
        # What a reflection that takes the row to the first axis makes of the others: of all bases of that space a
        # library would find another on each machine, and the search another motion.
        mirror = row / np.linalg.norm(row) + np.eye(harmonics)[0]
        free.append((np.eye(harmonics) - np.outer(mirror, mirror) / mirror[0])[:, 1:])
    none = np.zeros_like(free[0])
    return np.block([[free[0], none], [none, free[1]]])
