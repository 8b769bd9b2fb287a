"""The fitness of a whole population: compiled where the machine can, and the same numbers in NumPy."""

from __future__ import annotations

from typing import Protocol

from optimisation.loss import PopulationFitness
from optimisation.problem import LinearData
from symbolic.motion import Float


class Fitness(Protocol):
    """SSE and Huber of a population (I, P) as (I,)."""

    def sse(self, population: Float) -> Float:
        """Return the SSE of each individual."""

    def huber(self, population: Float, delta: Float) -> Float:
        """Return the Huber loss of each individual for thresholds `delta` (J,)."""


def population_fitness(data: LinearData) -> Fitness:
    """Return the fastest fitness this machine has for `data`."""
    return PopulationFitness(data.columns, data.tau)
