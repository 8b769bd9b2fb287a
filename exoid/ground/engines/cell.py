"""A job in a process of its own, which may crash, hang or run out of memory without taking its worker along.

A worker (a thread here, a Dask worker, a Slurm task) keeps one such process and sends it one job after the other as
lines of JSON, so that libraries are imported and models compiled once. The process ends when its worker does: it reads
the end of its standard input.
"""

from __future__ import annotations

import atexit
import contextlib
import importlib
import json
import os
import queue
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from exoid.ground.import_path import environment_of_workers
from exoid.ground.plain import AsJson

MOST_JOBS = 500
"""Jobs after which a process is replaced, so that whatever leaks stays small."""
ATTEMPTS = 2
"""Times a job is tried whose process ended in the middle of it."""
ONE_THREAD = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS")
BESIDE_OTHERS = dict.fromkeys(ONE_THREAD, "1")
"""The environment of a worker that shares its machine with others."""


@dataclass(frozen=True)
class Answer(AsJson):
    """What became of a job.

    `status` is "done" (with the `value` that the function returned), "failed" (an exception: `reason` is its
    traceback), "crashed" (its process ended, `attempts` times) or "late" (it exceeded its time). `seconds` is the time
    of the last attempt, `worker` where it ran.
    """

    status: str
    value: Any = None
    reason: str = ""
    attempts: int = 1
    seconds: float = 0.0
    worker: str = ""


class Cell:
    """A process that runs one job at a time; started at the first job, and again after it was lost."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._lines: queue.Queue[bytes] = queue.Queue()
        self._jobs = 0

    def run(self, function: str, argument: Mapping[str, Any], seconds: float | None = None) -> Answer:
        """Run `function` ("package.module:name") with `argument` (plain data) for at most `seconds`."""
        if self._jobs >= MOST_JOBS:
            self.close()
        for attempt in range(1, ATTEMPTS + 1):
            began = time.perf_counter()
            found = self._attempt(function, argument, seconds)
            took = time.perf_counter() - began
            worker = f"{socket.gethostname()}:{os.getpid()}"
            if found["status"] != "crashed" or attempt == ATTEMPTS:
                return Answer(**found, attempts=attempt, seconds=took, worker=worker)
        raise AssertionError("unreachable")

    def close(self) -> None:
        """End the process."""
        process, self._process, self._jobs = self._process, None, 0
        if process is None:
            return
        process.kill()
        process.wait()
        for stream in (process.stdin, process.stdout):
            if stream is not None:
                with contextlib.suppress(OSError):
                    stream.close()

    def _attempt(self, function: str, argument: Mapping[str, Any], seconds: float | None) -> dict[str, Any]:
        process = self._started()
        assert process.stdin is not None
        self._jobs += 1
        try:
            process.stdin.write(json.dumps([function, argument]).encode() + b"\n")
            process.stdin.flush()
            line = self._lines.get(timeout=seconds)
        except queue.Empty:
            self.close()
            return {"status": "late", "reason": f"it took more than {seconds:g} s and was stopped"}
        except BrokenPipeError:
            line = b""
        except BaseException:  # interrupted: nobody waits for the answer any more
            self.close()
            raise
        if not line:
            status = process.wait()
            self.close()
            how = f"by signal {-status}" if status < 0 else f"with status {status}"
            return {"status": "crashed", "reason": f"its process was ended {how}"}
        found: dict[str, Any] = json.loads(line)
        return found

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process is None or self._process.poll() is not None:
            self.close()
            environment = {**BESIDE_OTHERS, **os.environ, **environment_of_workers()}
            self._process = subprocess.Popen(
                [sys.executable, "-m", __name__], stdin=subprocess.PIPE, stdout=subprocess.PIPE, env=environment,
                start_new_session=True,
            )  # fmt: skip
            self._lines = queue.Queue()
            threading.Thread(target=_forward, args=(self._process, self._lines), daemon=True).start()
        return self._process


def in_cell(function: str, argument: Mapping[str, Any], seconds: float | None = None) -> dict[str, Any]:
    """Run a job in the cell of this thread, as `Cell.run` does, and return its Answer as plain data."""
    cell = getattr(_own, "cell", None)
    if cell is None:
        cell = _own.cell = Cell()
        with _lock:
            _cells.append(cell)
    return cell.run(function, argument, seconds).to_json()


def close_cells() -> None:
    """End the processes of all threads of this process."""
    with _lock:
        for cell in _cells:
            cell.close()


_own = threading.local()
_cells: list[Cell] = []
_lock = threading.Lock()
atexit.register(close_cells)


def _forward(process: subprocess.Popen[bytes], lines: queue.Queue[bytes]) -> None:
    """Put every line that `process` writes into `lines`, and an empty one when it ends."""
    assert process.stdout is not None
    with contextlib.suppress(OSError, ValueError):
        for line in process.stdout:
            lines.put(line)
    lines.put(b"")


def main() -> None:
    """Run the jobs that come as lines on standard input until it ends."""
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a job prints is not an answer
    jobs: queue.Queue[bytes] = queue.Queue()
    threading.Thread(target=_listen, args=(jobs,), daemon=True).start()
    while True:
        function, argument = json.loads(jobs.get())
        answers.write(json.dumps(_called(function, argument)).encode() + b"\n")
        answers.flush()


def _listen(jobs: queue.Queue[bytes]) -> None:
    for line in sys.stdin.buffer:
        jobs.put(line)
    os._exit(0)  # the worker is gone: nobody wants the answer of the job that may be running


def _called(function: str, argument: Any) -> dict[str, Any]:
    import traceback

    module, _, name = function.partition(":")
    try:
        value = getattr(importlib.import_module(module), name)(argument)
        json.dumps(value)
    except Exception:  # noqa: BLE001 - whatever it is, it is the answer
        return {"status": "failed", "reason": traceback.format_exc(limit=-4)}
    return {"status": "done", "value": value}


if __name__ == "__main__":
    main()
