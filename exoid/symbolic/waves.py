"""Sines and cosines of many evenly spaced multiples of one signal, such as a sway at many frequencies."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from exoid.symbolic.motion import Float

FEW = 8
"""Trial values from which on waves are turned from one to the next."""
RENEWED = 128
"""Turns after which a wave is computed anew."""


@dataclass(frozen=True, eq=False)
class Waves:
    """Columns that are waves: for each of `carried` (m, A, N) a pair c · sin(n x) and c · cos(n x), along x, `phase`
    (N,). Of rows of shape values n stands at `place`.
    """

    carried: Float
    phase: Float
    place: int = 0
    _turns: dict[float, Any] = field(default_factory=dict)

    def turn(self, step: float) -> Any:
        """Return exp(i step x), (N,): by how much a wave differs from the one before."""
        if step not in self._turns:
            self._turns[step] = turned(step * self.phase)
        return self._turns[step]

    def __call__(self, shapes: Float) -> Float:
        """Return the columns (V, A, 2m, N) at `shapes` (V, S)."""
        numbers = shapes[:, self.place]
        pairs, *rest = self.carried.shape
        out = np.empty((len(numbers), pairs, 2, *rest))  # in the order in which columns are filtered
        for values, turn in zip(out, turns(numbers, self.phase), strict=True):
            np.multiply(np.ascontiguousarray(turn.imag), self.carried, out=values[:, 0])
            np.multiply(np.ascontiguousarray(turn.real), self.carried, out=values[:, 1])
        return np.swapaxes(out.reshape(len(numbers), 2 * pairs, *rest), 1, 2)


def sines(numbers: Float, x: Float) -> dict[str, Float]:
    """Return sin and cos of n x, (V, N), for evenly spaced `numbers` n (V,)."""
    sine, cosine = np.empty((len(numbers), len(x))), np.empty((len(numbers), len(x)))
    for s, c, turn in zip(sine, cosine, turns(numbers, x), strict=True):
        s[:], c[:] = turn.imag, turn.real
    return {"sin": sine, "cos": cosine}


def turns(numbers: Float, x: Float) -> Iterator[Any]:
    """Yield exp(i n x), (N,), for each of `numbers` n (V,): where they are evenly spaced each from the one before by a
    turn of step · x, which takes an eighth of the time of a sine, and anew every so often so that nothing adds up.
    """
    even = len(numbers) > 1 and are_even(numbers)
    now = step = turned(spacing(numbers) * x) if even else x
    for k, number in enumerate(numbers):
        now = now * step if even and k % RENEWED else turned(number * x)
        yield now


def turned(angle: Float) -> Any:
    """Return exp(i angle): NumPy has sine and cosine of many numbers at once, but no such complex exponential."""
    out = np.empty(angle.shape, dtype=complex)
    out.real, out.imag = np.cos(angle), np.sin(angle)
    return out


def spacing(numbers: Float) -> float:
    """Return the distance between evenly spaced numbers."""
    return float(numbers[-1] - numbers[0]) / (len(numbers) - 1)


def are_even(numbers: Float) -> bool:
    """True if numbers are evenly spaced."""
    step = np.diff(numbers)
    return bool(np.ptp(step) <= 1e-12 * np.abs(numbers).max())
