"""CMA-ES: draws candidates from a normal distribution and learns its centre, size and shape from the better half.

The algorithm of its author, N. Hansen's `cma`, in coordinates in which the box is a unit cube; the first centre is the
mean of the better half of the first population. It is begun anew from a random place whenever `cma` says that it has
converged, as is usual under a fixed budget. Source: Hansen, "The CMA Evolution Strategy: A Tutorial", arXiv:1604.00772.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from exoid.optimisation.optimiser import Box
from exoid.symbolic.motion import Float


@dataclass(eq=False)
class Strategy:
    """The state: `cma`'s strategy, which changes itself; the box; how many candidates; what it `asked` for last."""

    strategy: Any
    box: Box
    count: int
    asked: Float


@dataclass(frozen=True)
class CMAES:
    """`spread`: first standard deviation as a share of the box; `boundary`: see `BOUNDARIES`."""

    spread: float = 0.3
    boundary: str = "clip"
    invariances: ClassVar[frozenset[str]] = frozenset({"shift", "scale", "axes", "monotone"})

    def start(self, x: Float, f: Float, box: Box, rng: np.random.Generator) -> Strategy:
        """Begin in the middle of the better half of the first population."""
        better = x[np.argsort(f, kind="stable")[: (len(x) + 1) // 2]]
        place = np.clip((better.mean(axis=0) - box.low) / _width(box), 0.0, 1.0)
        return Strategy(self._begin(place, len(x), rng), box, len(x), x)

    def ask(self, state: Strategy, rng: np.random.Generator) -> Float:
        """Return candidates drawn from the distribution."""
        if state.strategy.stop():
            state.strategy = self._begin(rng.random(state.box.low.size), state.count, rng)
        state.asked = np.array(state.strategy.ask())
        return state.box.low + state.asked[:, : state.box.low.size] * _width(state.box)

    def tell(self, state: Strategy, x: Float, f: Float) -> Strategy:
        """Learn from the candidates; what lies at infinity ranks last."""
        state.strategy.tell(list(state.asked), np.minimum(f, np.finfo(float).max).tolist())
        return state

    def _begin(self, place: Float, count: int, rng: np.random.Generator) -> Any:
        import cma

        # `cma` wants two dimensions; a second one that nobody looks at changes nothing.
        middle = place if place.size > 1 else np.append(place, 0.5)
        options = {
            "bounds": [0.0, 1.0],
            "popsize": max(count, 2),
            "randn": lambda *shape: rng.standard_normal(shape),
            "seed": np.nan,
            "verbose": -9,
            # Only the distribution's own size may stop it: limits on the fitness depend on its units.
            "tolfun": 0.0,
            "tolfunhist": 0.0,
            "tolfunrel": 0.0,
            "tolx": 1e-14,
        }
        return cma.CMAEvolutionStrategy(middle, self.spread, options)


def _width(box: Box) -> Float:
    return np.where(box.high > box.low, box.high - box.low, 1.0)


OPTIMISER = CMAES
