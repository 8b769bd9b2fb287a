"""Differential evolution: a candidate is one individual plus the scaled difference of two others, mixed with the
one it wants to replace.

    v = x_a + F (x_b - x_c),   binomial crossover with chance CR, greedy selection        "DE/rand/1/bin"

pymoo's DE with Storn and Price's first choice for parameters that depend on each other (F = 0.5, CR = 0.9), and
without the mutation pymoo adds, which is not part of DE: with pymoo's own settings (best/1, CR = 0.2) it stays nine
orders of magnitude further away here. Source: Storn, Price, Journal of Global Optimization 11, 1997.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exoid.apps.contest.pymoo_engine import PymooRecipe, PymooState, begin
from exoid.ground.extras import needing
from exoid.optimisation.optimiser import Box
from exoid.symbolic.motion import Float


@dataclass(frozen=True)
class DE(PymooRecipe):
    """`weight` F of the difference, `crossover` CR, `base`: "rand" or "best"; `boundary`: see `BOUNDARIES`."""

    weight: float = 0.5
    crossover: float = 0.9
    base: str = "rand"
    boundary: str = "clip"

    def start(self, x: Float, f: Float, box: Box, rng: np.random.Generator) -> PymooState:
        """Keep the first population."""
        with needing("rivals", "PSO, GA and DE", "pymoo"):
            from pymoo.algorithms.soo.nonconvex.de import DE as Differential
        variant = f"DE/{self.base}/1/bin"
        evolution = Differential(pop_size=len(x), variant=variant, F=self.weight, CR=self.crossover, prob_mut=0.0)
        return begin(evolution, x, f, box, rng)


OPTIMISER = DE
