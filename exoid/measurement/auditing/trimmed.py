"""Stretches of time that a model explains best: least trimmed squares over windows.

Where something that nobody measured acts in part of the time (a foot on the ground, a hand), numbers fitted to all
samples are wrong everywhere; those fitted to the stretches that they explain best are right in the rest. Concentration
steps from many starts: Rousseeuw, Van Driessen: Computing LTS regression for large data sets, 2006.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, fields

import numpy as np
from numpy.typing import NDArray

from exoid.ground.thresholds import Threshold
from exoid.ground.ties import index_of_least, order_of
from exoid.symbolic.motion import Float

PART: Threshold = 0.2
"""part of the time that must be free of it: swing is a third of a stride, less what filters smear"""
SECTORS = 12
"""Parts of the cycle of every joint, its angle against its velocity, that are starts: contact has its phase."""
CHANCE, STRETCHES, SIDE = 48, 3, 3
"""Starts that are a few stretches of so many windows anywhere: a hand has no phase."""
SEEN = 0.5
"""Part of a window that must have been measured."""
STEPS, REFINED, MOST = 3, 6, 40
"""Steps from every start, how many of the best go on, and how many steps these may take."""

Mask = NDArray[np.bool_]
Solver = Callable[[Float, Float], Float]
"""Returns the numbers (S, P) that minimise x·gram·x - 2 x·slope, for each of S `gram` (P, P) and `slope` (P,)."""


@dataclass(frozen=True, eq=False)
class Windows:
    """Means over M stretches of a few samples: `gram` (M, P, P), `slope` (M, P), `power` (M,), all of weighted samples,
    the mean state (M, J) in each, `q` rad and `dq` rad/s, and its `first` sample (M,).
    """

    gram: Float
    slope: Float
    power: Float
    q: Float
    dq: Float
    first: NDArray[np.int_]

    def losses(self, x: Float) -> Float:
        """Return the mean squared error (S, M) of numbers `x` (S, P) in every window."""
        squares = (x[:, :, None] * x[:, None]).reshape(len(x), -1)
        return np.maximum(self.power - 2.0 * x @ self.slope.T + squares @ self.gram.reshape(len(self.power), -1).T, 0.0)

    def solved(self, chosen: Mask, solve: Solver) -> Float:
        """Return the numbers (S, P) that fit each S times the windows that are `chosen` (S, M) best."""
        gram = chosen.astype(float) @ self.gram.reshape(len(self.power), -1)
        return solve(gram.reshape(len(chosen), *self.gram.shape[1:]), chosen @ self.slope)


def windows_of(columns: Float, tau: Float, q: Float, dq: Float, seen: NDArray[np.bool_], length: int) -> Windows:
    """Return the windows of `length` samples of weighted columns (J, N, P) and torques (J, N), of which at least half
    are `seen` (J, N); sums are per seen sample. `q`, `dq` (N, J).
    """
    count = seen.shape[1] // length

    def cut(x: Float) -> Float:
        """Return x (..., N) in windows (M, ..., length)."""
        rows = x[..., : count * length].reshape(*x.shape[:-1], count, length)
        return np.moveaxis(rows, -2, 0)

    known = cut(seen.astype(float))
    share = known.mean(axis=(1, 2))
    whole = np.flatnonzero(share >= SEEN)
    weight = np.sqrt(known[whole] / (share[whole, None, None] * known[0].size))
    y = (cut(np.moveaxis(columns, 2, 0))[whole] * weight[:, None]).reshape(whole.size, columns.shape[2], -1)
    t = (cut(tau)[whole] * weight).reshape(whole.size, -1)
    slope, power = (y @ t[:, :, None])[:, :, 0], np.sum(t**2, axis=1)
    place, speed = (cut(x.T)[whole].mean(axis=2) for x in (q, dq))
    return Windows(y @ y.swapaxes(1, 2), slope, power, place, speed, whole * length)


def joined(parts: list[Windows]) -> Windows:
    """Return the windows of several recordings as one."""
    return Windows(*(np.concatenate([getattr(part, entry.name) for part in parts]) for entry in fields(Windows)))


def trimmed(windows: Windows, solve: Solver) -> tuple[Float, Mask] | None:
    """Return the numbers (P,) and a mask (M,) of the windows that they explain better than any others explain as many;
    None for too few windows.
    """
    most = int(PART * len(windows.power))
    if most < 2 * STRETCHES * SIDE:
        return None

    def steps(chosen: Mask, times: int) -> tuple[Float, Mask, Float]:
        """Squares left (S,) after so many steps, the windows (S, M) and the numbers (S, P)."""
        for _ in range(times):
            losses = windows.losses(x := windows.solved(chosen, solve))
            before, chosen = chosen, _first(losses, most)
            if np.array_equal(before, chosen):
                break
        return np.sum(losses, axis=1, where=chosen), chosen, x

    scale = float(windows.power.sum())
    left, chosen, _ = steps(_starts(windows, most), STEPS)
    left, chosen, x = steps(chosen[order_of(left, scale)[:REFINED]], MOST)
    k = index_of_least(left, scale)
    return x[k], chosen[k]


def _first(values: Float, most: int) -> Mask:
    """Return a mask of the `most` smallest in each row of `values` (S, M), and of those as small as the largest."""
    return np.asarray(values <= np.partition(values, most - 1, axis=1)[:, most - 1, None])


def _starts(windows: Windows, most: int) -> Mask:
    """Return the windows (S, M) from which each fit begins, the same every time."""
    away = []
    for q, dq in zip(windows.q.T, windows.dq.T, strict=True):
        phase = np.arctan2(dq / max(float(dq.std()), 1e-12), (q - q.mean()) / max(float(q.std()), 1e-12))
        middles = 2.0 * np.pi * np.arange(SECTORS)[:, None] / SECTORS
        away.append(np.abs(np.angle(np.exp(1j * (phase - middles)))))
    first = np.random.default_rng(0).integers(0, len(windows.power) - SIDE, (CHANCE, STRETCHES))
    few = np.zeros((CHANCE, len(windows.power)), dtype=bool)
    np.put_along_axis(few, (first[:, :, None] + np.arange(SIDE)).reshape(CHANCE, -1), True, axis=1)
    return np.concatenate([_first(np.concatenate(away), most), few])
