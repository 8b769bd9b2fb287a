"""A job in a process of its own, which may crash, hang or run out of memory without taking its worker along.

A worker (a thread here, a Dask worker, a Slurm task) keeps one such process and sends it one job after the other as
lines of JSON, so that libraries are imported and models compiled once.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import socket
import subprocess
import sys
import threading
import traceback
from collections.abc import Mapping
from typing import Any

from exoid.ground.engines.processes import BESIDE_OTHERS, end_with
from exoid.ground.import_path import environment_of_workers

MAX_JOBS = 500
"""Jobs after which a process is replaced, so that whatever leaks stays small."""
ATTEMPTS = 2
"""Times a job is tried whose process ended in the middle of it."""



class Cell:
    """A process that runs one job at a time; started at the first job, and again after it was lost."""

    def __init__(self) -> None:
        self._process: subprocess.Popen[bytes] | None = None
        self._jobs = 0
        self._closed = False

    def run(self, function: str, argument: Any, seconds: float | None = None) -> dict[str, Any]:
        """Run `function` ("package.module:name") with `argument` (plain data) for at most `seconds`.

        The answer is plain data: `status` is "done" (with the `value` that the function returned), "failed" (an
        exception: `reason` is its traceback), "crashed" (its process ended, `attempts` times) or "late" (it took more
        than `seconds`); `worker` is where it ran.
        """
        found: dict[str, Any] = {"worker": f"{socket.gethostname()}:{os.getpid()}"}
        for attempt in range(1, ATTEMPTS + 1):
            found |= self._attempt(function, argument, seconds) | {"attempts": attempt}
            if found["status"] != "crashed" or self._closed:
                break
        return found

    def close(self) -> None:
        """End the process for good, from any thread; the job that may be running has crashed."""
        self._closed = True
        self._end()

    def __del__(self) -> None:
        self._end()

    def _attempt(self, function: str, argument: Any, seconds: float | None) -> dict[str, Any]:
        if self._closed:
            return {"status": "crashed", "reason": "its worker was stopped"}
        process, late = self._started(), threading.Event()
        assert process.stdin is not None and process.stdout is not None

        def stop() -> None:
            late.set()
            process.kill()

        timer = threading.Timer(threading.TIMEOUT_MAX if seconds is None else seconds, stop)
        timer.daemon = True
        timer.start()
        try:
            process.stdin.write(json.dumps([function, argument]).encode() + b"\n")
            process.stdin.flush()
            line = process.stdout.readline()
        except (BrokenPipeError, ValueError):  # it ended, or was closed
            line = b""
        except BaseException:  # interrupted: nobody waits for the answer any more
            self._end()
            raise
        finally:
            timer.cancel()
        if line.endswith(b"\n"):
            found: dict[str, Any] = json.loads(line)
            return found
        status = process.wait()
        self._end()
        if late.is_set():
            return {"status": "late", "reason": f"it took more than {seconds:g} s and was stopped"}
        how = f"by signal {-status}" if status < 0 else f"with status {status}"
        return {"status": "crashed", "reason": f"its process was ended {how}"}

    def _started(self) -> subprocess.Popen[bytes]:
        if self._process is None or self._process.poll() is not None or self._jobs >= MAX_JOBS:
            self._end()
            environment = {**BESIDE_OTHERS, **os.environ, **environment_of_workers()}
            self._process = subprocess.Popen(
                [sys.executable, "-m", __name__, str(os.getpid())], stdin=subprocess.PIPE, stdout=subprocess.PIPE,
                env=environment, start_new_session=True,
            )  # fmt: skip
            self._jobs = 0
        self._jobs += 1
        return self._process

    def _end(self) -> None:
        process, self._process = self._process, None
        if process is not None:
            with contextlib.suppress(OSError), process:
                process.kill()


_own = threading.local()


def cell_of_thread() -> Cell:
    """Cell of the calling thread, whose process ends with it."""
    if not hasattr(_own, "cell"):
        _own.cell = Cell()
    cell: Cell = _own.cell
    return cell


def in_cell(function: str, argument: Mapping[str, Any], seconds: float | None = None) -> dict[str, Any]:
    """Run a job in the cell of this thread, as `Cell.run` does."""
    return cell_of_thread().run(function, argument, seconds)


def main() -> None:
    """Run the jobs that come as lines on standard input until it ends."""
    end_with(int(sys.argv[1]))
    answers = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)  # what a job prints is not an answer
    for line in sys.stdin.buffer:
        answers.write(json.dumps(_called(*json.loads(line))).encode() + b"\n")
        answers.flush()


def _called(function: str, argument: Any) -> dict[str, Any]:
    module, _, name = function.partition(":")
    try:
        value = getattr(importlib.import_module(module), name)(argument)
        json.dumps(value)
    except Exception:  # noqa: BLE001 - whatever it is, it is the answer
        return {"status": "failed", "reason": traceback.format_exc(limit=-4)}
    return {"status": "done", "value": value}


if __name__ == "__main__":
    main()
