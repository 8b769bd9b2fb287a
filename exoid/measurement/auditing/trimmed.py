"""Stretches of time that a model explains best: least trimmed squares over windows.

Where something that nobody measured acts in part of the time (a foot on the ground, a hand), numbers fitted to all
samples are wrong everywhere; those fitted to the stretches that they explain best are right in the rest. Concentration
steps from many starts: Rousseeuw, Van Driessen: Computing LTS regression for large data sets, 2006.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exoid.ground.thresholds import threshold
from exoid.ground.ties import index_of_least, order_of
from exoid.symbolic.motion import Float

PART = threshold(
    __name__, "PART", 0.2,
    "part of the time that must be free of it: swing is a third of a stride, less what filters smear",
)  # fmt: skip
SECTORS = 12
"""Parts of the cycle of every joint, its angle against its velocity, that are starts: contact has its phase."""
CHANCE, STRETCHES, SIDE = 48, 3, 3
"""Starts that are a few stretches of so many windows anywhere: a hand has no phase."""
SEEN = 0.5
"""Part of a window that must have been measured."""
STEPS, REFINED, MOST = 3, 6, 40
"""Steps from every start, how many of the best go on, and how many steps these may take."""

Solver = Callable[[Float, Float], Float]
"""Returns the numbers (P,) that minimise x·gram·x - 2 x·slope."""


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
        """Return the mean squared error (M,) of numbers `x` (P,) in every window."""
        flat = self.gram.reshape(len(self.power), -1)
        return np.maximum(self.power - 2.0 * self.slope @ x + flat @ np.outer(x, x).ravel(), 0.0)

    def solved(self, chosen: NDArray[np.int_], solve: Solver) -> Float:
        """Return the numbers (P,) that fit the windows `chosen` best."""
        return solve(self.gram[chosen].sum(axis=0), self.slope[chosen].sum(axis=0))


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
    states = [cut(x.T)[whole].mean(axis=2) for x in (q, dq)]
    return Windows(y @ y.swapaxes(1, 2), slope, power, states[0], states[1], whole * length)


def joined(parts: list[Windows]) -> Windows:
    """Return the windows of several recordings as one."""
    names = ("gram", "slope", "power", "q", "dq", "first")
    return Windows(*(np.concatenate([getattr(part, name) for part in parts]) for name in names))


def trimmed(windows: Windows, solve: Solver) -> tuple[Float, NDArray[np.int_]] | None:
    """Return the numbers (P,) and the windows that they explain better than any others explain as many; None for too
    few windows.
    """
    most = int(PART * len(windows.power))
    if most < 2 * STRETCHES * SIDE:
        return None

    def step(chosen: NDArray[np.int_], times: int) -> tuple[float, NDArray[np.int_], Float]:
        x, losses = np.zeros(0), np.zeros(0)
        for _ in range(times):
            x = windows.solved(chosen, solve)
            losses = windows.losses(x)
            before, chosen = chosen, np.sort(np.argsort(losses, kind="stable")[:most])
            if np.array_equal(before, chosen):
                break
        return float(losses[chosen].sum()), chosen, x

    begun = [step(start, STEPS) for start in _starts(windows, most)]
    best = order_of([item[0] for item in begun], float(windows.power.sum()))[:REFINED]
    ended = [step(begun[k][1], MOST) for k in best]
    _, chosen, x = ended[index_of_least([entry[0] for entry in ended], float(windows.power.sum()))]
    return x, chosen


def _starts(windows: Windows, most: int) -> list[NDArray[np.int_]]:
    """Return from which windows the fits begin, the same every time."""
    out = []
    for q, dq in zip(windows.q.T, windows.dq.T, strict=True):
        phase = np.arctan2(dq / max(float(dq.std()), 1e-12), (q - q.mean()) / max(float(q.std()), 1e-12))
        for middle in 2.0 * np.pi * np.arange(SECTORS) / SECTORS:
            away = np.abs(np.angle(np.exp(1j * (phase - middle))))
            out.append(np.argsort(away, kind="stable")[:most])
    rng = np.random.default_rng(0)
    for first in rng.integers(0, len(windows.power) - SIDE, (CHANCE, STRETCHES)):
        out.append(np.unique(first[:, None] + np.arange(SIDE)))
    return out
