"""The fitness of a whole population for the data of a fit: compiled where the machine can compile."""

from __future__ import annotations

from typing import Protocol

from optimisation.linear.problem import LinearData
from symbolic.codegen.kernel import fitness
from symbolic.motion import Float


class PopulationLoss(Protocol):
    """SSE and Huber of a population (I, P) as (I,)."""

    def sse(self, population: Float) -> Float:
        """Return the SSE of each individual."""

    def huber(self, population: Float, delta: Float) -> Float:
        """Return the Huber loss of each individual for thresholds `delta` (J,)."""


def population_fitness(data: LinearData) -> PopulationLoss:
    """Return the fastest fitness this machine has for `data`."""
    return fitness(data.columns, data.tau)
