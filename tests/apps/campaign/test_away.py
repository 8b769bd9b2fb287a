"""Recordings that are away for a moment, exchanged, copied or renamed, and engines that are lost midway."""

from __future__ import annotations

import csv
import os
import shutil
from concurrent.futures import CancelledError, Executor, Future
from pathlib import Path

import pytest

from exoid.apps.campaign import work as module
from exoid.apps.campaign.copies import describe_copies, same_recordings
from exoid.apps.campaign.engines.dask import dask
from exoid.apps.campaign.engines.local import local
from exoid.apps.campaign.plan import read_plan
from exoid.apps.campaign.run import run_campaign
from exoid.apps.campaign.store import AwayError, CampaignError, JobStore, task_of
from exoid.ground.engines.engine import Engine, EngineError
from exoid.ground.version import versions
from exoid.workbench.command import main

DEMO = Path(__file__).parents[3] / "exoid" / "workbench" / "demo_data"
PLAN = 'verb = "compare"\nfiles = "data/{device}/run_{run}.csv"\nverify = 1\n[options]\ncutoff = 6\n'


@pytest.fixture
def fleet(tmp_path):
    """Devices "d 1" and "d-1", with recordings of their own."""
    for k, device in enumerate(("d 1", "d-1")):
        place = tmp_path / "data" / device
        place.mkdir(parents=True)
        for run in (1, 2):
            lines = (DEMO / f"train_{run}.csv").read_text().splitlines(keepends=True)
            (place / f"run_{run}.csv").write_text("".join(lines[: len(lines) - k]))
    (tmp_path / "plan.toml").write_text(PLAN)
    return tmp_path


class Here(Executor):
    """Runs jobs in this process, and `between` before each."""

    def __init__(self, between=lambda: None):
        self.between = between

    def submit(self, fn, /, *args, **kwargs):
        self.between()
        future = Future()
        try:
            value = module.work(args[1])
            future.set_result({"status": "done", "value": value, "attempts": 1, "worker": "here"})
        except OSError as error:
            future.set_exception(error)
        return future


def engine(between=lambda: None, lost=list, ships=False):
    return Engine("here", Here(between), lambda: 1, lost, lambda wait: None, ahead=1, ships=ships)


def run(fleet, *, using=None):
    return run_campaign(read_plan(fleet / "plan.toml"), fleet / "out", using or engine())


def table(fleet):
    with (fleet / "out" / "table.csv").open(newline="") as stream:
        return list(csv.DictReader(stream))


@pytest.fixture
def quick(monkeypatch):
    monkeypatch.setattr(module, "PAUSE", 0.0)


@pytest.mark.slow
@pytest.mark.parametrize("ships", [False, True])
@pytest.mark.parametrize("how", ["away", "another", "a folder"])
def test_a_recording_that_is_away_leaves_no_answer_to_the_whole_group(how, ships, fleet, quick):
    path, kept = fleet / "data" / "d-1" / "run_1.csv", fleet / "kept.csv"
    shutil.copy(path, kept)

    def between():
        if path.is_file():
            path.unlink()
        if how == "another":
            shutil.copy(DEMO / "verify.csv", path)
        if how == "a folder":
            path.mkdir(exist_ok=True)

    found = run(fleet, using=engine(between, ships=ships))
    assert found.counts == {"done": 1, "away": 1} and "run_1.csv" in found.rows[1]["reason"]
    shutil.rmtree(path) if path.is_dir() else path.unlink(missing_ok=True)
    shutil.copy(kept, path)
    again = run(fleet)
    assert again.counts == {"done": 2} and again.kept == 1 and not again.rows[1]["unreadable"]
    assert again.rows[1]["result"]["verify_rms"] and len(again.rows[1]["recordings"]) == 1


@pytest.mark.slow
def test_one_that_comes_back_while_the_job_runs_is_waited_for(fleet, monkeypatch):
    path, kept = fleet / "data" / "d-1" / "run_2.csv", fleet / "kept.csv"
    shutil.copy(path, kept)
    monkeypatch.setattr(module.time, "sleep", lambda _: shutil.copy(kept, path))
    found = run(fleet, using=engine(lambda: path.unlink(missing_ok=True) if path.exists() else None))
    assert found.counts == {"done": 2}


@pytest.mark.slow
def test_one_that_comes_back_between_two_looks_is_no_refusal(fleet, quick, monkeypatch):
    """The command does not find it; when it is asked which recording that was, all are there."""
    path, kept = fleet / "data" / "d-1" / "run_1.csv", fleet / "kept.csv"
    shutil.copy(path, kept)
    ask = module._why_not

    def back(task, file):
        shutil.copy(kept, path)
        return ask(task, file)

    monkeypatch.setattr(module, "_why_not", back)
    found = run(fleet, using=engine(lambda: path.unlink(missing_ok=True)))
    assert found.counts == {"done": 2} and not found.rows[1]["unreadable"]


@pytest.mark.slow
def test_what_is_refused_for_good_stays_refused(fleet, quick):
    (fleet / "data" / "d-1" / "run_1.csv").write_text("t,q1,q2,tau1,tau2\n1,2\n")
    (fleet / "data" / "d-1" / "run_3.csv").write_text("t,q1,q2,tau1,tau2\n1,2\n")
    found = run(fleet)
    assert found.counts == {"done": 1, "refused": 1}
    assert run(fleet).kept == 2


@pytest.mark.slow
def test_one_that_cannot_be_looked_at_does_not_stop_the_others(fleet, quick, monkeypatch):
    from exoid.apps.campaign import store

    look = store.sha256_file

    def gone(path):
        if "d-1" in str(path):
            raise OSError(5, "Input/output error", path)
        return look(path)

    with monkeypatch.context() as patched:
        patched.setattr(store, "sha256_file", gone)
        found = run(fleet)
        assert found.counts == {"done": 1, "away": 1} and "Input/output error" in found.rows[1]["reason"]
    assert run(fleet).counts == {"done": 2}


def test_a_recording_that_changed_is_another_one_in_the_same_process_too(fleet):
    job = read_plan(fleet / "plan.toml").jobs[0]
    before = JobStore(fleet / "out", {}).key(job)
    shutil.copy(DEMO / "verify.csv", fleet / "data" / "d 1" / "run_1.csv")
    assert JobStore(fleet / "out", {}).key(job) != before


def test_a_task_says_what_was_looked_at(fleet):
    store, job = JobStore(fleet / "out", versions()), read_plan(fleet / "plan.toml").jobs[0]
    task = task_of(job, ships=False, report=False, versions=versions(), store=store)
    assert [one["sha256"] for one in task["recordings"]] == store.sums(job)["recordings"]
    assert module.work(task)["status"] == "done"


# -- names ---------------------------------------------------------------------------------------------------------


@pytest.mark.slow
def test_a_field_that_was_renamed_keeps_its_column(fleet):
    assert [row["device"] for row in (run(fleet), table(fleet))[1]] == ["d 1", "d-1"]
    (fleet / "plan.toml").write_text(PLAN.replace("{device}", "{leg}"))
    assert run(fleet).kept == 2
    assert [row["leg"] for row in table(fleet)] == ["d 1", "d-1"] and "device" not in table(fleet)[0]


@pytest.mark.slow
def test_devices_with_the_same_recordings_stay_several_and_it_is_said(fleet, capsys):
    for run_file in (fleet / "data" / "d 1").iterdir():
        shutil.copy(run_file, fleet / "data" / "d-1" / run_file.name)
    for _ in range(2):  # also when the answers are there already
        found = run(fleet)
        assert [row["fields"]["device"] for row in found.rows] == ["d 1", "d-1"]
        assert found.events == ("2 recordings are the same, byte for byte, in d 1, d-1: counted as several devices",)
        lines = table(fleet)
        assert [line["device"] for line in lines] == ["d 1", "d-1"]
        assert lines[0]["same_recordings"] == "run_1.csv = d-1/run_1.csv; run_2.csv = d-1/run_2.csv"
    assert main(["campaign", str(fleet / "plan.toml"), "--out", str(fleet / "out"), "--jobs", "1"]) == 0
    out = capsys.readouterr()
    assert "byte for byte" in out.out + out.err


def test_copies_are_said_once_for_all_that_share_them():
    rows = [
        {"name": f"d{k}", "fields": {"device": f"d{k}"}, "recordings": ["a"], "verify": ["b"],
         "sums": {"recordings": ["x"], "verify": [str(k)]}}
        for k in range(20)
    ]  # fmt: skip
    (said,) = describe_copies(rows, "device")
    assert "1 recording is" in said and "and 14 more" in said
    assert describe_copies(rows[:1], "device") == [] and same_recordings(rows[:1]) == [""]
    twice = {**rows[0], "recordings": ["a", "c"], "sums": {"recordings": ["x", "x"]}}
    assert describe_copies([twice], "device")[0].endswith("in d0: counted several times")
    assert describe_copies([{"name": "old", "fields": {}, "recordings": ["a"], "verify": []}], None) == []


# -- what is in the way --------------------------------------------------------------------------------------------


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="only where there are pipes")
def test_a_pipe_or_link_among_the_answers_is_refused_before_the_work_starts(fleet):
    job = read_plan(fleet / "plan.toml").jobs[1]
    store = JobStore(fleet / "out", versions())
    path = store.path(job, store.key(job))
    for place in (path, fleet / "out" / "table.csv"):
        place.parent.mkdir(parents=True, exist_ok=True)
        os.mkfifo(place)
        with pytest.raises(CampaignError, match="not an ordinary file"):
            run(fleet)
        place.unlink()
        place.symlink_to(fleet / "plan.toml")
        with pytest.raises(CampaignError, match="is a link"):
            run(fleet)
        place.unlink()
    os.mkfifo(fleet / "model.toml")
    (fleet / "plan.toml").write_text('model = "model.toml"\n' + PLAN)
    with pytest.raises(CampaignError, match="model file cannot be read"):
        run(fleet)


@pytest.mark.slow
def test_an_engine_that_is_lost_midway_leaves_what_was_answered(fleet):
    asked = []

    def lost():
        asked.append(1)
        if len(asked) > 1:
            raise EngineError("the scheduler does not answer any more")
        return []

    with pytest.raises(EngineError, match="same command"):
        run(fleet, using=engine(lost=lost))
    assert [row["status"] for row in table(fleet)] == ["done"]
    again = run(fleet)
    assert again.counts == {"done": 2} and again.kept == 1


def test_an_executor_that_takes_no_more_jobs_is_said_in_words(fleet):
    def closed():
        raise RuntimeError("cannot schedule new futures after shutdown")

    with pytest.raises(EngineError, match="takes no more jobs"):
        run(fleet, using=engine(closed))


@pytest.mark.slow
def test_a_job_of_a_worker_that_was_lost_is_tried_again_next_time(fleet):
    class Gone(Here):
        def submit(self, fn, /, *args, **kwargs):
            future = Future()
            future.set_exception(CancelledError())
            return future

    found = run(fleet, using=Engine("gone", Gone(), lambda: 1, list, lambda wait: None, ahead=1))
    assert found.counts == {"crashed": 2} and run(fleet).counts == {"done": 2}


@pytest.mark.slow
def test_workers_of_this_machine_check_what_they_read(fleet):
    path = fleet / "data" / "d-1" / "run_1.csv"
    store, job = JobStore(fleet / "out", versions()), read_plan(fleet / "plan.toml").jobs[1]
    task = task_of(job, ships=False, report=False, versions=versions(), store=store)
    path.write_text(path.read_text() + "\n")
    here = local(1)
    try:
        from exoid.apps.campaign.engines.cell import in_cell

        found = here.executor.submit(in_cell, module.FUNCTION, task, 120.0).result()
    finally:
        here.close(True)
    assert found["value"]["status"] == "away" and "another file" in found["value"]["reason"]


def test_a_recording_that_is_gone_when_it_is_looked_at_is_away(fleet):
    store, job = JobStore(fleet / "out", {}), read_plan(fleet / "plan.toml").jobs[0]
    shutil.rmtree(fleet / "data" / "d 1")
    with pytest.raises(AwayError, match="cannot be read"):
        store.key(job)


@pytest.mark.parametrize("far", ["sent", pytest.param("dask", marks=pytest.mark.slow)])
def test_answers_name_the_files_of_the_sender_wherever_they_are_made(far, fleet):
    (fleet / "data" / "d-1" / "run_3.csv").write_text("nothing here\n")
    plan = read_plan(fleet / "plan.toml")
    run_campaign(plan, fleet / "near", engine())
    if far == "sent":
        run_campaign(plan, fleet / "far", engine(ships=True))
    else:
        here = {"n_workers": 1, "processes": False, "protocol": "tcp://", "dashboard_address": None}
        with pytest.importorskip("distributed").LocalCluster(**here) as cluster:
            using = dask(cluster.scheduler_address)
            run_campaign(plan, fleet / "far", using)
            using.close(True)
    near, away = (sorted(path for path in (fleet / name).rglob("*") if path.is_file()) for name in ("near", "far"))
    assert [path.name for path in near] == [path.name for path in away]
    assert [path.read_bytes() for path in near] == [path.read_bytes() for path in away]
    assert not any("recordings_" in path.read_text() for path in away if path.suffix in (".csv", ".json"))
