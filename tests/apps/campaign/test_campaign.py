"""A campaign from plan to page: interrupted and resumed, refused recordings, edited answers, two at once."""

from __future__ import annotations

import json
import os
import shlex
import shutil
import signal
import subprocess
import sys
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest
from joblib.externals.loky import ProcessPoolExecutor

from exoid.apps.campaign.engines.local import local
from exoid.apps.campaign.page import render_campaign
from exoid.apps.campaign.plan import Job, Plan, read_plan
from exoid.apps.campaign.run import run_campaign
from exoid.apps.campaign.store import CampaignError, JobStore
from exoid.apps.campaign.table import flat, write_tables
from exoid.apps.campaign.verbs.watch import row_of_events
from exoid.ground.engines.engine import EngineError
from exoid.workbench.command import main

ROOT = Path(__file__).parents[3]
DEMO = ROOT / "exoid" / "workbench" / "demo_data"
HOSTILE = "</script><script>alert(1)</script>"


@pytest.fixture(scope="module")
def plan_file(tmp_path_factory):
    """Two devices with two recordings each, and one that nobody can read."""
    folder = tmp_path_factory.mktemp("plan")
    for device in ("d1", "d2"):
        place = folder / "data" / device
        place.mkdir(parents=True)
        shutil.copy(DEMO / "train_1.csv", place / "run_1.csv")
        shutil.copy(DEMO / "train_2.csv", place / "run_2.csv")
    (folder / "data" / "d2" / "run_0.csv").write_text("t,q1,q2,tau1,tau2\n1,2\n")
    text = 'verb = "compare"\nfiles = "data/{device}/run_{run}.csv"\nverify = 1\n[options]\ncutoff = 6\n'
    (folder / "plan.toml").write_text(text)
    return folder / "plan.toml"


@pytest.fixture(scope="module")
def finished(plan_file, tmp_path_factory):
    folder = tmp_path_factory.mktemp("out")
    engine = local(2)
    found = run_campaign(read_plan(plan_file), folder, engine)
    engine.close(True)
    return found, folder


def plan_folder(found):
    """Return the folder of the plan whose recordings lie in data/DEVICE/."""
    return Path(found.plan.jobs[0].recordings[0]).resolve().parents[2]


def test_every_job_has_a_row_and_what_cannot_be_read_is_one_too(finished):
    found, folder = finished
    assert found.counts == {"done": 2} and found.kept == 0
    first, second = found.rows
    assert first["result"]["rms"] == second["result"]["rms"] and not first["unreadable"]
    assert second["unreadable"][0]["path"] == "d2/run_0.csv" and second["unreadable"][0]["reason"]
    assert str(plan_folder(found)) not in (folder / "index.html").read_text("utf-8")
    lines = (folder / "unreadable.csv").read_text().splitlines()
    assert len(lines) == 2 and "run_0.csv" in lines[1]
    assert "seconds" not in json.dumps(first)


def test_going_on_does_nothing_twice_and_writes_the_same_bytes(finished, plan_file):
    _, folder = finished
    before = {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}
    engine = local(1)
    again = run_campaign(read_plan(plan_file), folder, engine)
    engine.close(True)
    assert again.kept == 2
    assert before == {p.relative_to(folder): p.read_bytes() for p in folder.rglob("*") if p.is_file()}


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["threads", "loky"])
def test_any_executor_gives_the_same_bytes(kind, finished, plan_file, tmp_path):
    """As docs/campaigns.md says."""
    _, whole = finished
    with ThreadPoolExecutor(2) if kind == "threads" else ProcessPoolExecutor(2) as executor:
        run_campaign(read_plan(plan_file), tmp_path, executor)
    assert (tmp_path / "table.csv").read_bytes() == (whole / "table.csv").read_bytes()


@pytest.mark.slow
@pytest.mark.parametrize(("package", "folder"), [("distributed", "fleet-client"), ("submitit", "fleet-submitit")])
def test_a_recipe_for_a_cluster_gives_the_same_bytes(package, folder, finished, plan_file, tmp_path):
    """The two of docs/campaigns.md, typed as they stand there, with the library itself."""
    pytest.importorskip(package)
    blocks = (ROOT / "docs" / "campaigns.md").read_text("utf-8").split("```python\n")[1:]
    (recipe,) = (code for code, *_ in (block.split("```") for block in blocks) if folder in code)
    shutil.copytree(plan_file.parent, tmp_path, dirs_exist_ok=True)
    (tmp_path / "recipe.py").write_text(recipe)
    environment = {**os.environ, "PYTHONPATH": str(ROOT)}
    words = [sys.executable, "recipe.py"]
    done = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "2 done" in done.stdout, done.stderr
    assert (tmp_path / folder / "table.csv").read_bytes() == (finished[1] / "table.csv").read_bytes()


def test_what_is_no_executor_is_refused_in_words(plan_file, tmp_path):
    with pytest.raises(EngineError, match=r"int is no concurrent\.futures\.Executor"):
        run_campaign(read_plan(plan_file), tmp_path, 8)


def test_an_answer_that_was_edited_or_cut_is_not_believed(finished, plan_file, tmp_path):
    from exoid.ground.version import versions

    found, folder = finished
    shutil.copytree(folder, tmp_path / "out")
    store = JobStore(tmp_path / "out", versions())
    job = read_plan(plan_file).jobs[0]
    key = store.key(job)
    path = store.path(job, key)
    assert store.read(job, key) == found.rows[0]
    text = path.read_text()
    edited = json.loads(text)
    edited["row"]["result"]["rms"] = [0.0, 0.0]
    for damaged in (json.dumps(edited), text[:100], "", "[]", "[" * 3000, '{"row": 1}'):
        path.write_text(damaged)
        assert store.read(job, key) is None


def test_two_campaigns_in_one_folder_are_refused(finished, plan_file):
    from exoid.apps.campaign.run import _alone

    _, folder = finished
    engine = local(1)
    with _alone(folder), pytest.raises(CampaignError, match="another campaign"):
        run_campaign(read_plan(plan_file), folder, engine)
    engine.close(True)


def test_a_worker_with_other_versions_is_refused_in_words(plan_file):
    from exoid.apps.campaign.store import task_of
    from exoid.apps.campaign.work import work

    job = read_plan(plan_file).jobs[0]
    answer = work(task_of(job, ships=False, report=False, versions={"exoid": "9.9", "casadi": "0.1"}))
    assert answer["status"] == "versions" and "casadi 0.1 here" in answer["reason"]


def test_recordings_that_travel_as_bytes_give_the_same_answer(finished, plan_file):
    from exoid.apps.campaign.store import task_of
    from exoid.apps.campaign.work import work
    from exoid.ground.version import versions

    found, _ = finished
    job = read_plan(plan_file).jobs[0]
    task = json.loads(json.dumps(task_of(job, ships=True, report=False, versions=dict(versions()))))
    assert work(task)["result"]["rms"] == pytest.approx(found.rows[0]["result"]["rms"], rel=1e-9)


def test_the_command_counts_prints_and_writes(plan_file, finished, capsys):
    _, folder = finished
    assert main(["campaign", str(plan_file), "--out", str(folder), "--dry-run"]) == 0
    assert "d2" in capsys.readouterr().out
    assert main(["campaign", str(plan_file), "--out", str(folder), "--json", "-", "--jobs", "1"]) == 0
    payload = json.loads(capsys.readouterr().out)
    assert payload["status"] == {"done": 2} and payload["rows"][0]["device"] == "d1"


def rows(count):
    names = ["hip", HOSTILE]
    return [
        {
            "name": f"job {k} {HOSTILE}", "key": f"{k:016d}",
            "fields": {"device": f"d{k % 7}", "date": f"2026-0{1 + k % 9}-01"},
            "recordings": ["a"], "verify": [], "versions": {"exoid": "0.1"}, "seed": 0,
            "status": "done", "report": k == 0,
            "result": {
                "verdict": "missing", "accepted": [
                    {
                        "effect": "stribeck", "joint": names[k % 2], "look_alikes": ["x"],
                        "parameters": {"c": {"value": 2.6, "low": 2.5, "high": 2.7, "unit": "N·m"}},
                    }
                ],
                "steps": [{"train_rms": [1.0, 2.0], "verify_rms": None}], "noise_floor": [0.1, 0.2],
                "parameters": {"Phi1": {"value": 1.0 + 0.01 * (k % 7), "low": 0.9, "high": 1.1, "unit": "kg·m²"}},
            },
        }
        for k in range(count)
    ]  # fmt: skip


def fake_plan(count):
    jobs = tuple(Job(f"job {k}", "discover", {"device": f"d{k % 7}"}) for k in range(count))
    return Plan("fleet " + HOSTILE, "discover", jobs, ("device", "date"), "device", "date")


def test_names_from_files_are_data_in_the_page_and_in_tables(tmp_path):
    page = render_campaign(fake_plan(20), rows(20), [HOSTILE], running=False)
    assert HOSTILE not in page and page.count("</script>") == 2
    write_tables(tmp_path, fake_plan(1), [{**rows(1)[0], "name": "=cmd()"}])
    assert "\n'=cmd()," in (tmp_path / "table.csv").read_text()


def test_a_row_is_flat_and_says_before_and_after():
    line = flat(fake_plan(1), rows(1)[0])
    assert line["effects"] == "stribeck:hip" and line["rms_before_hip"] == 1.0 and line["noise_floor_knee"] == 0.2
    assert line["values"] == "stribeck:hip c = 2.6 [2.5, 2.7] N·m" and line["versions"] == "exoid 0.1"


def change(name, state, value, kind="abrupt"):
    number = {"value": value, "unit": "1", "low": value - 0.01, "high": value + 0.01}
    found = {"name": name, "change": {"c": number}, "look_alikes": [], "p_value": 0.001}
    since = {"t": 200.0, "low": 195.0, "high": 205.0}
    return {
        "event": "change", "state": state, "kind": kind, "since": since, "differences": [found],
        "rms_before": [0.1, 0.1], "rms_after": [0.1, 0.5],
    }  # fmt: skip


def test_the_events_of_a_watched_recording_are_one_row():
    start = [{"event": "start", "joints": ["hip", "knee"]}, {"event": "reference"}]
    named = [change("coulomb:knee", "first", 0.2), change("load_friction:knee", "refined", 0.1)]
    found = row_of_events([*start, *named, change("load_friction:knee", "over", 0.1, "over"), {"event": "summary"}])
    assert found["verdict"] == "changed" and [one["name"] for one in found["accepted"]] == ["load_friction:knee"]
    line = flat(fake_plan(1), {**rows(1)[0], "result": found})
    assert line["values"] == "load_friction:knee c = 0.1 [0.09, 0.11]" and line["rms_after_knee"] == 0.5
    assert row_of_events(start)["verdict"] == "unchanged" and row_of_events([])["verdict"] == "undetermined"
    assert row_of_events([*start, {"event": "unexplained"}])["verdict"] == "unexplained"


@pytest.mark.slow
def test_killed_at_any_moment_it_goes_on_and_gives_the_same_bytes(finished, plan_file, tmp_path):
    _, whole = finished
    command = [sys.executable, "-m", "exoid", "campaign", str(plan_file), "--out", str(tmp_path / "out")]
    process = subprocess.Popen([*command, "--jobs", "1"], cwd=ROOT, stdout=subprocess.DEVNULL)
    jobs = tmp_path / "out" / "jobs"
    while not (jobs.is_dir() and any(jobs.glob("*.json"))) and process.poll() is None:
        time.sleep(0.02)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    done = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    for name in ("table.csv", "parameters.csv", "unreadable.csv"):
        assert (tmp_path / "out" / name).read_bytes() == (whole / name).read_bytes()
    assert "from before" in done.stdout


@pytest.mark.slow
@pytest.mark.filterwarnings("ignore::DeprecationWarning")
@pytest.mark.parametrize("engine", ["distributed", "submitit"])
def test_the_clusters_of_the_page_give_the_same_bytes(engine, finished, plan_file, tmp_path, monkeypatch):
    pytest.importorskip(engine)
    _, whole = finished
    option = {"distributed": "--dask local", "submitit": "--slurm local"}[engine]
    shown = (ROOT / "docs" / "campaigns.md").read_text("utf-8")
    (line,) = (line for line in shown.splitlines() if line.startswith("$ exoid") and line.endswith(option))
    monkeypatch.chdir(plan_file.parent)
    monkeypatch.setenv("PYTHONPATH", str(ROOT))  # where exoid is not installed, workers find it as this process does
    words = [str(tmp_path) if word.startswith("fleet") else word for word in shlex.split(line)[2:]]
    assert main([*words, "--quiet"]) == 0
    assert (tmp_path / "table.csv").read_bytes() == (whole / "table.csv").read_bytes()
