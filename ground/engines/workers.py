"""One question's work shared with copies of this process (fork), which know all that it knows.

A copy takes the next piece of work from a pipe, as this process does, and answers in a line of JSON; arrays go through
memory that both see (`shared`). Which process does a piece changes nothing of what comes out. What a copy does not
answer, because it failed or was ended, this process does itself. `EXOID_PROCESSES` says how many processes there may
be: by default as many as cores, four at most; 1 in workers that share a machine.
"""

from __future__ import annotations

import contextlib
import gc
import json
import mmap
import os
import select
import signal
import sys
import threading
import time
import warnings
from collections.abc import Callable, Sequence
from typing import Any, NoReturn

from ground.errors import ExoidError

PROCESSES = "EXOID_PROCESSES"
MOST = 4
"""Processes by default, however many cores there are."""
PATIENCE = 30.0
"""Seconds, and as many times the time so far, after which a copy that does not answer is given up."""
_WIDTH, _MOST_PIECES = 2, 2000
"""Bytes of a piece's number, and how many numbers fit into the smallest pipe."""


def allowed_processes() -> int:
    """Return how many processes work on a question; 1 where copies of this process are not safe: in any but its main
    thread, and on other systems than Linux. ExoidError where `EXOID_PROCESSES` is no number.
    """
    given = os.environ.get(PROCESSES, "")
    if given and not (given.isascii() and given.isdigit() and int(given) > 0):
        raise ExoidError(f"{PROCESSES} is {given!r}", remedy="give a number of processes, 1 or more")
    if sys.platform != "linux" or threading.current_thread() is not threading.main_thread():
        return 1
    return int(given) if given else min(MOST, len(os.sched_getaffinity(0)))


def shared(count: int) -> Any:
    """Return a buffer of `count` doubles, all zero, that copies of this process see too; memory comes as it fills."""
    return mmap.mmap(-1, 8 * max(count, 1))


def share_out(work: Callable[[int], Any], order: Sequence[int], heard: Callable[[int, Any], None], many: int) -> None:
    """Do `work(k)` for every k of `order`, begun in this order, in `many` processes; `heard(k, answer)` is called here
    as soon as one is done, answers being what JSON can write.

    Whatever `work` or `heard` raises here ends all copies.
    """
    if many < 2 or not 1 < len(order) <= _MOST_PIECES:
        for k in order:
            heard(k, work(k))
        return
    todo, give = os.pipe()
    os.write(give, b"".join(place.to_bytes(_WIDTH, "big") for place in range(len(order))))
    os.close(give)
    copies: list[_Copy] = []
    began = time.monotonic()
    try:
        with contextlib.suppress(OSError):  # no memory, or no more processes allowed: fewer do
            for _ in range(min(many, len(order)) - 1):
                copies.append(_copy(work, order, todo))
        missing = set(order)

        def listen(seconds: float) -> None:
            for one in _ready(copies, seconds):
                for k, answer in one.answers():
                    missing.discard(k)
                    heard(k, answer)

        while place := os.read(todo, _WIDTH):
            k = order[int.from_bytes(place, "big")]
            answer = work(k)
            missing.discard(k)
            heard(k, answer)
            listen(0.0)
        limit = time.monotonic() + PATIENCE + (time.monotonic() - began)
        while any(one.open for one in copies) and time.monotonic() < limit:
            listen(limit - time.monotonic())
        for k in [k for k in order if k in missing]:
            heard(k, work(k))
    finally:
        os.close(todo)
        for one in copies:
            one.end()


def first_passing(test: Callable[[int], bool], count: int, many: int) -> int | None:
    """Return the first of the numbers below `count` that passes the `test`, None where none does."""
    if many < 2:
        return next((k for k in range(count) if test(k)), None)
    passed: list[int] = []
    share_out(lambda k: bool(test(k)), range(count), lambda k, good: passed.append(k) if good else None, many)
    return min(passed, default=None)


class _Copy:
    """A copy of this process, and the pipe of its answers."""

    def __init__(self, process: int, pipe: int) -> None:
        self.process, self.pipe, self.open = process, pipe, True
        self._rest = b""

    def answers(self) -> list[tuple[int, Any]]:
        """Return what it has answered since."""
        read = os.read(self.pipe, 1 << 20)
        self.open = bool(read)
        *lines, self._rest = (self._rest + read).split(b"\n")
        return [tuple(json.loads(line)) for line in lines]

    def end(self) -> None:
        """End it; nothing of it stays."""
        os.close(self.pipe)
        os.kill(self.process, signal.SIGKILL)
        os.waitpid(self.process, 0)


def _ready(copies: Sequence[_Copy], seconds: float) -> list[_Copy]:
    waiting = {one.pipe: one for one in copies if one.open}
    if not waiting:
        return []
    return [waiting[pipe] for pipe in select.select(list(waiting), [], [], max(0.0, seconds))[0]]


def _copy(work: Callable[[int], Any], order: Sequence[int], todo: int) -> _Copy:
    pipe, answer = os.pipe()
    try:
        with warnings.catch_warnings():
            # Other threads (a progress bar's) hold nothing that the copy takes: it computes, answers and ends.
            warnings.simplefilter("ignore", DeprecationWarning)
            process = os.fork()
    except OSError:
        os.close(pipe)
        os.close(answer)
        raise
    if process == 0:
        os.close(pipe)
        _serve(work, order, todo, answer)
    os.close(answer)
    return _Copy(process, pipe)


def _serve(work: Callable[[int], Any], order: Sequence[int], todo: int, answer: int) -> NoReturn:
    """Work and answer until nothing is left to do; an exception ends the copy, and its piece is done elsewhere."""
    try:
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever waits for the answers is interrupted, and ends this
        gc.freeze()  # looked through, all memory would be touched, and so copied
        os.environ[PROCESSES] = "1"
        while place := os.read(todo, _WIDTH):
            k = order[int.from_bytes(place, "big")]
            line = json.dumps([k, work(k)]).encode() + b"\n"
            while line:
                line = line[os.write(answer, line) :]
    finally:
        os._exit(0)
