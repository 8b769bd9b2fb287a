"""Slurm through submitit: every job is a task of a partition; the partition "local" runs them on this machine."""

from __future__ import annotations

import shlex
import tempfile
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import ExitStack
from pathlib import Path
from typing import Any

from exoid.ground.cores import cores
from exoid.ground.engines.engine import Engine, EngineError
from exoid.ground.errors import refused
from exoid.ground.extras import needing
from exoid.ground.import_path import environment_of_workers, workers_import_alike
from exoid.ground.inside import refuse_links

MINUTES = 24 * 60
"""Time limit of a Slurm task unless --timeout makes it shorter."""


class _Submitted(ThreadPoolExecutor):
    """submitit's executor with the interface of `concurrent.futures`: a thread waits for each of `count` tasks."""

    def __init__(self, inner: Any, count: int) -> None:
        super().__init__(count)
        self._inner = inner
        self._tasks: dict[Future[Any], Any] = {}

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Hand over one call; its future ends when its task has."""
        try:
            task = self._inner.submit(fn, *args, **kwargs)
        except Exception as error:
            raise EngineError(f"Slurm takes no more tasks ({' '.join(str(error).split())[:300]})") from error
        future = super().submit(task.result)
        self._tasks[future] = task
        future.add_done_callback(self._tasks.pop)
        return future

    def cancel(self) -> None:
        """End the tasks that have not."""
        for task in list(self._tasks.values()):
            task.cancel(check=False)


def slurm(partition: str, folder: Path, jobs: int = 0, seconds: float | None = None) -> Engine:
    """Return Slurm's `partition`, at most `jobs` tasks at a time (0: 64; on this machine, its cores).

    `folder` holds what submitit writes and must be seen by all nodes. Raises EngineError where submitit or Slurm is
    missing.
    """
    with needing("slurm", "jobs under Slurm", "submitit", error=EngineError):
        import submitit
    here = partition == "local"
    if not here and submitit.AutoExecutor.which() != "slurm":
        what = "there is no Slurm on this machine (sbatch was not found)"
        remedy = "run this on a login node; --slurm local runs the tasks on this machine"
        raise EngineError(what, where=f"--slurm {partition}", remedy=remedy)
    count = jobs or (cores() if here else 64)
    # A folder of its own: submitit takes for an answer whatever pickle lies where it expects one.
    with refused(EngineError, "cannot be written ({})", folder, "name a folder you may write to"):
        refuse_links(folder, folder.parent)
        folder.mkdir(parents=True, exist_ok=True)
        fresh = Path(tempfile.mkdtemp(prefix="tasks-", dir=folder))
    inner = submitit.AutoExecutor(folder=fresh / "%j", cluster="local" if here else None)
    minutes = MINUTES if seconds is None else max(1, int(2 * seconds / 60) + 5)
    inner.update_parameters(timeout_min=minutes, cpus_per_task=1, name="exoid")
    opened = ExitStack()
    if here:
        opened.enter_context(workers_import_alike())
    else:  # in the task itself: a cluster may pass no environment on
        setup = [f"export {name}={shlex.quote(value)}" for name, value in environment_of_workers().items()]
        inner.update_parameters(slurm_partition=partition, slurm_setup=setup)
    executor = _Submitted(inner, count)

    def close(wait: bool) -> None:
        if not wait:
            executor.cancel()
        executor.shutdown(wait=wait, cancel_futures=True)
        opened.close()

    name = f"Slurm, partition {partition}, {count} tasks at a time"
    return Engine(name, executor, lambda: count, list, close, ahead=1)
