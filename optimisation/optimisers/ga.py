"""Genetic algorithm, one of the paper's rivals: two parents chosen by tournament mix their numbers, a few are
mutated, the best of old and new survive.

pymoo's GA as it comes: binary tournament, simulated binary crossover, polynomial mutation, no individual twice.
Source: Deb, Agrawal, Complex Systems 9, 1995 (crossover); Deb, Goyal, Computer Science and Informatics 26, 1996.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import ClassVar

import numpy as np

from optimisation.optimiser import Box
from optimisation.pymoo_engine import PymooState, ask, begin, tell
from symbolic.motion import Float


@dataclass(frozen=True)
class GA:
    """`crossover_index`, `mutation_index`: how near children stay to parents; `boundary`: see `BOUNDARIES`."""

    crossover_index: float = 15.0
    mutation_index: float = 20.0
    boundary: str = "clip"
    invariances: ClassVar[frozenset[str]] = frozenset({"shift", "scale", "axes", "monotone"})

    def start(self, x: Float, f: Float, box: Box, rng: np.random.Generator) -> PymooState:
        """Make the first population the first generation of parents."""
        from pymoo.algorithms.soo.nonconvex.ga import GA as Genetic
        from pymoo.operators.crossover.sbx import SBX
        from pymoo.operators.mutation.pm import PM

        crossover, mutation = SBX(eta=self.crossover_index), PM(eta=self.mutation_index)
        return begin(Genetic(pop_size=len(x), crossover=crossover, mutation=mutation), x, f, box, rng)

    def ask(self, state: PymooState, rng: np.random.Generator) -> Float:
        """Return the children."""
        return ask(state, rng)

    def tell(self, state: PymooState, x: Float, f: Float) -> PymooState:
        """Let the best of parents and children survive."""
        return tell(state, x, f)


OPTIMISER = GA
