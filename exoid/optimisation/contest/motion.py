"""The paper's other problem as a contest: coefficients of a motion inside the limits that are best by a criterion.

    rescaled     every candidate is stretched or shrunk to the first limit it meets; coefficients within ±1 rad
    penalty      infinite outside the limits, as the paper has it; within ±0.2 rad, where some of the first are inside
    whitened     rescaled, in coordinates in which all harmonics weigh alike, as `exoid design` searches

The problem is not convex and no optimum is proven: distances are measured from the best motion known, which is the best
of what `exoid design` refines and of IPOPT from several starts.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

import numpy as np

from exoid.ground.extras import version_of
from exoid.optimisation.contest.settings import MOTIONS
from exoid.optimisation.contest.subject import ContestError, ContestSubject
from exoid.optimisation.excitation.design import design, search_of
from exoid.optimisation.excitation.result import MEANING, Excitation
from exoid.optimisation.excitation.search import MotionSearch
from exoid.optimisation.excitation.settings import DesignSettings
from exoid.optimisation.fitting.settings import Search
from exoid.optimisation.linear.problem import Problem
from exoid.symbolic.codegen.fingerprint import model_key
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

VERSION = 1
"""Raised when a change of the code makes results kept on disk those of another experiment."""
WIDE, NARROW = 1.0, 0.2
"""rad within which coefficients are sought: with rescaling, and with an infinite penalty."""
STARTS = 3
"""Starts of IPOPT."""


@dataclass(frozen=True)
class MotionEntrant(Search):
    """An optimiser of motions: `penalised` outside the limits, or rescaled; `whitened`: all harmonics weigh alike.

    Coefficients are sought within ±`half` rad, or as wide as is usual for either.
    """

    penalised: bool = False
    half: float | None = None

    @property
    def width(self) -> float:
        """Half of the width of the box, rad."""
        return self.half or (NARROW if self.penalised else WIDE)


@dataclass(frozen=True, eq=False, kw_only=True)
class MotionContest(ContestSubject):
    """Minimise `criterion` over motions of `model`; `known` {name: value} are the references, least first."""

    goal: ClassVar[str] = "best motion known"
    targets: ClassVar[tuple[float, ...]] = (0.5, 0.2, 0.1, 0.05, 0.02, 0.01)
    drawn: ClassVar[Float] = np.logspace(0.0, -3.0, 49)
    floor: ClassVar[float] = 1e-4

    model: Model
    criterion: str
    known: Mapping[str, float] = field(repr=False)
    individuals: int = MOTIONS

    @property
    def function(self) -> str:
        """The criterion."""
        return self.criterion

    @property
    def size(self) -> int:
        """Number of coefficients."""
        return self._search(False).space.size

    @property
    def best(self) -> float:
        """The criterion of the best motion known."""
        return min(self.known.values())

    @property
    def standard(self) -> str:
        """Origin of the best known value."""
        each = ", ".join(f"{name} {value:.5g}" for name, value in self.known.items())
        return f"{MEANING[self.criterion]}, best known {self.best:.5g} ({each}); no optimum is claimed"

    def gap(self, value: Float) -> Float:
        """Distance of values above the best known: as a share of it, and of the mean half-axis of the ellipsoid."""
        values = np.asarray(value, dtype=float)
        if self.criterion == "d_optimal":
            numbers = len(self._search(False).info.names)
            return np.maximum(np.expm1(np.minimum((values - self.best) / (2.0 * numbers), 700.0)), 0.0)
        return np.maximum((values - self.best) / abs(self.best), 0.0)

    def value(self, x: Float, search: Search) -> float:
        """Return the criterion of a motion."""
        problem, _ = self.setting(search, 0)
        return float(problem.fitness(x[None])[0])

    def setting(self, search: Search, seed: int) -> tuple[Problem, Float]:
        """Return the problem in rad, or in shares of what each harmonic alone may do, and the first motions."""
        entrant = search if isinstance(search, MotionEntrant) else MotionEntrant(search.optimiser, search.whitened)
        motions, half = self._search(entrant.penalised), entrant.width
        joints, _, width = motions.space.basis.shape
        alone = np.concatenate([np.diag(item) for item in motions.space.basis])
        scale = np.ones(joints * width) if search.whitened else alone
        edge = np.full(joints * width, half)
        problem = Problem(
            lambda x: motions.value(x / scale), -edge, edge, motions.space.names,
            ("1" if search.whitened else "rad",) * len(edge),
        )  # fmt: skip
        return problem, half * (2.0 * self.draws(seed, len(edge)) - 1.0)

    def fingerprint(self) -> str:
        """Return a SHA-256 of the model, the criterion, the references and the budget."""
        versions = [version_of(name) for name in ("numpy", "pymoo", "cma")]
        sizes = [VERSION, model_key(self.model), self.criterion, self.best, self.individuals, self.generations]
        return hashlib.sha256(json.dumps([sizes, versions]).encode()).hexdigest()

    def about(self) -> Mapping[str, Any]:
        """Return the criterion and the references."""
        return {"criterion": self.criterion, "known": dict(self.known)}

    def _search(self, penalised: bool) -> MotionSearch:
        """Evaluator of motions; it holds compiled code, so each process makes its own."""
        key = model_key(self.model), self.criterion, penalised
        if key not in _SEARCHES:
            _SEARCHES[key] = search_of(self.model, DesignSettings(criterion=self.criterion, printed=penalised))
        return _SEARCHES[key]


_SEARCHES: dict[tuple[str, str, bool], MotionSearch] = {}
"""What evaluates motions of this process."""


def motion_contest(
    model: Model | None = None, criterion: str = "condition", seed: int = 0, individuals: int | None = None,
    generations: int | None = None, found: Excitation | None = None,
) -> MotionContest:  # fmt: skip
    """Return the contest of motions for `model` (the standard leg), with the candidates of `found`, which was designed
    for it, as references; those of a design from `seed` where none is given. ContestError where `found` is a motion of
    another kind than those that compete.
    """
    usual = DesignSettings(criterion=criterion)
    if found is not None:
        motion = found.trajectory
        theirs = {"period": motion.period, "harmonics": motion.sine.shape[1], "offsets": found.offsets,
                  "rest": found.rest}  # fmt: skip
        other = [f"{name}={value!r}" for name, value in theirs.items() if value != getattr(usual, name)]
        if other:
            what = f"this motion was designed with {', '.join(other)}, and those that compete are not"
            raise ContestError(what, remedy="give its model in place of it, or design it without")
    leg = Model.standard() if model is None else model
    size = {"individuals": individuals, "generations": generations}
    given = {name: number for name, number in size.items() if number is not None}
    name = f"motions of {leg.name}"
    contest = MotionContest(name=name, model=leg, criterion=criterion, known={}, **given)
    found = found or design(leg, criterion=criterion, starts=STARTS, seed=seed)
    values = sorted(((candidate.name, candidate.value) for candidate in found.candidates), key=lambda one: one[1])
    return replace(contest, known=dict(values))


def motion_entrants(kinds: Mapping[str, Any], whitened: bool = False) -> dict[str, Search]:
    """Entrants: every one of `kinds` with rescaled motions and with the infinite penalty."""
    found: dict[str, Search] = {name: MotionEntrant(kind()) for name, kind in kinds.items()}
    found |= {f"{name}_penalty": MotionEntrant(kind(), penalised=True) for name, kind in kinds.items()}
    if whitened:
        found |= {f"{name}_whitened": MotionEntrant(kind(), whitened=True) for name, kind in kinds.items()}
    return found
