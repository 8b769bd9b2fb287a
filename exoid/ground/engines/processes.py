"""Processes of this machine for functions and their arguments as they are: joblib's loky, which starts them clean."""

from __future__ import annotations

import os
import threading
import time
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import Executor, Future
from multiprocessing import resource_tracker as of_python
from typing import Any

from exoid.ground.cores import cores
from exoid.ground.engines.engine import AHEAD, Engine, EngineError, Job, completed
from exoid.ground.extras import needing
from exoid.ground.import_path import SAFE, workers_import_alike

ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
BESIDE_OTHERS = dict.fromkeys(ONE_THREAD, "1")
"""The environment of a worker that shares its machine with others."""
QUIET = "ignore:resource_tracker:UserWarning"
"""What the helpers, which clear away after a Ctrl-C, need not tell: that there was something to clear away."""
IDLE = 10.0
"""Seconds after which a process without work ends, also when nobody is left to end it."""


class _Here(Executor):
    """One job at a time in this process: one worker is worth no start of a process."""

    def submit(self, fn: Callable[..., Any], /, *args: Any, **kwargs: Any) -> Future[Any]:
        """Run the call and return its finished future."""
        future: Future[Any] = Future()
        try:
            future.set_result(fn(*args, **kwargs))
        except Exception as error:  # noqa: BLE001 - whoever asks the future gets it
            future.set_exception(error)
        return future


def processes(jobs: int = 0) -> Engine:
    """Return an engine of `jobs` processes with one thread of linear algebra each; 0 means one per
    core, 1 this process itself.

    The matrices are small and the processes share the cores: more threads would be slower.
    """
    count = jobs or cores()
    if count == 1:
        return Engine("this process", _Here(), lambda: 1, list, lambda wait: None, ahead=1)
    return _loky(f"{count} processes on this machine", count, BESIDE_OTHERS)


def in_processes(
    function: Callable[..., Any], jobs: Iterable[Job], arguments: Callable[[Job], tuple[Any, ...]], count: int = 0
) -> Iterator[tuple[Job, Any]]:
    """Yield every job with its result, in the order in which they end, from `count` processes as for `processes`."""
    with processes(count) as engine:
        for job, future in completed(engine, function, jobs, arguments):
            yield job, future.result()


def alone() -> Engine:
    """Return an engine of one process for one job, which `close(False)` ends at any moment."""
    return _loky("a process of its own", 1, dict.fromkeys(ONE_THREAD, "1"), ahead=1)


def end_with(master: int) -> None:
    """End this process as soon as `master`, which started it, is gone: killed, it cannot say so."""
    if os.getppid() != master:
        return  # started by a helper of joblib: it ends when it has been idle

    def look() -> None:
        while os.getppid() == master:
            time.sleep(1.0)
        os._exit(1)

    threading.Thread(target=look, daemon=True).start()


def _loky(name: str, count: int, environment: dict[str, str], ahead: int = AHEAD) -> Engine:
    with needing("rivals", "jobs in processes of their own", "joblib", error=EngineError):
        from joblib.externals.loky import ProcessPoolExecutor
        from joblib.externals.loky.backend import resource_tracker as of_loky
    with workers_import_alike(PYTHONWARNINGS=QUIET):  # helpers, else started with a worker, which take no environment
        of_loky.ensure_running()
        of_python.ensure_running()
    executor = ProcessPoolExecutor(
        count, timeout=IDLE, env={**environment, SAFE: "1"}, initializer=end_with, initargs=(os.getpid(),)
    )

    def close(wait: bool) -> None:
        executor.shutdown(wait=wait, kill_workers=not wait)

    return Engine(name, executor, lambda: count, list, close, ahead=ahead)
