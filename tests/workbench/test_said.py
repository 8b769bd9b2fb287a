"""What the command line says of many files that are alike: each thing once, repairs in one line."""

from __future__ import annotations

import numpy as np
import pytest

from exoid.workbench.command import main

T = np.arange(1200) * 0.01


@pytest.fixture
def files(tmp_path):
    """Three recordings, each with a cell that is no number and a clock in ms."""
    for k in range(3):
        q = [np.sin(T + k), np.sin(1.3 * T + k)]
        columns = np.column_stack([1000 * T, *q, 3 * np.cos(T + k), 2 * np.cos(1.3 * T)])
        lines = [",".join(f"{x:.6g}" for x in row) for row in columns]
        lines[50 + k] = lines[50 + k].rpartition(",")[0] + ",lost"
        (tmp_path / f"run_{k}.csv").write_text("\n".join(["t,q1,q2,tau1,tau2", *lines, ""]), encoding="utf-8")
    return [str(tmp_path / f"run_{k}.csv") for k in range(3)]


@pytest.mark.slow
def test_repairs_are_one_line_gone_when_quiet_and_whole_when_verbose(files, capsys):
    def repairs(*options):
        assert main(["compare", *files, *options]) == 0
        return [line for line in capsys.readouterr().err.splitlines() if line.startswith("exoid: repaired")]

    (line,) = repairs()
    assert "the clock was read in ms" in line and "alike in 2 more files" in line and "--units t=s" in line
    assert repairs("--quiet") == []
    assert len(repairs("--verbose")) == 6
