"""`exoid rivals`: what it shows, writes and refuses."""

from __future__ import annotations

import json

import pytest

from exoid.optimisation.optimisers import optimisers
from exoid.workbench.command import main

SMALL = ["rivals", "--seeds", "2", "--individuals", "8", "--generations", "4", "--jobs", "1"]


@pytest.mark.slow
def test_it_compares_on_the_virtual_bench_and_goes_on_where_it_was(tmp_path, capsys):
    assert main([*SMALL, "--out", str(tmp_path)]) == 0
    shown = capsys.readouterr().out
    assert "nfo_whitened" in shown and "certified optimum" in shown
    page = (tmp_path / "report.html").read_text("utf-8")
    assert "Optimisers compared" in page and "cma_es" in page
    assert (tmp_path / "ioh" / "pso" / "IOHprofiler_f1_huber.json").is_file()
    found = json.loads((tmp_path / "result.json").read_text("utf-8"))
    assert found["schema"] == "exoid.rivals/1"
    assert set(found["optimisers"]) >= {"nfo", "nfo_whitened", "pso", "ga", "de", "cma_es"}
    assert found["certificate"]["holds"]
    assert main([*SMALL, "--out", str(tmp_path), "--json", "-"]) == 0
    again = json.loads(capsys.readouterr().out)
    assert again["resumed"] == 12
    assert again["optimisers"] == found["optimisers"]


@pytest.mark.slow
def test_it_compares_on_recordings(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["simulate", "--runs", "1", "--duration", "10", "--out", ".", "--quiet"]) == 0
    assert main([*SMALL, "run_0.csv", "--only", "nfo", "de_whitened", "--json", "-"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert set(found["optimisers"]) == {"nfo", "de_whitened"}
    assert "run_0" in found["problem"]


@pytest.mark.slow
@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        (["--seeds", "1"], "run-to-run variation"),
        (["--only", "nfx"], "there is no optimiser called 'nfx'"),
        (["--model", "leg.toml"], "--model is about recordings"),
        (["--individuals", "2"], "at least 4 individuals"),
        (["nowhere.csv"], "there is no such file"),
    ],
)
def test_bad_input_is_told(arguments, said, capsys):
    assert main(["rivals", *arguments]) == 2
    assert said in capsys.readouterr().err


def test_its_optimisers_join_those_of_the_core():
    assert {"nfo", "cma_es", "pso", "ga", "de"} <= {*optimisers()}


@pytest.mark.slow
def test_the_command_compares_motions(tmp_path, capsys):
    small = ["--seeds", "2", "--individuals", "8", "--generations", "4", "--jobs", "1"]
    chosen = ["--only", "nfo", "cma_es_penalty", "--out", str(tmp_path)]
    assert main(["rivals", "--problem", "excitation", *small, *chosen]) == 0
    shown = capsys.readouterr().out
    assert "best motion known" in shown and "IPOPT" in shown
    assert (tmp_path / "ioh" / "nfo" / "IOHprofiler_f1_condition.json").is_file()


def test_recordings_do_not_belong_to_motions(capsys):
    assert main(["rivals", "run.csv", "--problem", "excitation"]) == 2
    assert "motions compete on a model alone" in capsys.readouterr().err
