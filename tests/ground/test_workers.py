"""Work shared with copies of this process: the same answers whoever gives them, and nothing stays behind."""

from __future__ import annotations

import os
import signal
import threading

import numpy as np
import pytest

from ground.engines import workers
from ground.errors import ExoidError

HERE = os.getpid()

pytestmark = pytest.mark.skipif(not hasattr(os, "fork"), reason="no fork here")


@pytest.fixture(autouse=True)
def nobody_left(monkeypatch):
    """Every copy is gone, and waited for, when a test is over."""
    begun, fork = [], os.fork

    def forked():
        process = fork()
        begun.append(process)
        return process

    monkeypatch.setattr(os, "fork", forked)
    yield
    for process in begun:
        with pytest.raises(ChildProcessError):
            os.waitpid(process, os.WNOHANG)


def answers(work, many, count=40):
    found = {}
    workers.share_out(work, range(count)[::-1], found.__setitem__, many)
    return found


@pytest.mark.parametrize("many", [1, 2, 4])
def test_every_piece_is_answered_once_and_to_the_last_digit(many):
    assert answers(lambda k: [k / 3.0, "ä\n", None], many) == {k: [k / 3.0, "ä\n", None] for k in range(40)}


def test_what_copies_write_into_shared_memory_is_seen_here():
    table = np.frombuffer(workers.shared(40), dtype=float)
    begun, own = {HERE: os.pipe(), None: os.pipe()}, []

    def work(k):
        here = HERE if os.getpid() == HERE else None
        os.write(begun[here][1], b".")
        own.append(k)
        if len(own) == 2:  # until the other one has begun too
            os.read(begun[None if here else HERE][0], 1)
        table[k] = k + 0.5
        return os.getpid()

    who = answers(work, 2)
    assert len(set(who.values())) == 2 and HERE in who.values()
    np.testing.assert_array_equal(table, np.arange(40) + 0.5)


@pytest.mark.parametrize("failing", [lambda: 1 / 0, lambda: os.kill(os.getpid(), signal.SIGKILL), lambda: os._exit(3)])
def test_what_a_copy_does_not_answer_is_done_here(failing):
    assert answers(lambda k: k if os.getpid() == HERE else failing(), 3) == {k: k for k in range(40)}


@pytest.mark.parametrize("many", [1, 3])
def test_the_first_that_passes_is_found_whoever_looks(many):
    assert workers.first_passing(lambda k: k in (7, 23, 5), 40, many) == 5
    assert workers.first_passing(lambda k: False, 40, many) is None and workers.first_passing(bool, 0, many) is None


def test_large_answers_do_not_stop_a_copy():
    assert answers(lambda k: "x" * 100_000, 2, 12) == dict.fromkeys(range(12), "x" * 100_000)


def test_an_error_or_an_interruption_here_ends_the_copies():
    def interrupted(k, answer):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        workers.share_out(lambda k: k, range(9), interrupted, 2)
    with pytest.raises(ZeroDivisionError):
        workers.share_out(lambda k: 1 // 0, range(9), lambda k, answer: None, 2)


def test_the_number_of_processes_is_said_once(monkeypatch):
    monkeypatch.setenv(workers.PROCESSES, "3")
    assert workers.allowed_processes() in (1, 3)  # 1 where copies are not safe
    for wrong in ("0", "-1", "two", "²"):
        monkeypatch.setenv(workers.PROCESSES, wrong)
        with pytest.raises(ExoidError, match=workers.PROCESSES):
            workers.allowed_processes()
    monkeypatch.setenv(workers.PROCESSES, "3")
    inside = []
    thread = threading.Thread(target=lambda: inside.append(workers.allowed_processes()))
    thread.start()
    thread.join()
    assert inside == [1]
