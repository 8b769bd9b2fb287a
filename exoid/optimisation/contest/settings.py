"""Settings of a comparison of optimisers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, TypedDict

from exoid.ground.settings import VerbSettings, setting
from exoid.optimisation.budget import GENERATIONS, INDIVIDUALS
from exoid.optimisation.excitation.settings import CRITERION_NAMES

if TYPE_CHECKING:
    from concurrent.futures import Executor

    from exoid.ground.engines.engine import Engine
    from exoid.optimisation.fitting.settings import Search

SEEDS = 51
PROBLEMS = ("identification", "excitation")
"""The paper's two problems."""
MOTIONS = 20
"""The paper's population for motions."""


class ContestOptions(TypedDict, total=False):
    """`ContestSettings` as keywords."""

    seed: int
    seeds: int
    individuals: int | None
    problem: str
    criterion: str
    generations: int
    competing: Mapping[str, Search] | None
    whitened: bool
    folder: str | Path | None
    jobs: int
    engine: Engine | Executor | None


@dataclass(frozen=True, kw_only=True)
class ContestSettings(VerbSettings):
    """Entrants, budget, and the place where runs are made and kept."""

    seeds: int = setting(SEEDS, "runs of each optimiser", 0, 10_000)
    problem: str = setting(
        "identification", "what is competed on: identification (a fit) or excitation (motions)", choices=PROBLEMS
    )
    criterion: str = setting("condition", "of excitation: what motions are evaluated by", choices=CRITERION_NAMES)
    individuals: int | None = setting(None, f"size of the population ({INDIVIDUALS}; {MOTIONS} for motions)")
    generations: int = setting(GENERATIONS, "generations", 0, 1_000_000)
    competing: Mapping[str, Search] | None = setting(None, "{name: Search}; without it, `entrants(whitened)`")
    whitened: bool = setting(False, "let the rivals search in whitened coordinates as well, as NFO does")
    folder: str | Path | None = setting(
        None, "keeps every run in a file of its own, from which a comparison that was stopped goes on"
    )
    jobs: int = setting(0, "processes of this machine; 0: one per core", 0, 1024)
    engine: Engine | Executor | None = setting(
        None, "any open concurrent.futures.Executor, closed by the caller, in place of these processes"
    )
