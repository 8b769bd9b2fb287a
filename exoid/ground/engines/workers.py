"""One question answered together with copies of this process (fork), which go through the same steps as it does.

A copy begins where work is first shared out, knows all that this process knows, and goes on as it does: between two
pieces of shared work every process computes for itself what all need. Pieces are taken from one pipe, answers are told
to all, and arrays go through memory that all see (`shared`). Which process does a piece changes nothing of what comes
out. What a copy does not answer, because it failed, was ended or has come to other numbers, this process does itself.
`EXOID_PROCESSES` says how many processes there may be: by default as many as cores, four at most; 1 in workers that
share a machine.

Why not a pool: processes forked anew for each of the ten rounds of practice leg e give nothing back. Seconds of
processor time on the longest way to its answer, with two processes: 2.4 alone, 2.0 as here, 2.4 by the pool (1.5 here
and half of 1.8 in two others). A pool that stays would have to be sent every model and all it was weighed on.
"""

from __future__ import annotations

import contextlib
import gc
import json
import math
import mmap
import os
import select
import signal
import socket
import sys
import threading
import time
import warnings
import zlib
from collections.abc import Callable, Iterator, Sequence
from pathlib import Path
from typing import Any, ParamSpec

from exoid.ground.errors import ExoidError

PROCESSES = "EXOID_PROCESSES"
QUOTA = Path("/sys/fs/cgroup/cpu.max")
"""Where Linux says what share of the processor a container is granted: microseconds in each so many."""
MOST_PROCESSES = 4
"""Processes by default, however many cores there are."""
PATIENCE = 30.0
"""Seconds, and as many times the time so far, after which copies that do not answer are given up."""
_WIDTH, _MOST_PIECES = 2, 2000
"""Bytes of a piece's number, and how many numbers fit into the smallest pipe."""
_END = b"\xff" * _WIDTH
"""Stands in the pipe behind the pieces, once for each process."""

P = ParamSpec("P")


def allowed_processes() -> int:
    """Return how many processes work on a question; 1 where copies of this process are not safe: in any but its main
    thread, and on other systems than Linux. ExoidError where `EXOID_PROCESSES` is no number.
    """
    given = os.environ.get(PROCESSES, "")
    if given and not (given.isascii() and given.isdigit() and int(given) > 0):
        raise ExoidError(f"{PROCESSES} is {given!r}", remedy="give a number of processes, 1 or more")
    if sys.platform != "linux" or not _here():
        return 1
    return int(given) if given else min(MOST_PROCESSES, cores())


def cores() -> int:
    """Return how many cores this process may use: those it is bound to, and no more than its container is granted."""
    count = len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1
    with contextlib.suppress(OSError, ValueError):  # no container, or one that is granted "max"
        quota, period = QUOTA.read_text().split()
        count = min(count, math.ceil(int(quota) / int(period)))
    return max(count, 1)


@contextlib.contextmanager
def with_copies() -> Iterator[None]:
    """Keep the copies that begin inside until its end; there, or with what is raised here, they end.

    Everything inside must come to the same in every process, and say what it has to say through `once`.
    """
    if _TEAM or allowed_processes() < 2:
        yield
        return
    team = _Team(allowed_processes())
    _TEAM.append(team)
    try:
        yield
    finally:
        if team.leader is not None:
            os._exit(0)
        _TEAM.clear()
        team.dissolve()


def once(callback: Callable[P, object]) -> Callable[P, None]:
    """Return a function that calls `callback` in this process, and does nothing in its copies."""

    def call(*args: P.args, **kwargs: P.kwargs) -> None:
        if not _TEAM or _TEAM[0].leader is None:
            callback(*args, **kwargs)

    return call


def shared(count: int) -> Any:
    """Return a buffer of `count` doubles, all zero, that all processes see; memory comes as it fills.

    What a piece of work asks for is its own.
    """
    size = 8 * max(count, 1)
    team = _TEAM[0] if _TEAM and _here() else None
    return mmap.mmap(-1, size) if team is None or team.working else team.memory(size)


def share_out(
    work: Callable[[int], Any], order: Sequence[int], heard: Callable[[int, Any], object], state: bytes = b""
) -> None:
    """Do `work(k)` for every k of `order`, begun in this order, in all processes; `heard(k, answer)` is called in each,
    here as soon as one is done. Answers are what JSON can write.

    `state` is what must be the same everywhere for the answers to mean the same. Whatever `work` or `heard` raises here
    ends all copies.
    """
    if not 1 < len(order) <= _MOST_PIECES or not _apart():
        for k in order:
            heard(k, work(k))
        return
    with with_copies():
        team = _TEAM[0]
        postponed, team.postponed = team.postponed, []
        pieces = [(work, k, heard) for k in order]
        pieces[:0] = [(other, k, told) for other, places, told in postponed for k in places]
        team.begin(zlib.crc32(repr([k for _, k, _ in pieces]).encode() + state))

        def piece(place: int) -> Any:
            return pieces[place][0](pieces[place][1])

        def take(place: int, answer: Any) -> None:
            pieces[place][2](pieces[place][1], answer)

        (team.follow if team.leader is not None else team.lead)(team.piece(piece), len(pieces), take)


def postpone(work: Callable[[int], Any], order: Sequence[int], heard: Callable[[int, Any], object]) -> None:
    """Let what would be shared out be done with what is shared out next, before it: by itself it would leave processes
    idle. Where nobody shares, it is done now.
    """
    if _TEAM and _apart():
        _TEAM[0].postponed.append((work, order, heard))
    else:
        share_out(work, order, heard)


def first_passing(test: Callable[[int], bool], count: int) -> int | None:
    """Return the first of the numbers below `count` that passes the `test`, None where none does."""
    if not _apart():
        return next((k for k in range(count) if test(k)), None)
    passed: list[int] = []
    share_out(lambda k: bool(test(k)), range(count), lambda k, good: passed.append(k) if good else None)
    return min(passed, default=None)


def _here() -> bool:
    return threading.current_thread() is threading.main_thread()


def _apart() -> bool:
    """Whether work can be shared out here and now."""
    return allowed_processes() > 1 and not (_TEAM and _TEAM[0].working)


class _Copy:
    """A copy of this process, and the line to it."""

    def __init__(self, process: int, line: socket.socket) -> None:
        self.process, self.line = process, _Line(line)

    def end(self) -> None:
        """End it; nothing of it stays."""
        self.line.socket.close()
        os.kill(self.process, signal.SIGKILL)
        os.waitpid(self.process, 0)


class _Line:
    """What is told through a socket, one thing after the other."""

    def __init__(self, line: socket.socket) -> None:
        self.socket = line

    def tell(self, *what: Any) -> None:
        """Send what JSON can write."""
        content = json.dumps(what).encode()
        self.socket.sendall(len(content).to_bytes(8, "big") + content)

    def hear(self) -> Any:
        """Return what was sent next; ConnectionError where there is nobody any more."""
        return json.loads(self._exactly(int.from_bytes(self._exactly(8), "big")))

    def _exactly(self, count: int) -> bytes:
        parts = bytearray()
        while len(parts) < count:
            read = self.socket.recv(count - len(parts))
            if not read:
                raise ConnectionError
            parts += read
        return bytes(parts)


class _Team:
    """This process and its copies: seen from here, or from a copy (`leader` is then its line to this process)."""

    def __init__(self, many: int) -> None:
        self.many = many
        self.copies: list[_Copy] = []
        self.leader: _Line | None = None
        self.working = False
        self.postponed: list[tuple[Callable[[int], Any], Sequence[int], Callable[[int, Any], object]]] = []
        self.stamp = [0, 0]
        self._begun = False
        self._todo = self._give = -1

    def begin(self, state: int) -> None:
        """Begin the next work to be shared out, the first time with copies; they return from here too."""
        self.stamp = [self.stamp[0] + 1, state]
        if self._begun:
            return
        self._begun = True
        self._todo, self._give = os.pipe()
        with contextlib.suppress(OSError):  # no memory, or no more processes allowed: fewer work
            while self.leader is None and len(self.copies) < self.many - 1:
                self._copy()

    def piece(self, work: Callable[[int], Any]) -> Callable[[int], Any]:
        """Return `work` within which nothing is shared out further."""

        def done(k: int) -> Any:
            self.working = True
            try:
                return work(k)
            finally:
                self.working = False

        return done

    def lead(self, work: Callable[[int], Any], count: int, heard: Callable[[int, Any], object]) -> None:
        """Share out `count` pieces, work, and tell everybody all answers."""
        answers: dict[int, Any] = {}

        def take(k: int, answer: Any) -> None:
            answers[k] = answer
            heard(k, answer)

        try:
            if self.copies:
                self._gather(work, count, take)
            for one in self.copies:
                one.line.tell(self.stamp, list(answers.items()))
        except ConnectionError:
            self.dissolve()
        for k in [k for k in range(count) if k not in answers]:
            take(k, work(k))

    def _gather(self, work: Callable[[int], Any], count: int, take: Callable[[int, Any], object]) -> None:
        """Work with all copies until nothing is left to do; ConnectionError where one is lost."""
        began = time.monotonic()
        waiting = {one.line.socket: one.line for one in self.copies}

        def listen(seconds: float) -> None:
            for ready in select.select(list(waiting), [], [], max(0.0, seconds))[0] if waiting else ():
                stamp, k, answer = waiting[ready].hear()
                if stamp != self.stamp:
                    raise ConnectionError  # it has come to something else
                if k is None:
                    del waiting[ready]
                else:
                    take(k, answer)

        places = b"".join(k.to_bytes(_WIDTH, "big") for k in range(count))
        os.write(self._give, places + _END * (1 + len(self.copies)))
        while (place := os.read(self._todo, _WIDTH)) != _END:
            k = int.from_bytes(place, "big")
            take(k, work(k))
            listen(0.0)
        limit = time.monotonic() + PATIENCE + (time.monotonic() - began)
        while waiting and time.monotonic() < limit:
            listen(limit - time.monotonic())
        if waiting:
            raise ConnectionError

    def follow(self, work: Callable[[int], Any], count: int, heard: Callable[[int, Any], object]) -> None:
        """Work in a copy, and take in all answers; whatever goes wrong ends it, and its piece is done elsewhere."""
        try:
            assert self.leader is not None
            while (place := os.read(self._todo, _WIDTH)) != _END:
                if not place:  # the pipe's other end is gone
                    os._exit(0)
                k = int.from_bytes(place, "big")
                self.leader.tell(self.stamp, k, work(k))
            self.leader.tell(self.stamp, None, None)
            stamp, told = self.leader.hear()
            if stamp != self.stamp:
                os._exit(0)
        except BaseException:  # noqa: BLE001 - no copy may go on by itself
            os._exit(0)
        for k, answer in told:
            heard(k, answer)

    def memory(self, size: int) -> mmap.mmap:
        """Return zeros that all copies see; they ask for the same."""
        try:
            if self.leader is not None:
                _, handles, _, _ = socket.recv_fds(self.leader.socket, 1, 1)
                file = handles[0]
            else:
                file = os.memfd_create("exoid")
                os.ftruncate(file, size)
                for one in self.copies:
                    socket.send_fds(one.line.socket, [b"m"], [file])
            found = mmap.mmap(file, size)
            os.close(file)
            return found
        except (OSError, IndexError):
            if self.leader is not None:
                os._exit(0)
            self.dissolve()
            return mmap.mmap(-1, size)

    def dissolve(self) -> None:
        """End all copies; this process goes on alone."""
        for one in self.copies:
            one.end()
        for handle in (self._todo, self._give):
            if handle >= 0:
                os.close(handle)
        self.copies, self._todo, self._give = [], -1, -1

    def _copy(self) -> None:
        ours, theirs = socket.socketpair()
        try:
            with warnings.catch_warnings():
                # Other threads (a progress bar's) hold nothing that the copy takes.
                warnings.simplefilter("ignore", DeprecationWarning)
                process = os.fork()
        except OSError:
            ours.close()
            theirs.close()
            raise
        if process:
            theirs.close()
            self.copies.append(_Copy(process, ours))
            return
        signal.signal(signal.SIGINT, signal.SIG_IGN)  # whoever waits for the answers is interrupted, and ends this
        ours.close()
        for one in self.copies:
            one.line.socket.close()
        os.close(self._give)
        self.copies, self.leader = [], _Line(theirs)
        gc.freeze()  # looked through, all memory would be touched, and so copied
        # What is said, is said by the process that was asked.
        sys.stdout = sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115 - as long as it lives
        for stream in (1, 2):
            os.dup2(sys.stdout.fileno(), stream)


_TEAM: list[_Team] = []
"""The team at work, if there is one."""
