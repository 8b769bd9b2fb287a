"""Genetic algorithm, one of the paper's rivals: two parents chosen by tournament mix their numbers, a few are
mutated, the best of old and new survive.

pymoo's GA as it comes: binary tournament, simulated binary crossover, polynomial mutation, no individual twice.
Source: Deb, Agrawal, Complex Systems 9, 1995 (crossover); Deb, Goyal, Computer Science and Informatics 26, 1996.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exoid.apps.contest.pymoo_engine import PymooRecipe, PymooState, begin
from exoid.ground.extras import needing
from exoid.optimisation.optimiser import Box
from exoid.symbolic.motion import Float


@dataclass(frozen=True)
class GA(PymooRecipe):
    """`crossover_index`, `mutation_index`: how near children stay to parents; `boundary`: see `BOUNDARIES`."""

    crossover_index: float = 15.0
    mutation_index: float = 20.0
    boundary: str = "clip"

    def start(self, x: Float, f: Float, box: Box, rng: np.random.Generator) -> PymooState:
        """Make the first population the first generation of parents."""
        with needing("rivals", "PSO, GA and DE", "pymoo"):
            from pymoo.algorithms.soo.nonconvex.ga import GA as Genetic
            from pymoo.operators.crossover.sbx import SBX
            from pymoo.operators.mutation.pm import PM
        crossover, mutation = SBX(eta=self.crossover_index), PM(eta=self.mutation_index)
        return begin(Genetic(pop_size=len(x), crossover=crossover, mutation=mutation), x, f, box, rng)


OPTIMISER = GA
