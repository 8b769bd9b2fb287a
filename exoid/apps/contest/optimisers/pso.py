"""Particle swarm optimisation, one of the paper's rivals: each particle flies on, drawn to the best place it has
seen itself and to the best place of all.

pymoo's swarm as it comes: inertia and pulls adapt to how far the swarm has spread, and the best place is disturbed a
little at random. Source: Zhan, Zhang, Li, Chung, IEEE Trans. Systems, Man, Cybernetics B 39(6), 2009.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exoid.apps.contest.pymoo_engine import PymooRecipe, PymooState, begin
from exoid.ground.extras import needing
from exoid.optimisation.optimiser import Box
from exoid.symbolic.motion import Float


@dataclass(frozen=True)
class PSO(PymooRecipe):
    """`inertia`, `own` and `social` are the weights the adaptation starts from; `boundary`: see `BOUNDARIES`."""

    inertia: float = 0.9
    own: float = 2.0
    social: float = 2.0
    boundary: str = "clip"

    def start(self, x: Float, f: Float, box: Box, rng: np.random.Generator) -> PymooState:
        """Make the first population the swarm, with random velocities."""
        with needing("rivals", "PSO, GA and DE", "pymoo"):
            from pymoo.algorithms.soo.nonconvex.pso import PSO as Swarm
        return begin(Swarm(pop_size=len(x), w=self.inertia, c1=self.own, c2=self.social), x, f, box, rng)


OPTIMISER = PSO
