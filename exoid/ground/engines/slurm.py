"""Slurm through submitit: every job is a task of a partition; the partition "local" runs them on this machine."""

from __future__ import annotations

import contextlib
import shlex
import tempfile
import threading
from collections.abc import Callable
from concurrent.futures import Executor, Future
from pathlib import Path
from typing import Any

from exoid.ground.cores import cores
from exoid.ground.engines.engine import Engine, EngineError
from exoid.ground.errors import refused
from exoid.ground.extras import needing
from exoid.ground.import_path import environment_of_workers, workers_import_alike
from exoid.ground.inside import refuse_links

POLL = 0.5
"""Seconds between two looks at whether tasks have ended."""
MINUTES = 24 * 60
"""Time limit of a Slurm task unless --timeout makes it shorter."""


class _Submitted(Executor):
    """submitit's executor with the interface of `concurrent.futures`: one thread asks which tasks have ended."""

    def __init__(self, inner: Any) -> None:
        self._inner = inner
        self._waiting: dict[Future[Any], Any] = {}
        self._lock = threading.Lock()
        self._closed = threading.Event()
        threading.Thread(target=self._watch, daemon=True).start()

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Hand over one call; its future ends when its task has."""
        future: Future[Any] = Future()
        try:
            with self._lock:
                self._waiting[future] = self._inner.submit(fn, *args, **kwargs)
        except Exception as error:
            raise EngineError(f"Slurm takes no more tasks ({' '.join(str(error).split())[:300]})") from error
        return future

    def shutdown(self, wait: bool = True, *, cancel_futures: bool = False) -> None:
        """Stop watching; with `cancel_futures`, end the tasks that have not."""
        self._closed.set()
        with self._lock:
            if cancel_futures:
                for task in self._waiting.values():
                    task.cancel(check=False)

    def _watch(self) -> None:
        while not self._closed.wait(POLL):
            with self._lock:
                ended = {future: task for future, task in self._waiting.items() if _ended(task)}
                for future in ended:
                    del self._waiting[future]
            for future, task in ended.items():
                try:
                    future.set_result(task.result())
                except Exception as error:  # noqa: BLE001 - whoever asks the future gets it
                    future.set_exception(error)


def _ended(task: Any) -> bool:
    """Whether a task has ended; one of which Slurm cannot say it has: its result says what is the matter."""
    try:
        return bool(task.done())
    except Exception:  # noqa: BLE001 - one task must not end the thread that looks after all
        return True


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
    started = contextlib.ExitStack()
    if here:
        started.enter_context(workers_import_alike())
    else:  # in the task itself: a cluster may pass no environment on
        setup = [f"export {name}={shlex.quote(value)}" for name, value in environment_of_workers().items()]
        inner.update_parameters(slurm_partition=partition, slurm_setup=setup)
    executor = _Submitted(inner)

    def close(wait: bool) -> None:
        executor.shutdown(cancel_futures=not wait)
        started.close()

    return Engine(f"Slurm, partition {partition}, {count} tasks at a time", executor, lambda: count, list, close)
