"""An executor of `concurrent.futures`, with what a campaign wants to know of it; jobs that come back as they end."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import FIRST_COMPLETED, Executor, Future, wait
from dataclasses import dataclass
from typing import Any, TypeVar

from exoid.ground.errors import ExoidError

Job = TypeVar("Job")
AHEAD = 2
"""Jobs handed to an engine for each of its workers: one that runs, one that waits, so that no worker is idle."""
UNKNOWN = 64
"""Workers of an executor that does not say how many it has."""


class EngineError(ExoidError):
    """An engine that is not installed, cannot be reached, or lost its workers."""


@dataclass(frozen=True)
class Engine:
    """An open engine; `with` closes it, and what still runs is ended where an exception ends the block.

    `workers()` is how many jobs run at a time now, `lost()` what happened to workers since it was last asked, in
    words, and `ahead` how many jobs it is handed for each worker. `close(wait)` gives back what the engine holds;
    without `wait` it ends what still runs. `ships` says that workers may not see this machine's files, so that
    recordings travel as bytes.
    """

    name: str
    executor: Executor
    workers: Callable[[], int]
    lost: Callable[[], list[str]]
    close: Callable[[bool], None]
    ahead: int = AHEAD
    ships: bool = False

    def __enter__(self) -> Engine:
        return self

    def __exit__(self, kind: type[BaseException] | None, *_: object) -> None:
        self.close(kind is None)


def engine_of(given: Engine | Executor) -> Engine:
    """Return any executor as an engine, which whoever opened it closes; its workers see the files of this machine.

    Raises EngineError for anything else.
    """
    if isinstance(given, Engine):
        return given
    name = type(given).__name__
    if not isinstance(given, Executor):
        remedy = "give an executor, such as concurrent.futures.ProcessPoolExecutor(), or dask() and slurm() of exoid"
        raise EngineError(f"{name} is no concurrent.futures.Executor", where="engine", remedy=remedy)
    count = getattr(given, "_max_workers", UNKNOWN)
    return Engine(name, given, lambda: count, list, lambda wait: None)


def completed(
    engine: Engine | Executor,
    function: Callable[..., Any],
    jobs: Iterable[Job],
    arguments: Callable[[Job], tuple[Any, ...]],
) -> Iterator[tuple[Job, Future[Any]]]:
    """Yield every job with its finished future, in the order in which they end; `engine` is any that `engine_of` takes.

    Only a few jobs per worker are handed over at a time: memory stays flat, and an interrupted campaign stops soon.
    """
    engine, waiting = engine_of(engine), iter(jobs)
    running: dict[Future[Any], Job] = {}
    while True:
        for job in waiting:
            try:
                running[engine.executor.submit(function, *arguments(job))] = job
            except RuntimeError as error:  # an executor that was closed, or lost what it talks to
                raise EngineError(f"{engine.name} takes no more jobs ({error})") from error
            if len(running) >= engine.ahead * max(1, engine.workers()):
                break
        if not running:
            return
        done, _ = wait(running, return_when=FIRST_COMPLETED)
        for future in done:
            yield running.pop(future), future
