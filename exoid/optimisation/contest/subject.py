"""Subject of a comparison of optimisers: a problem, a budget, and the best value that is known of it.

Two problems have this form: the fit of a leg, whose optimum is proven (`problem.py`), and the design of a motion, of
which a best known is there (`motion.py`).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from exoid.ground.errors import ExoidError
from exoid.optimisation.budget import GENERATIONS, INDIVIDUALS
from exoid.optimisation.fitting.settings import Search
from exoid.optimisation.linear.certificate import Certificate
from exoid.optimisation.linear.problem import Problem
from exoid.symbolic.motion import Float


class ContestError(ExoidError):
    """A comparison that would mean nothing."""


@dataclass(frozen=True, eq=False, kw_only=True)
class ContestSubject(ABC):
    """A problem called `name` with a budget of `individuals` × `generations` evaluations."""

    goal: ClassVar[str]
    """What distances are measured from, in words."""
    targets: ClassVar[tuple[float, ...]]
    """Relative distances that a run may come to, falling; the last is the one that is asked for."""
    drawn: ClassVar[Float]
    """Those that are drawn."""
    floor: ClassVar[float]
    """Distances below this are drawn as this: they are none."""
    delta: ClassVar[Float | None] = None
    certificate: ClassVar[Certificate | None] = None

    name: str
    individuals: int = INDIVIDUALS
    generations: int = GENERATIONS

    def __post_init__(self) -> None:
        if self.individuals < 4 or self.generations < 2:
            what = f"{self.individuals} individuals for {self.generations} generations are no comparison"
            raise ContestError(what, remedy="give at least 4 individuals and 2 generations")

    @property
    def budget(self) -> int:
        """Evaluations each run may spend."""
        return self.individuals * self.generations

    @property
    @abstractmethod
    def function(self) -> str:
        """The short name of what is minimised."""

    @property
    @abstractmethod
    def size(self) -> int:
        """Number of unknowns."""

    @property
    @abstractmethod
    def best(self) -> float:
        """The least value that is known."""

    @property
    @abstractmethod
    def standard(self) -> str:
        """Origin of the least value, in words."""

    @abstractmethod
    def gap(self, value: Float) -> Float:
        """Distance of values above the best, relative to it; at the best or below it is 0."""

    @abstractmethod
    def value(self, x: Float, search: Search) -> float:
        """Value of the point `x` (n,) that a run of `search` ended with."""

    @abstractmethod
    def setting(self, search: Search, seed: int) -> tuple[Problem, Float]:
        """Return the problem as `search` sees it, and the first population (I, n) of a seed."""

    @abstractmethod
    def fingerprint(self) -> str:
        """Return a SHA-256 of everything about the problem and the budget that a result depends on."""

    def about(self) -> Mapping[str, Any]:
        """Further facts about the problem."""
        return {}

    def draws(self, seed: int, count: int) -> Float:
        """Return numbers (I, count) between 0 and 1, the same for all who compete."""
        # A stream of its own, so that an optimiser's first numbers are not those of the first population.
        return np.random.default_rng([seed, 1]).random((self.individuals, count))
