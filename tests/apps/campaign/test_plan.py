"""What a plan means: which recordings belong together, which are held out, and what is refused in which line."""

from __future__ import annotations

import sys

import pytest

from exoid.apps.campaign import verbs
from exoid.apps.campaign.plan import PlanError, read_plan


@pytest.fixture
def fleet(tmp_path):
    for device in ("d1", "d2"):
        for side in ("left", "right"):
            folder = tmp_path / "data" / device / side
            folder.mkdir(parents=True)
            for run in (1, 2, 10):
                (folder / f"run_{run}.csv").write_text("t\n")
    return tmp_path


def plan(folder, text):
    path = folder / "plan.toml"
    path.write_text(text)
    return read_plan(path)


FILES = 'files = "data/{device}/{side}/run_{run}.csv"\n'


def test_a_job_per_group_in_natural_order_with_the_last_recordings_held_out(fleet):
    found = plan(fleet, FILES + "verify = 1\n")
    assert [job.name for job in found.jobs] == ["d1/left", "d1/right", "d2/left", "d2/right"]
    job = found.jobs[1]
    assert job.fields == {"device": "d1", "side": "right"} and job.verb == "discover"
    assert [p.rsplit("/", 1)[1] for p in job.recordings] == ["run_1.csv", "run_2.csv"]
    assert [p.rsplit("/", 1)[1] for p in job.verify] == ["run_10.csv"]
    assert found.device == "device" and found.date is None


def test_held_out_by_field_and_groups_and_models_by_field(fleet):
    text = FILES + 'group = ["side"]\nverify = { device = ["d2"], run = ["10", 2] }\nmodel = "m/{side}.toml"\n'
    found = plan(fleet, text + '[options]\ncutoff = 6\nderivative = "savgol"\n')
    left, right = found.jobs
    assert len(left.recordings) == 4 and len(left.verify) == 2 and all("/d2/" in p for p in left.verify)
    assert right.model is not None and right.model.endswith("m/right.toml")
    assert left.options == ("--cutoff=6", "--derivative=savgol")


def test_a_job_per_recording_that_is_watched(fleet):
    found = plan(fleet, FILES + 'verb = "watch"\n[options]\nlearn = 60\n')
    assert len(found.jobs) == 12 and found.jobs[0].fields["run"] == "1" and found.jobs[0].options == ("--learn=60",)


def test_a_group_with_nothing_to_fit_is_said(fleet):
    for run in (1, 2):
        (fleet / "data" / "d1" / "left" / f"run_{run}.csv").unlink()
    found = plan(fleet, FILES + "verify = 1\n")
    assert len(found.jobs) == 3 and "d1/left" in found.notes[0]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("files = 3\n", "files"),
        ("", "files is missing"),
        ('files = "data/{device}/x.csv"\n', "no recording matches"),
        ('files = "data/{device}{side}/x.csv"\n', "touch each other"),
        ('files = "data/{device}*/x.csv"\n', "touch each other"),
        ('files = "data/x**/{run}.csv"\n', "touch each other"),
        (FILES + 'group = ["sida"]\n', "not a field"),
        (FILES + "verify = true\n", "neither a number nor a table"),
        (FILES + 'verify = { day = ["1"] }\n', "not a field"),
        (FILES + "verify = 3\n", "every recording is held out"),
        (FILES + 'verb = "discovr"\n', "discover"),
        (FILES + 'verb = "watch"\nverify = 1\n', "holds no recording out"),
        (FILES + 'verb = "watch"\ngroup = ["device"]\n', "one recording at a time"),
        (FILES + "[options]\ncutof = 6\n", "--cutoff"),
        (FILES + "[options]\njson = 'x'\n", "set by the campaign itself"),
        (FILES + "timeout = -1\n", "out of range"),
        (FILES + "reports = 1\n", "true nor false"),
        (FILES + 'model = "{date}.toml"\n', "not a field"),
        (FILES + 'device = "date"\n', "not a field"),
        ("verb = [\n", "not valid TOML"),
        ("x = " + "[" * 5000, "not valid TOML"),
        (FILES + "nonsense = 1\n", "unknown key"),
    ],
)
def test_what_cannot_be_meant_is_refused_with_its_place(fleet, text, words):
    with pytest.raises(PlanError.__mro__[1], match=words) as refused:
        plan(fleet, text)
    assert "plan.toml" in str(refused.value) and refused.value.remedy


def test_a_plan_that_is_no_file_is_refused(tmp_path):
    for path in (tmp_path, tmp_path / "missing.toml"):
        with pytest.raises(PlanError):
            read_plan(path)


def test_a_field_takes_any_name_as_text(tmp_path):
    odd = tmp_path / "data" / "a[1] (x) ;$ü" / "l"
    odd.mkdir(parents=True)
    (odd / "run_1.csv").write_text("t\n")
    assert plan(tmp_path, FILES).jobs[0].fields["device"] == "a[1] (x) ;$ü"


def test_a_new_file_is_a_new_command_to_ask(fleet, tmp_path, monkeypatch):
    text = FILES + 'verb = "map"\n'
    with pytest.raises(PlanError, match="'map' cannot be asked"):
        plan(fleet, text)
    (tmp_path / "verbs").mkdir()
    (tmp_path / "verbs/map.py").write_text(
        "from exoid.apps.campaign.verb import CampaignVerb\n\nVERB = CampaignVerb(alone=True)\n"
    )
    monkeypatch.setattr(verbs, "__path__", [*verbs.__path__, str(tmp_path / "verbs")])
    try:
        assert {job.verb for job in plan(fleet, text).jobs} == {"map"}
    finally:
        sys.modules.pop("exoid.apps.campaign.verbs.map", None)
