"""The folder of a contest that somebody else handed on leads nowhere."""

from __future__ import annotations

from pathlib import Path

import pytest

from exoid import workbench
from exoid.workbench.command import main

DEMO = Path(workbench.__file__).parent / "demo_data"


@pytest.mark.parametrize("part", ["runs", "ioh"])
def test_the_runs_of_a_contest(part, plant, tmp_path, capsys):
    plant(tmp_path / "out" / part)
    small = ["--only", "nfo", "--seeds", "2", "--generations", "2", "--individuals", "4", "--jobs", "1", "--quiet"]
    assert main(["rivals", str(DEMO / "train_1.csv"), *small, "--out", str(tmp_path / "out")]) == 2
    assert "Traceback" not in capsys.readouterr().err
