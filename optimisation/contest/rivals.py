"""NFO and its rivals on the same problem, against the proven optimum, often enough that chance has no say.

    rivals()                         the paper's leg on the virtual bench, 51 seeds
    rivals(fit)                      the problem of a fit (or: a model and its recordings, as for `identify`)

Runs are spread over processes of this machine, or over any other of `ground.engines`:

    rivals(engine=dask("tcp://scheduler:8786"))
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from ground.engines.engine import Engine, completed
from ground.engines.processes import processes
from optimisation.contest.problem import Contest, ContestError, Outcome, contest_of, paper_contest, race
from optimisation.contest.standings import Rivals
from optimisation.contest.store import RunStore
from optimisation.fitting.fit import Fit
from optimisation.fitting.identify import SEARCHES, Search, identify
from optimisation.optimiser import GENERATIONS, INDIVIDUALS
from optimisation.optimisers import optimisers
from symbolic.model import Model

if TYPE_CHECKING:
    from measurement.recording import Recording
    from optimisation.fitting.assemble import FilteredRecording, FittableModel

SEEDS = 51
Progress = Callable[[float, str], None]


def entrants(whitened: bool = False) -> Mapping[str, Search]:
    """Return who competes: NFO as printed and whitened, and every other file of `optimisers/` as it comes.

    With `whitened` each of the others competes in whitened coordinates too.
    """
    found = dict(SEARCHES)
    others = {name: kind for name, kind in optimisers().items() if name != "nfo"}
    found |= {name: Search(kind()) for name, kind in others.items()}
    if whitened:
        found |= {f"{name}_whitened": Search(kind(), whitened=True) for name, kind in others.items()}
    return found


def rivals(
    subject: FittableModel | Fit | Contest | None = None,
    recordings: Sequence[FilteredRecording] | Sequence[Recording] = (),
    *,
    seeds: int = SEEDS,
    seed: int = 0,
    individuals: int = INDIVIDUALS,
    generations: int = GENERATIONS,
    competing: Mapping[str, Search] | None = None,
    whitened: bool = False,
    folder: str | Path | None = None,
    jobs: int = 0,
    engine: Engine | None = None,
    progress: Progress | None = None,
) -> Rivals:
    """Let all optimisers run from `seeds` first populations and return who came how near, how fast.

    `competing` {name: Search} names others than `entrants(whitened)`. `folder` keeps every run in a file of its own:
    what is there is not run again, so a comparison that was stopped goes on where it was. `jobs` processes of this
    machine (0: one per core) run them, or an open `engine` that the caller closes.
    Refuses fewer than two seeds, and a problem without a proven optimum.
    """
    began = time.perf_counter()
    if seeds < 2:
        raise ContestError(
            "one seed cannot show run-to-run variation",
            where=f"--seeds {seeds}",
            remedy=f"give two at least, better {SEEDS}",
        )
    contest = _contest(subject, recordings, seed, individuals, generations)
    searches = dict(competing or entrants(whitened))
    tasks = [(name, k) for k in range(seed, seed + seeds) for name in searches]
    store = RunStore(folder, contest)
    done = {task: kept for task in tasks if (kept := store.read(task[0], searches[task[0]], task[1])) is not None}
    if store.damaged:
        warnings.warn(
            f"{store.damaged} of the runs kept in {folder} are damaged or were altered; they are run again",
            UserWarning,
            stacklevel=2,
        )
    missing = [task for task in tasks if task not in done]
    resumed = len(done)
    report = progress or _silent
    for outcome in _run(contest, searches, missing, jobs, engine):
        store.write(outcome, searches[outcome.name])
        done[outcome.name, outcome.seed] = outcome
        report(len(done) / len(tasks), f"{outcome.name}, seed {outcome.seed}: gap {outcome.gap:.0e}")
    outcomes = {name: tuple(done[name, k] for k in range(seed, seed + seeds)) for name in searches}
    return Rivals(contest, searches, outcomes, time.perf_counter() - began, resumed)


def _contest(subject: Any, recordings: Any, seed: int, individuals: int, generations: int) -> Contest:
    if isinstance(subject, Contest):
        return subject
    if isinstance(subject, Fit):
        return contest_of(subject, individuals, generations)
    if subject is None and not recordings:
        return paper_contest(seed, individuals, generations)
    if subject is None:
        subject = Model.standard()
    return contest_of(identify(subject, recordings, optimisers=(), seed=seed), individuals, generations)


def _run(
    contest: Contest, searches: Mapping[str, Search], tasks: Sequence[tuple[str, int]], jobs: int, engine: Engine | None
) -> Iterator[Outcome]:
    """Yield outcomes as they come."""
    if not tasks:
        return
    chosen = processes(jobs) if engine is None else engine
    ended = False
    try:
        for _, future in completed(chosen, race, tasks, lambda task: (contest, task[0], searches[task[0]], task[1])):
            yield future.result()
        ended = True
    finally:
        if engine is None:
            chosen.close(ended)


def _silent(fraction: float, text: str) -> None:
    """Say nothing."""


__all__ = ["Contest", "Outcome", "Rivals", "entrants", "rivals"]
