"""The search that starts by itself: it judges what is given, changes nothing until asked, and can be switched off."""

from __future__ import annotations

import time
from contextlib import closing
from dataclasses import replace

import pytest

from exoid.apps.page.saved import reopen, save
from exoid.apps.page.takeaway import report
from exoid.apps.page.views import details, state
from exoid.apps.page.work import start_work
from exoid.apps.page.workspace import Workspace
from exoid.measurement import simulate, write_recording
from exoid.symbolic import Joint, Model, write_model
from exoid.workbench.commands.demo import DATA
from tests.waiting import HUNG

MISSING = "load_friction:knee"


def wait_for(workspace, true):
    began = time.monotonic()
    while not true(shown := state(workspace)):
        assert time.monotonic() - began < HUNG, shown
        workspace.wait(workspace.version, 0.5)
    return shown


@pytest.fixture
def space(tmp_path):
    workspace = Workspace(tmp_path / "mappings")
    for name, role in (("train_1", "fit"), ("train_2", "fit"), ("verify", "verify")):
        workspace.add_file(DATA / f"{name}.csv", f"{name}.csv", role)
    yield workspace
    workspace.close()


@pytest.mark.slow
def test_the_answer_comes_by_itself_and_nothing_is_added_until_asked(space, tmp_path):
    start_work(space)
    first = wait_for(space, lambda shown: shown["ready"] and shown["fitted"])
    assert first["verdict"]["kind"] == "open" and not first["verdict"]["judged"]  # nothing is judged before that
    shown = wait_for(space, lambda shown: shown["ready"] and shown["verdict"]["judged"])
    verdict = shown["verdict"]
    assert verdict["kind"] == "missing" and verdict["proposed"] and verdict["sureness"] in shown["sureness"]
    assert [one["name"] for one in verdict["accepted"]] == [MISSING] and shown["layers"] == []
    assert shown["joints"][1]["after"] < 0.5 * shown["joints"][1]["error"]
    told = {one.name: one.explained_share for one in space.judging.answer(space.session).suspects}
    weighed = wait_for(space, lambda shown: shown["ranking"] and shown["ranking"]["weighed"] == 1.0)
    ranked = weighed["ranking"]["suspects"]
    assert {one["name"]: one["share"] for one in ranked}[MISSING] == told[MISSING]  # one share
    assert [one["name"] for one in ranked if one["name"] in told] == list(told)  # one order
    base, found = (step["verify_rms"] for step in space.judging.told(space.session)["steps"])
    shown = state(space)  # one number for one thing: of the answer, foreseen, and after it was added
    assert [one["error"] for one in shown["joints"]] == base and [one["after"] for one in shown["joints"]] == found
    foreseen = details(space, MISSING)
    assert foreseen["rms"] == found
    (accepted,) = space.judging.answer(space.session).accepted
    assert [one["value"] for one in foreseen["numbers"]] == [e.value for e in accepted.parameters.values()]

    space.discover()  # it is known: no second search
    assert space.names == (MISSING,) and space.search is None
    added = wait_for(space, lambda shown: shown["fitted"])
    assert [one["error"] for one in added["joints"]] == found and [one["first"] for one in added["joints"]] == base
    assert [one["value"] for one in added["layers"][0]["numbers"]] == [e.value for e in accepted.parameters.values()]
    taken = added["verdict"]
    assert taken["kind"] == "missing" and not taken["proposed"]

    again = Workspace(tmp_path / "again")
    reopen(again, save(space, tmp_path / "kept"))
    start_work(again)
    kept = wait_for(again, lambda shown: shown["ready"] and shown["verdict"]["judged"])["verdict"]
    again.close()
    assert kept == taken

    space.use_as(space.given[1].id, "verify")
    assert space.judging.answer(space.session) is None  # other recordings: it does not hold any more


def test_it_can_be_switched_off(space):
    space.judging.switch(False)
    start_work(space)
    shown = wait_for(space, lambda shown: shown["ready"] and shown["ranking"] and shown["ranking"]["finished"])
    assert shown["auto"] == {"on": False, "running": False} and shown["verdict"]["kind"] == "open"


@pytest.mark.slow
def test_a_report_before_anything_was_judged_is_of_the_machine_and_not_of_a_leg(tmp_path):
    drive = Model("drive", joints=(Joint("drive"),))
    write_model(drive, tmp_path / "drive.toml")
    path = write_recording(simulate(drive, duration=8.0), tmp_path / "run.csv")
    with closing(Workspace(tmp_path / "mappings", cutoff=6.0)) as workspace:
        workspace.use_model(tmp_path / "drive.toml", "drive.toml")
        workspace.add_file(path, path.name)
        start_work(workspace)
        wait_for(workspace, lambda shown: shown["ready"] and shown["fitted"])
        page = report(workspace)
    assert "drive" in page and "the knee" not in page


@pytest.mark.slow
def test_numbers_of_recordings_are_in_the_error_after_and_not_in_the_one_before(tmp_path):
    drive = Model("drive", joints=(Joint("drive"),))
    write_model(drive, tmp_path / "drive.toml")
    with closing(Workspace(tmp_path / "mappings")) as workspace:
        workspace.use_model(tmp_path / "drive.toml", "drive.toml")
        for k, zero in enumerate((2.0, -1.5, 0.4, -2.5)):
            run = simulate(drive, duration=15.0, seed=k)
            path = write_recording(replace(run, tau=run.tau + zero), tmp_path / f"run_{k}.csv")
            workspace.add_file(path, path.name, "verify" if k == 3 else "fit")
        start_work(workspace)
        (joint,) = wait_for(workspace, lambda shown: shown["ready"] and shown["verdict"]["judged"])["joints"]
        found = workspace.judging.answer(workspace.session)
        assert [one.what for one in found.of_recordings] == ["sensor_zero"] and not found.accepted
        assert joint["error"] == found.steps[0].verify_rms[0] and joint["after"] == found.steps[-1].verify_rms[0]
        assert joint["after"] < 0.2 * joint["error"]
        after = workspace.judging.after(workspace.session)
        assert after.verify_rms == pytest.approx([joint["after"]])
        workspace.discover()
        wait_for(workspace, lambda shown: shown["ready"] and shown["verdict"]["kind"] == "adequate")
        assert "Measured, before and after" in report(workspace)
