"""What is taken away from the page says everything that was said to it, and a saved session holds it."""

from __future__ import annotations

import json
import shlex
import shutil
from dataclasses import replace

import pytest

from exoid.apps.page.given import VERIFY
from exoid.apps.page.saved import reopen, save
from exoid.apps.page.takeaway import commands, exported
from exoid.apps.page.workspace import Workspace
from exoid.ground.errors import ExoidError, RecordingError
from exoid.measurement.reading.mapping import StatedMapping
from exoid.symbolic.mechanics.payload import Payload
from exoid.workbench.command import verb_parser
from exoid.workbench.commands.demo import DATA

VERDICT = {
    "verdict": "missing", "sentence": "it rubs", "rule": "", "next_experiment": "", "stopped_because": "at last",
    "headline": "Found: rubbing; very sure", "sureness": "very sure", "possible": [],
    "accepted": [{"effect": "rub", "joint": "knee", "stability": "accepted in 4 of 4", "sentence": "rubbing"}],
    "steps": [{"model": "base", "train_rms": [1.0, 2.0], "verify_rms": None}],
}  # fmt: skip
OWN = {"id": "rub", "joint": "knee", "torque": "c * abs(tau_rigid) * sgn(dtheta)", "coefficients": {"c": {"unit": "1"}}}


@pytest.fixture
def full(tmp_path):
    """Return a workspace to which everything was said that can be; nothing is computed in it."""
    workspace = Workspace(tmp_path / "mappings", seed=3, cutoff=4.5, derivative="savgol")
    told = StatedMapping(
        {"q1": "A", "q2": "B"}, {"q": "deg"}, convention="flexion-positive", payloads=(Payload(2.0, 0.35),)
    )
    files = [shutil.copy(DATA / f"{name}.csv", tmp_path / f"{name}.csv") for name in ("train_1", "train_2", "verify")]
    first, second, third = map(type(tmp_path), files)
    workspace.add_file(first, first.name, told=told)
    workspace.add_file(second, second.name, told=StatedMapping(join=((str(third), 0.25),), passive=("knee",)))
    workspace.add_file(third, third.name, VERIFY)
    workspace.add_effect(OWN)
    workspace.change_history(lambda history: history.add("rub:knee", "stribeck:hip").undo())
    workspace.verdicts[frozenset(["rub:knee"])] = VERDICT
    yield workspace
    workspace.close()


def test_a_saved_session_holds_everything_that_was_said(full, tmp_path):
    folder = save(full, tmp_path / "kept")
    again = Workspace(tmp_path / "mappings")
    reopen(again, folder)
    assert again.verdict == VERDICT and again.history == full.history and again.own_texts == full.own_texts
    assert (again.seed, again.cutoff, again.derivative) == (3, 4.5, "savgol")
    for old, new in zip(full.given, again.given, strict=True):
        assert (new.name, new.role, replace(new.told, join=old.told.join)) == (old.name, old.role, old.told)
        assert new.path.read_bytes() == old.path.read_bytes() and new.path.is_relative_to(folder)
    ((joined, lag),) = again.given[1].told.join
    assert joined.startswith(str(folder)) and lag == 0.25
    again.use_as(3, "fit")
    assert again.verdict is None  # other recordings: it does not hold any more
    again.close()


def _outside(content):
    content["recordings"][0]["file"] = "../train_1.csv"


def _unknown_effect(content):
    content["history"]["steps"][1]["layers"][0]["name"] = "rub:elbow"


def _half_a_verdict(content):
    del content["verdicts"][0]["found"]["sentence"]


def _endless_seed(content):
    content["seed"] = float("inf")


def _negative_seed(content):
    content["seed"] = -5


def _no_cutoff(content):
    content["cutoff"] = float("nan")


def _endless_place(content):
    content["history"]["at"] = float("inf")


def _brackets(content):
    for _ in range(900):
        content["own_effects"] = [content["own_effects"]]


@pytest.mark.parametrize(
    ("spoil", "why"),
    [
        (_outside, "outside"),
        (_unknown_effect, "elbow"),
        (_half_a_verdict, "sentence"),
        (_endless_seed, "seed"),
        (_negative_seed, "seed"),
        (_no_cutoff, "cut-off"),
        (_endless_place, "infinity"),
        (_brackets, "no session"),
    ],
)
def test_a_session_that_was_spoilt_is_refused_as_a_whole(full, tmp_path, spoil, why):
    folder = save(full, tmp_path / "kept")
    content = json.loads((folder / "session.json").read_text(encoding="utf-8"))
    spoil(content)
    (folder / "session.json").write_text(json.dumps(content), encoding="utf-8")
    again = Workspace(tmp_path / "mappings")
    with pytest.raises(RecordingError, match=why):
        reopen(again, folder)
    assert again.given == [] and again.own == {} and again.keeping.folder is None
    again.close()


def test_the_command_says_what_was_said(full):
    words = shlex.split(commands(full)["cli"])
    args = verb_parser("compare").parse(words[2:])
    assert args.map == [{"q1": "A", "q2": "B"}] and args.units == [{"q": "deg"}]
    assert args.cutoff == 4.5 and args.derivative == "savgol" and args.seed == 3
    assert [text.partition("=")[2] for text in (*args.convention, *args.passive, *args.payload)] == [
        "flexion-positive", "knee", "shank:2@0.35",
    ]  # fmt: skip
    assert args.join[0].endswith("@0.25") and args.model == "model.toml"


def test_the_python_says_what_was_said(full):
    text = commands(full)["python"]
    compile(text, "session", "exec")
    for part in ("'q1': 'A'", "flexion-positive", ".with_payload(2.0, 0.35", "passive=('knee',)", "cutoff=4.5"):
        assert part in text


def test_code_is_exported_once_there_are_numbers(full):
    with pytest.raises(RecordingError, match="no format"):
        exported(full, "fortran")
    with pytest.raises(RecordingError, match="no numbers yet"):
        exported(full, "numpy")


def test_a_misspelt_word_of_a_torque_is_no_number(full):
    entry = {"id": "other", "torque": "c * dthta", "coefficients": {"c": {}, "dthta": {}}}
    with pytest.raises(ExoidError, match="unknown name 'dthta'") as refused:
        full.add_effect(entry)
    assert refused.value.where.splitlines()[-1].index("^") == refused.value.where.splitlines()[-2].index("dthta")
