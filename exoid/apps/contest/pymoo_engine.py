"""Drives an algorithm of pymoo by our contract: it proposes and learns, we evaluate, count and draw the numbers.

pymoo's own loop, display, history, termination and copies are left out; what remains is `ask` and `tell` of the
algorithm object. It draws from our generator, so a seed means the same for every optimiser.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from exoid.optimisation.optimiser import Box
from exoid.symbolic.motion import Float


class PymooRecipe:
    """Common part of recipes of pymoo's algorithms: `ask` and `tell`, and what changes none of their runs."""

    invariances: ClassVar[frozenset[str]] = frozenset({"shift", "scale", "axes", "monotone"})

    def ask(self, state: PymooState, rng: np.random.Generator) -> Float:
        """Return the next candidates (I, n)."""
        algorithm = state.algorithm
        algorithm.random_state = rng
        state.asked = algorithm.ask()
        if state.asked is None or not len(state.asked):
            # Everything it can breed is there already (a population on one point): a new one, drawn from the box.
            algorithm.termination.force_termination = False
            low, high = state.box
            state.asked = _population(low + rng.random((len(algorithm.pop), low.size)) * (high - low))
        return np.asarray(state.asked.get("X"), dtype=float)

    def tell(self, state: PymooState, x: Float, f: Float) -> PymooState:
        """Hand the fitness `f` (I,) of the candidates, as they were evaluated (`x`), to pymoo."""
        # The individuals asked for carry more than their place (a particle its velocity), so they are kept.
        state.asked.set("X", x)
        state.asked.set("F", f[:, None])
        state.algorithm.tell(infills=state.asked)
        return state


@dataclass(eq=False)
class PymooState:
    """The state: pymoo's `algorithm`, which changes itself, and what it `asked` for last."""

    algorithm: Any
    asked: Any
    box: Box


def begin(algorithm: Any, x: Float, f: Float, box: Box, rng: np.random.Generator) -> PymooState:
    """Return the state of `algorithm` after a first population `x` (I, n) with fitness `f` (I,)."""
    from pymoo.core.problem import Problem
    from pymoo.core.termination import NoTermination

    # pymoo divides by the width of the box; on an axis without room it gets some, which the loop clips away.
    high = np.where(box.high > box.low, box.high, box.low + 1.0)
    problem = Problem(n_var=x.shape[1], n_obj=1, xl=box.low, xu=high)
    # A seed of its own keeps pymoo from touching the global one; it is never drawn from.
    algorithm.setup(problem, termination=NoTermination(), seed=0)
    algorithm.random_state = rng
    algorithm.display = lambda shown: None
    return PymooRecipe().tell(PymooState(algorithm, _population(x), box), x, f)


def _population(x: Float) -> Any:
    from pymoo.core.population import Population

    return Population.new("X", x)
