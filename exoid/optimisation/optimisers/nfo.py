"""Neighbourhood field optimisation: each individual leans on its nearest better and away from its nearest
worse.

    v = x + α rand∘(x_k - x) + α rand∘(x_k - x_w)

x_k is the nearest individual with smaller, x_w the nearest with larger fitness (itself where there is none);
binomial crossover with one forced component, greedy selection. Source: the paper, section 2.2; its equation
(1) prints f(x_k) > f(x_i) in the second line where it must be x_w. "Nearest" is Euclidean, so the
coordinates decide: on `problem.whitened()` with α = 1 the same rule is many orders more accurate.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar, NamedTuple

import numpy as np

from exoid.optimisation.optimiser import Box
from exoid.symbolic.motion import Float


class Field(NamedTuple):
    """The population `x` (I, n) with its fitness `f` (I,)."""

    x: Float
    f: Float


@dataclass(frozen=True)
class NFO:
    """`alpha`: length of the step; `crossover`: chance to take a component, `forced`: one is always taken; `boundary`:
    see `BOUNDARIES`. What each of them does is measured in docs/optimisation.md.
    """

    alpha: float = 0.8
    crossover: float = 0.5
    forced: bool = True
    boundary: str = "clip"
    invariances: ClassVar[frozenset[str]] = frozenset({"shift", "scale", "monotone"})

    def start(self, x: Float, f: Float, box: Box, rng: np.random.Generator) -> Field:
        """Keep the first population."""
        return Field(x, f)

    def ask(self, state: Field, rng: np.random.Generator) -> Float:
        """Return one trial point per individual."""
        x, f = state
        count, size = x.shape
        better, worse = _neighbours(x, f)
        pull, push = rng.random((2, count, size))
        toward = x[better]
        trial = x + self.alpha * (pull * (toward - x) + push * (toward - x[worse]))
        keep = rng.random((count, size)) >= self.crossover
        if self.forced:
            keep[np.arange(count), rng.integers(size, size=count)] = False
        return np.where(keep, x, trial)

    def tell(self, state: Field, x: Float, f: Float) -> Field:
        """Keep of each individual and its trial the better one."""
        won = f <= state.f
        return Field(np.where(won[:, None], x, state.x), np.where(won, f, state.f))


def _neighbours(x: Float, f: Float) -> tuple[np.ndarray, np.ndarray]:
    """Return the index (I,) of each individual's nearest better and nearest worse, itself where none is."""
    # Differences, not the cheaper |x|² + |y|² - 2xy: that loses all digits once the population has converged.
    along = x.T
    apart = along[:, :, None] - along[:, None, :]
    distance = np.einsum("pij,pij->ij", apart, apart)
    is_better = f[None, :] < f[:, None]
    own = np.arange(len(x))
    better = np.where(is_better, distance, np.inf).argmin(axis=1)
    worse = np.where(is_better.T, distance, np.inf).argmin(axis=1)
    return np.where(is_better.any(axis=1), better, own), np.where(is_better.any(axis=0), worse, own)


OPTIMISER = NFO
