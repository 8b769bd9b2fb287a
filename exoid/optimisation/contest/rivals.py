"""NFO and its rivals on the same problem, against the best that is known, often enough that chance has no say.

    rivals()                         the paper's leg on the virtual bench, 51 seeds
    rivals(fit)                      the problem of a fit (or: a model and its recordings, as for `identify`)
    rivals(problem="excitation")     motions inside the limits of a leg, against the best one known
    rivals(design(leg, starts=1))    the same, against what was designed already

Runs are spread over processes of this machine, or over any `concurrent.futures.Executor`:

    rivals(engine=Client("tcp://scheduler:8786").get_executor())        of `distributed`
    rivals(engine=get_reusable_executor(8))            of loky
"""

from __future__ import annotations

import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any, Unpack

from exoid.ground.engines.engine import completed
from exoid.ground.engines.processes import in_processes
from exoid.ground.progress import Progress, silent
from exoid.optimisation.budget import INDIVIDUALS
from exoid.optimisation.contest.motion import motion_contest, motion_entrants
from exoid.optimisation.contest.problem import Contest, Outcome, contest_of, paper_contest, race
from exoid.optimisation.contest.settings import SEEDS, ContestOptions, ContestSettings
from exoid.optimisation.contest.standings import Rivals
from exoid.optimisation.contest.store import RunStore
from exoid.optimisation.contest.subject import ContestError, ContestSubject
from exoid.optimisation.excitation.result import Excitation
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.fitting.identify import SEARCHES, identify
from exoid.optimisation.fitting.settings import Search
from exoid.optimisation.optimisers import optimisers
from exoid.symbolic.model import Model

if TYPE_CHECKING:
    from exoid.measurement.recording import Recording
    from exoid.optimisation.preparation.filtering import PreparedRecording

def entrants(whitened: bool = False, problem: str = "identification") -> Mapping[str, Search]:
    """Return who competes: NFO as printed and whitened, and every other file of `optimisers/` as it comes.

    With `whitened` each of the others competes in whitened coordinates too. Of motions (`problem` "excitation") each
    competes with rescaled motions and with the infinite penalty.
    """
    if problem == "excitation":
        return motion_entrants(optimisers(), whitened)
    found = dict(SEARCHES)
    others = {name: kind for name, kind in optimisers().items() if name != "nfo"}
    found |= {name: Search(kind()) for name, kind in others.items()}
    if whitened:
        found |= {f"{name}_whitened": Search(kind(), whitened=True) for name, kind in others.items()}
    return found


def rivals(
    subject: Model | Fit | Excitation | ContestSubject | None = None,
    recordings: Sequence[PreparedRecording] | Sequence[Recording] = (),
    settings: ContestSettings | None = None,
    *,
    progress: Progress | None = None,
    **changes: Unpack[ContestOptions],
) -> Rivals:
    """Let all optimisers run from `seeds` first populations and return who came how near, how fast.

    Refuses fewer than two seeds, and a fit without a proven optimum.
    """
    began = time.perf_counter()
    asked = ContestSettings.chosen(settings, changes)
    if isinstance(subject, Excitation):
        asked = replace(asked, problem="excitation", criterion=subject.criterion)
    if asked.seeds < 2:
        what = "one seed cannot show run-to-run variation"
        raise ContestError(what, where=f"--seeds {asked.seeds}", remedy=f"give two at least, better {SEEDS}")
    contest = _contest(subject, recordings, asked)
    searches = _searches(asked)
    seeds = range(asked.seed, asked.seed + asked.seeds)
    tasks = [(name, k) for k in seeds for name in searches]
    store = RunStore(asked.folder, contest)
    done = {task: kept for task in tasks if (kept := store.read(task[0], searches[task[0]], task[1])) is not None}
    if store.damaged:
        warnings.warn(
            f"{store.damaged} of the runs kept in {asked.folder} are damaged or were altered; they are run again",
            UserWarning,
            stacklevel=2,
        )
    missing = [task for task in tasks if task not in done]
    resumed = len(done)
    report = progress or silent
    for outcome in _run(contest, missing, asked):
        store.write(outcome, searches[outcome.name])
        done[outcome.name, outcome.seed] = outcome
        report(len(done) / len(tasks), f"{outcome.name}, seed {outcome.seed}: gap {outcome.gap:.0e}")
    outcomes = {name: tuple(done[name, k] for k in seeds) for name in searches}
    return Rivals(contest, searches, outcomes, time.perf_counter() - began, resumed)


def _searches(asked: ContestSettings) -> dict[str, Search]:
    """Return who competes, by name."""
    return dict(asked.competing or entrants(asked.whitened, asked.problem))


def _contest(subject: Any, recordings: Any, asked: ContestSettings) -> ContestSubject:
    if isinstance(subject, ContestSubject):
        return subject
    if asked.problem == "excitation":
        if recordings or not (subject is None or isinstance(subject, (Model, Excitation))):
            what = "motions compete on a model alone"
            raise ContestError(what, remedy="give no recordings and no fit, or leave out `problem`")
        found = subject if isinstance(subject, Excitation) else None
        model = subject.model if isinstance(subject, Excitation) else subject
        return motion_contest(model, asked.criterion, asked.seed, asked.individuals, asked.generations, found)
    size = asked.individuals or INDIVIDUALS, asked.generations
    if isinstance(subject, Fit):
        return contest_of(subject, *size)
    if subject is None and not recordings:
        return paper_contest(asked.seed, *size)
    if subject is None:
        subject = Model.standard()
    return contest_of(identify(subject, recordings, optimisers=(), seed=asked.seed), *size)


def _run(contest: ContestSubject, tasks: Sequence[tuple[str, int]], asked: ContestSettings) -> Iterator[Outcome]:
    """Yield outcomes as they come."""
    if not tasks:
        return
    searches = _searches(asked)

    def given(task: tuple[str, int]) -> tuple[Any, ...]:
        return contest, task[0], searches[task[0]], task[1]

    if asked.engine is None:
        yield from (outcome for _, outcome in in_processes(race, tasks, given, asked.jobs))
    else:
        yield from (future.result() for _, future in completed(asked.engine, race, tasks, given))


__all__ = ["Contest", "Outcome", "Rivals", "entrants", "rivals"]
