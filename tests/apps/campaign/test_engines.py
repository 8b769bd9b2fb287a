"""Every engine runs jobs, survives lost workers, and says what it lost."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from exoid.apps.campaign.engines.cell import Cell, in_cell
from exoid.apps.campaign.engines.local import local
from exoid.ground.engines.engine import EngineError, completed
from tests.waiting import HUNG, until

ROOT = Path(__file__).parents[3]


@pytest.fixture
def cell():
    made = Cell()
    yield made
    made.close()


def test_a_job_comes_back_with_its_value(cell):
    assert cell.run("math:fsum", [1, 2, 3.5])["value"] == 6.5


def test_an_exception_is_an_answer_with_its_traceback(cell):
    answer = cell.run("math:sqrt", -1)
    assert answer["status"] == "failed" and "math domain error" in answer["reason"]
    assert cell.run("math:sqrt", 4)["value"] == 2.0


def test_a_value_that_is_no_plain_data_is_a_failure_and_not_an_end(cell):
    assert cell.run("builtins:iter", [1])["status"] == "failed"


def test_a_job_that_is_late_is_stopped_and_the_next_one_runs(cell):
    assert cell.run("time:sleep", HUNG, 0.3)["status"] == "late"
    assert cell.run("math:fsum", [1])["value"] == 1.0


def test_a_process_that_ends_in_a_job_is_replaced_once_and_then_given_up(cell):
    answer = cell.run("os:_exit", 3)
    assert (answer["status"], answer["attempts"]) == ("crashed", 2) and "status 3" in answer["reason"]
    assert cell.run("math:fsum", [1])["value"] == 1.0


def test_what_a_job_prints_is_not_taken_for_its_answer(cell, capfd):
    assert cell.run("builtins:print", '{"status": "done"}')["value"] is None


def test_the_process_ends_with_its_worker(tmp_path):
    script = (
        "from exoid.apps.campaign.engines.cell import Cell; import os, sys\n"
        "c = Cell(); c.run('math:sqrt', 4); print(c._started().pid, flush=True); os.kill(os.getpid(), 9)"
    )
    done = subprocess.run([sys.executable, "-c", script], cwd=ROOT, capture_output=True, text=True, timeout=HUNG)
    pid = int(done.stdout.split()[-1])
    until(lambda: not alive(pid), lambda: "the process of a worker that was killed is still there")


def alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    try:
        return Path(f"/proc/{pid}/stat").read_text().split()[2] != "Z"
    except OSError:
        return False


def test_jobs_come_back_as_they_end_and_few_are_handed_over_at_a_time():
    engine = local(2)
    asked = []

    def jobs():
        for k in range(20):
            asked.append(k)
            yield k

    try:
        results = completed(engine, in_cell, jobs(), lambda k: ("math:fsum", [k]))
        first = next(results)
        assert len(asked) <= 5
        found = dict([first, *results])
    finally:
        engine.close(True)
    assert {k: future.result()["value"] for k, future in found.items()} == {k: float(k) for k in range(20)}


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
def test_a_dask_worker_that_is_killed_while_it_works_is_retried_and_said():
    pytest.importorskip("distributed")
    from exoid.apps.campaign.engines.dask import dask

    engine = dask("local", 2)
    try:
        pids = dict(engine.executor._client.run(os.getpid))
        jobs = [0.5] * 8
        results = []
        for k, (_, future) in enumerate(completed(engine, in_cell, jobs, lambda s: ("time:sleep", s))):
            if k == 0:
                os.kill(next(iter(pids.values())), signal.SIGKILL)
            results.append(future.result()["status"])
        assert results == ["done"] * 8
        assert any("is gone" in text for text in engine.lost())
    finally:
        engine.close(True)


@pytest.mark.slow
def test_a_dask_scheduler_that_does_not_answer_is_refused_in_words(monkeypatch):
    pytest.importorskip("distributed")
    from exoid.apps.campaign.engines import dask as module

    monkeypatch.setattr(module, "PATIENCE", 1.0)
    with pytest.raises(EngineError, match="no Dask cluster"):
        module.dask("tcp://127.0.0.1:9")


@pytest.mark.slow
def test_submitit_runs_jobs_on_this_machine(tmp_path):
    pytest.importorskip("submitit")
    from exoid.apps.campaign.engines.slurm import slurm

    engine = slurm("local", tmp_path, 2)
    try:
        found = completed(engine, in_cell, [1, 2, 3], lambda k: ("math:fsum", [k, 1]))
        assert sorted(future.result()["value"] for _, future in found) == [2.0, 3.0, 4.0]
    finally:
        engine.close(True)


@pytest.mark.slow
def test_slurm_that_is_not_there_is_refused_in_words(tmp_path):
    submitit = pytest.importorskip("submitit")
    if submitit.AutoExecutor.which() == "slurm":
        pytest.skip("this machine has Slurm")
    from exoid.apps.campaign.engines.slurm import slurm

    with pytest.raises(EngineError, match="no Slurm"):
        slurm("short", tmp_path)
