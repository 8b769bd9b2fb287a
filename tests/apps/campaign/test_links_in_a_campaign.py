"""The folder of a campaign that somebody else handed on leads nowhere."""

from __future__ import annotations

import shutil
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import pytest

from exoid.apps.campaign.engines.slurm import slurm
from exoid.apps.campaign.plan import Job, Plan
from exoid.apps.campaign.run import run_campaign
from exoid.apps.campaign.store import CampaignError, JobStore
from exoid.ground.errors import ExoidError

JOB = Job("d1", "compare", {"device": "d1"})
PLAN = Plan("plan", "compare", (), ("device",), "device", None)


@pytest.mark.parametrize("name", ["table.csv", "index.html", ".lock"])
def test_the_files_of_a_campaign(name, plant, tmp_path):
    plant(tmp_path / "fleet" / name)
    plan = Plan("plan", "compare", (), ("device",), "device", None)
    if name == "table.csv":
        from exoid.apps.campaign.table import write_tables

        row = {
            "name": "d1", "key": "k", "fields": {"device": "d1"}, "status": "refused", "reason": "", "recordings": [],
            "verify": [], "versions": {}, "seed": 0,
        }  # fmt: skip
        with pytest.raises(OSError, match=r"link|ordinary"):
            write_tables(tmp_path / "fleet", plan, [row])
        return
    with pytest.raises((OSError, ExoidError), match=r"link|ordinary"):
        run_campaign(plan, tmp_path / "fleet", ThreadPoolExecutor(1))


@pytest.mark.parametrize("name", ["jobs", "d1"])
def test_the_answers_of_a_campaign(name, plant, tmp_path):
    store = JobStore(tmp_path / "fleet", {})
    path = store.path(JOB, "k")
    plant(tmp_path / "fleet" / "jobs" if name == "jobs" else path)
    with pytest.raises(CampaignError, match=r"link|ordinary"):
        store.read(JOB, "k")
    with pytest.raises(OSError, match=r"link|ordinary|directory|exists"):
        store.write(JOB, "k", {"status": "done"})


def test_an_answer_that_was_linked_from_another_campaign_is_not_taken(tmp_path):
    JobStore(tmp_path / "theirs", {}).write(JOB, "k", {"status": "done"})
    store = JobStore(tmp_path / "fleet", {})
    path = store.path(JOB, "k")
    path.parent.mkdir(parents=True)
    shutil.copy(tmp_path / "theirs" / "jobs" / path.name, path)
    assert store.read(JOB, "k")["status"] == "done"
    path.unlink()
    path.symlink_to(tmp_path / "theirs" / "jobs" / path.name)
    with pytest.raises(CampaignError, match="is a link"):
        store.read(JOB, "k")


def test_submitit_finds_no_answer_that_lay_there_before(tmp_path, monkeypatch):
    submitit = pytest.importorskip("submitit")
    asked, executor = [], submitit.AutoExecutor

    def made(folder, cluster):
        asked.append(Path(folder))
        return executor(folder, cluster=cluster)

    monkeypatch.setattr(submitit, "AutoExecutor", made)
    for _ in range(2):
        slurm("local", tmp_path / "slurm", 1).close(True)
    first, second = asked
    assert first.parent != second.parent and first.parent.parent == tmp_path / "slurm"
    (tmp_path / "linked").symlink_to(tmp_path)
    with pytest.raises(ExoidError, match="link"):
        slurm("local", tmp_path / "linked", 1)
