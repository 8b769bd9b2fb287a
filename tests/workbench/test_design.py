"""`exoid design` from the command line."""

from __future__ import annotations

import json

import pytest

from exoid.workbench.command import main

FAST = ["--starts", "0"]


def run(*words):
    return main(["design", *words])


@pytest.mark.slow
def test_files_and_json(tmp_path, capsys):
    out = tmp_path / "motion"
    assert run(*FAST, "--out", str(out), "--json", str(tmp_path / "d.json"), "--rest", "--rate", "50") == 0
    names = {p.name for p in out.iterdir()}
    assert {"motion.csv", "motion.png", "motion.toml", "report.html", "result.json"} <= names
    assert len((out / "motion.csv").read_text().splitlines()) == 501
    payload = json.loads((tmp_path / "d.json").read_text())
    assert payload["schema"] == "exoid.design/1" and payload["feasible"] and payload["condition"] < 80
    assert run("--check", str(out / "motion.toml"), "--quiet") == 0
    simulate = ["simulate", "--trajectory", str(out / "motion.toml"), "--runs", "1", "--duration", "4"]
    assert main([*simulate, "--out", str(tmp_path / "runs"), "--quiet"]) == 0
    capsys.readouterr()


def test_limits_that_cannot_be_met_are_status_one(capsys):
    assert run("--check", "paper", "--period", "9") == 1
    assert "leaves its limits" in capsys.readouterr().out
    assert run("--check", "paper", "--period", "10") == 0
    assert run("--check", "paper", "--target", "60") == 1
    assert run("--printed", "--starts", "0") == 1
    assert "nothing to follow" in capsys.readouterr().err


def test_look_alikes_are_status_one(capsys):
    assert run("--separate", "drive_gain:hip,drive_gain:knee") == 1
    said = capsys.readouterr().out
    assert "no motion can distinguish them" in said and "A known mass added at a known place" in said


@pytest.mark.slow
def test_rivals_with_recordings(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    making = "simulate --effect viscous_quadratic:knee=3 --runs 1 --duration 20 --seed 5 --out runs --quiet"
    assert main(making.split()) == 0
    words = "--separate viscous_quadratic:knee,viscous_cubic:knee runs/run_0.csv --generations 6 --json - --out sep"
    run(*words.split())
    payload = json.loads(capsys.readouterr().out)
    assert payload["schema"] == "exoid.separation/1" and payload["present"] and payload["at_random"]
    assert payload["noise"]["source"].startswith("the residual of the recordings")
    assert {r["source"] for r in payload["rivals"]} <= {
        "fitted to the recordings", "typical size, since its fit has a sign it cannot have",
    }  # fmt: skip
    assert (tmp_path / "sep" / "motion.toml").exists()


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["a.toml", "b.toml"], "2 models"),
        (["--free", "--middle"], "exclude each other"),
        (["--separate", "a,b", "--check", "paper"], "exclude each other"),
        (["--separate", "stribeck:hip,stribeck:knee", "leg.toml"], "--model leg.toml"),
        (["--separate", "stribeck:hip"], "two different effects"),
        (["--check", "nowhere.toml"], "cannot be read"),
        (["--out", "x", "--period", "9.777"], "no whole number"),
        (["--harmonics", "0"], "1 to 20 harmonics"),
        (["--separate", "stribeck:hip,viscous_cubic:hip", "--duration", "0.5"], "too short"),
        (["--use", "2"], "of the limits"),
        (["--criterion", "best"], "invalid choice"),
    ],
)
def test_bad_input_is_status_two(words, message, capsys):
    assert run(*words) == 2
    assert message in capsys.readouterr().err
