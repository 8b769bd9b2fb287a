"""Work shared with copies of this process: the same answers whoever gives them, and nothing stays behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from pathlib import Path

import numpy as np
import pytest

from exoid.ground.engines import workers
from exoid.ground.errors import ExoidError
from tests.waiting import HUNG, until

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


@pytest.fixture
def processes(monkeypatch):
    """Return what sets how many processes there are."""
    return lambda many: monkeypatch.setenv(workers.PROCESSES, str(many))


def answers(work, count=40, state=b""):
    found = {}
    workers.share_out(work, range(count)[::-1], found.__setitem__, state)
    return found


@pytest.mark.parametrize("many", [1, 2, 4])
def test_every_piece_is_answered_once_and_to_the_last_digit(many, processes):
    processes(many)
    assert answers(lambda k: [k / 3.0, "ä\n", None]) == {k: [k / 3.0, "ä\n", None] for k in range(40)}


def test_what_copies_write_into_shared_memory_is_seen_here(processes):
    processes(2)
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

    who = answers(work)
    assert len(set(who.values())) == 2 and HERE in who.values()
    np.testing.assert_array_equal(table, np.arange(40) + 0.5)


@pytest.mark.parametrize("failing", [lambda: 1 / 0, lambda: os.kill(os.getpid(), signal.SIGKILL), lambda: os._exit(3)])
def test_what_a_copy_does_not_answer_is_done_here(failing, processes):
    processes(3)
    with workers.with_copies():
        assert answers(lambda k: k if os.getpid() == HERE else failing()) == {k: k for k in range(40)}
        assert answers(lambda k: -k) == {k: -k for k in range(40)}  # alone from now on
        assert len(workers.shared(3)) == 24


def both_work(count=40):
    """Return who did which piece where each process does at least one."""
    ours, theirs = np.frombuffer(workers.shared(1), dtype=float), np.frombuffer(workers.shared(1), dtype=float)

    def work(k):
        mine, other = (ours, theirs) if os.getpid() == HERE else (theirs, ours)
        mine[0] = 1.0
        while not other[0]:
            time.sleep(0.001)
        return os.getpid()

    return answers(work, count)


def test_copies_go_on_as_this_process_does(processes):
    """A copy begins at the first work; what follows it computes itself, and memory asked for later is seen by all."""
    processes(2)
    with workers.with_copies():
        first = set(both_work().values())
        total = sum(answers(lambda k: k).values())  # serial work on what was answered
        table = np.frombuffer(workers.shared(40), dtype=float)

        def work(k):
            table[k] = total + k
            return os.getpid(), workers.shared(2) is not None

        again = both_work()
        answers(work)
        np.testing.assert_array_equal(table, 780.0 + np.arange(40))
    assert len(first) == 2 and set(again.values()) == first


def test_a_copy_with_other_numbers_ends_and_nothing_of_it_is_taken(processes):
    processes(2)
    with workers.with_copies():
        both_work()
        other = os.getpid() != HERE
        assert answers(lambda k: k + other, state=bytes([other])) == {k: k for k in range(40)}
        assert set(answers(lambda k: os.getpid()).values()) == {HERE}


def test_only_this_process_says_something(processes, tmp_path):
    processes(3)
    said = tmp_path / "said"

    def say(word):
        with said.open("a") as stream:
            stream.write(word)

    with workers.with_copies():
        tell = workers.once(say)
        tell("a")
        both_work()
        tell("b")
        answers(lambda k: None)
        tell("c")
    assert said.read_text() == "abc"


@pytest.mark.parametrize("many", [1, 3])
def test_what_is_postponed_is_done_with_the_next_work(processes, many):
    processes(many)
    late, begun = {}, []
    with workers.with_copies():
        workers.postpone(lambda k: k / 7.0, range(3), late.__setitem__)
        assert len(late) == (3 if many == 1 else 0)
        assert answers(lambda k: begun.append(k) or k) == {k: k for k in range(40)}
        assert late == {k: k / 7.0 for k in range(3)}
        assert answers(lambda k: -k) == {k: -k for k in range(40)} and len(late) == 3
    workers.postpone(lambda k: k, range(3, 5), late.__setitem__)  # nobody shares: now
    assert late[3] == 3 and late[4] == 4


def test_pieces_share_out_nothing_further(processes):
    processes(2)
    inner = answers(lambda k: sorted(answers(lambda i: os.getpid(), 5).values()), 6)
    assert all(len(set(who)) == 1 and len(who) == 5 for who in inner.values())


def test_copies_end_where_this_process_does_not_end_them(processes, tmp_path):
    """Killed in the middle, it leaves nobody behind."""
    code = f"""
import os, time
from exoid.ground.engines import workers
with workers.with_copies():
    workers.share_out(lambda k: time.sleep(0.01), range(20), lambda k, answer: None)
    open({str(tmp_path)!r} + f"/{{os.getpid()}}", "w").close()
    time.sleep(0.2)
    if workers._TEAM[0].leader is None:
        os.kill(os.getpid(), 9)
    workers.share_out(lambda k: k, range(20), lambda k, answer: None)
"""
    processes(2)
    done = subprocess.run([sys.executable, "-c", code], cwd=Path(__file__).parents[2], timeout=HUNG)
    assert done.returncode == -signal.SIGKILL
    begun = [int(path.name) for path in tmp_path.iterdir()]
    assert len(begun) == 2
    until(lambda: not any(Path(f"/proc/{process}").exists() for process in begun), lambda: "a copy lives on")


def test_what_is_cleared_away_after_an_interruption_is_not_told(tmp_path):
    """The helper of joblib's processes finds semaphores of one that ended at once."""
    pytest.importorskip("joblib")
    code = """
import os
from exoid.ground.engines.processes import alone
engine = alone()
print(engine.executor.submit(abs, -3).result(), flush=True)
os._exit(130)
"""
    done = subprocess.run(
        [sys.executable, "-c", code], cwd=Path(__file__).parents[2], capture_output=True, text=True, timeout=HUNG
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, "3\n", "")


@pytest.mark.parametrize("many", [1, 3])
def test_the_first_that_passes_is_found_whoever_looks(many, processes):
    processes(many)
    assert workers.first_passing(lambda k: k in (7, 23, 5), 40) == 5
    assert workers.first_passing(lambda k: False, 40) is None and workers.first_passing(bool, 0) is None


def test_large_answers_do_not_stop_a_copy(processes):
    processes(2)
    assert answers(lambda k: "x" * 1_000_000, 12) == dict.fromkeys(range(12), "x" * 1_000_000)


def test_an_error_or_an_interruption_here_ends_the_copies(processes):
    processes(2)

    def interrupted(k, answer):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        workers.share_out(lambda k: k, range(9), interrupted)
    with pytest.raises(ZeroDivisionError):
        workers.share_out(lambda k: 1 // 0, range(9), lambda k, answer: None)


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
