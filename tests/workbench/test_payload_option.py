"""--payload: known masses named on the command line."""

import json
import re

import pytest

from exoid.symbolic.mechanics.payload import PayloadError
from exoid.symbolic.model import Model
from exoid.workbench.command import main
from exoid.workbench.command_line.inputs import payload_of, payloads
from exoid.workbench.command_line.parser import UsageError

PATHS = ["a/run.csv", "b/run.csv", "b/x=1.csv"]


def test_recordings_are_named_by_path_or_by_name_alone():
    found = payloads(["a/run.csv=2@0.35", "x=1.csv=thigh:1@0.2", "a/run.csv=1e0@.1"], PATHS)
    assert {k: [str(p) for p in v] for k, v in found.items()} == {
        "a/run.csv": ["shank:2@0.35", "shank:1@0.1"],
        "b/x=1.csv": ["thigh:1@0.2"],
    }
    assert payloads([], PATHS) == {}


@pytest.mark.parametrize(
    ("text", "word"),
    [
        ("run.csv=2@0.35", "more than one"),
        ("c.csv=2@0.35", "none of the recordings"),
        ("2@0.35", "not FILE=KG@M"),
        ("a/run.csv=2", "not KG@M"),
        ("a/run.csv=two@0.35", "not KG@M"),
        ("a/run.csv=2@0.35@1", "not KG@M"),
        ("", "not FILE=KG@M"),
    ],
)
def test_a_mistake_is_explained(text, word):
    with pytest.raises(UsageError, match=word):
        payloads([text], PATHS)


def test_units_and_links_are_checked():
    for text, word in (
        ("2@350", "m from"),
        (":2@0.3", "thigh or shank"),
        ("-1@0.2", "kg"),
    ):
        with pytest.raises(PayloadError, match=word):
            payload_of(text)
    with pytest.raises(PayloadError, match="thigh or shank"):
        payload_of("foot:2@0.3").added(Model.standard())


@pytest.fixture(scope="module")
def swung(tmp_path_factory):
    """Recordings of a leg without a load, and some with 3 kg on the shank 0.35 m below the knee."""
    folder = tmp_path_factory.mktemp("swung")
    for name, seed, load in (("bare", "5", ()), ("loaded", "6", ("--payload", "3@0.35"))):
        assert main(["simulate", "--runs", "2", "--duration", "15", "--seed", seed, *load, "--quiet",
                     "--out", str(folder / name)]) == 0  # fmt: skip
    return folder


@pytest.mark.slow
def test_a_load_of_which_only_the_link_is_known_is_weighed_and_placed(swung, tmp_path):
    # All of them are called run_0 or run_1: a load is that of a file, not of a name.
    files = [str(swung / part) for part in ("bare/run_0.csv", "loaded/run_0.csv", "bare/run_1.csv")]
    told = tmp_path / "answer.json"
    assert main(["discover", *files[:2], "--verify", files[2], "--payload", f"{files[1]}=shank", "--quiet",
                 "--json", str(told)]) == 0  # fmt: skip
    answer = json.loads(told.read_text())
    (one,) = answer["of_recordings"]
    assert answer["verdict"] == "adequate" and one["what"] == "carried_load" and one["joint"] == "shank"
    assert one["values"]["run_0"]["low"] < 3.0 < one["values"]["run_0"]["high"]
    assert one["place"]["value"] == pytest.approx(0.35, abs=0.02) and one["sentence"] in answer["sentence"]


@pytest.mark.parametrize(
    ("loads", "what"),
    [
        ((("bare/run_1.csv", "shank"),), "cannot be told from nothing|no mass on that link"),
        ((("bare/run_1.csv", "foot"),), "its links are thigh, shank"),
        ((("bare/run_0.csv", "shank"), ("bare/run_1.csv", "shank")), "without a load"),
        ((("bare/run_1.csv", "shank"), ("bare/run_1.csv", "thigh")), "unknown loads on two links"),
    ],
)
def test_a_load_that_nobody_can_weigh_is_refused_with_what_to_do(swung, capsys, loads, what):
    files = [str(swung / "bare/run_0.csv"), str(swung / "bare/run_1.csv")]
    told = [part for file, link in loads for part in ("--payload", f"{swung / file}={link}")]
    assert main(["compare", *files, *told, "--quiet"]) == 2
    assert re.search(what, capsys.readouterr().err)
