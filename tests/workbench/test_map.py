"""`exoid map`, the file it keeps, and what other commands make of it."""

import json

import pytest
from recordings_of_a_leg import COLUMNS, written

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.mapping import FILE, MOST_BYTES, remembered
from exoid.measurement.reading.read import read_recording
from exoid.workbench.command import main

HEADER = "Zeit,A1,A2,M1,M2"
TOLD = ["--map", "q1=A1,q2=A2,tau1=M1,tau2=M2", "--units", "q=deg"]


@pytest.fixture
def run(tmp_path):
    return written(tmp_path / "run.csv", HEADER, degrees=True)


def test_a_mapping_is_kept_and_used_for_the_next_file_and_said(run, tmp_path, capsys):
    assert main(["map", str(run), *TOLD]) == 0
    assert str(tmp_path / FILE) in capsys.readouterr().out
    following = written(tmp_path / "next.csv", HEADER, degrees=True)
    recording = read_recording(following)
    said = [f for f in recording.findings if f.check == "mapping"]
    assert said and "q1=A1" in said[0].what and FILE in said[0].what
    assert 1.0 < abs(recording.q).max() < 2.0  # degrees
    assert main(["compare", str(following), "--quiet"]) == 0
    assert "q1=A1" in capsys.readouterr().err


def test_what_is_given_by_hand_comes_first_and_other_headers_are_left_alone(run, tmp_path):
    main(["map", str(run), *TOLD, "--quiet"])
    assert abs(read_recording(run, units={"q": "mrad"}).q).max() < 0.2
    other = written(tmp_path / "other.csv", HEADER + ",x", [*COLUMNS, "q1"])
    with pytest.raises(RecordingError, match="no column for q1"):
        read_recording(other)


def test_it_is_never_overwritten_silently(run, tmp_path, capsys):
    assert main(["map", str(run), *TOLD]) == 0
    (tmp_path / FILE).write_text("# mine\n" + (tmp_path / FILE).read_text())
    before = (tmp_path / FILE).read_text()
    assert main(["map", str(run), *TOLD]) == 0 and (tmp_path / FILE).read_text() == before
    other = [*TOLD[:-1], "q=rad"]
    assert main(["map", str(run), *other]) == 2
    assert "--replace" in capsys.readouterr().err and (tmp_path / FILE).read_text() == before
    assert main(["map", str(run), *other, "--replace"]) == 0
    assert (tmp_path / FILE).read_text().startswith("# mine")
    assert remembered(tmp_path, HEADER.split(",")).units == {"q": "rad"}


def test_without_a_terminal_what_is_open_names_the_option(run, tmp_path, capsys):
    assert main(["map", str(run)]) == 2
    assert "--map q1=" in capsys.readouterr().err and not (tmp_path / FILE).exists()
    assert main(["map", str(run), "--map", "q1=nowhere"]) == 2


def test_on_a_terminal_it_asks(run, tmp_path, monkeypatch, capsys):
    answers = iter(["2", "deg", "A2", "deg", "4", "", "M2", ""])
    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    monkeypatch.setattr("builtins.input", lambda question: next(answers))
    assert main(["map", str(run)]) == 0
    kept = remembered(tmp_path, HEADER.split(","))
    assert kept.columns == {"q1": "A1", "q2": "A2", "tau1": "M1", "tau2": "M2"}
    assert kept.units == {"q1": "deg", "q2": "deg"}


def test_the_json_says_what_was_kept(run, tmp_path):
    target = tmp_path / "map.json"
    assert main(["map", str(run), *TOLD, "--json", str(target), "--quiet"]) == 0
    content = json.loads(target.read_text())
    assert content["schema"] == "exoid.mapping/1" and content["columns"]["tau2"] == "M2"


def test_the_leg_is_kept_too(tmp_path, capsys):
    header = "t," + ",".join(f"{side}_{what}" for side in ("left", "right") for what in
                             ("hip_angle", "knee_angle", "hip_torque", "knee_torque"))  # fmt: skip
    run = written(tmp_path / "run.csv", header, [*COLUMNS, *COLUMNS[1:]])
    assert main(["compare", str(run), "--quiet"]) == 2
    assert "--leg left" in capsys.readouterr().err
    assert main(["map", str(run), "--leg", "right", "--quiet"]) == 0
    assert read_recording(run).name == "run"
    assert main(["compare", str(run), "--leg", "both", "--json", str(tmp_path / "a.json"), "--quiet"]) == 0


@pytest.mark.parametrize(
    "content",
    [
        "not = [toml",
        "recordings = 3",
        "[[recordings]]\nheader = 4",
        "[[recordings]]\nheader = ['a']\nevil = 1",
        "[[recordings]]\nheader = ['a']\ncolumns = { q1 = 3 }",
        "[[recordings]]\nheader = ['a']\nleg = 'middle'",
        "a = " + "[" * 5000,
        "#" * (MOST_BYTES + 1),
        "[[recordings]]\nheader = ['Zeit', 'A1', 'A2', 'M1', 'M2']\ncolumns = { '__class__' = 'A1' }",
        "[[recordings]]\nheader = ['Zeit', 'A1', 'A2', 'M1', 'M2']\nunits = { q = '9**9**9' }",
    ],
)
def test_a_hostile_file_is_refused_by_name(run, tmp_path, content):
    (tmp_path / FILE).write_text(content)
    with pytest.raises(RecordingError):
        read_recording(run, columns={"q1": "A1", "q2": "A2", "tau1": "M1", "tau2": "M2"})
    assert (tmp_path / FILE).read_text() == content


def test_the_columns_of_another_machine_are_those_of_its_model(tmp_path, capsys):
    recording, model = tmp_path / "run.csv", tmp_path / "bench.toml"
    recording.write_text("t,Enc,Nm\n" + "".join(f"{k / 100},{k % 9},{k % 7}\n" for k in range(50)), encoding="utf-8")
    model.write_text('[[joints]]\nname = "axis"\n', encoding="utf-8")
    told = ["map", str(recording), "--map", "q1=Enc,tau1=Nm", "--quiet"]
    assert main([*told, "--model", str(model)]) == 0
    assert (tmp_path / "exoid.toml").is_file()
    assert main([*told, "--replace"]) == 2  # of the leg, it lacks a knee
    assert "q2" in capsys.readouterr().err
