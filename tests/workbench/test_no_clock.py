"""Recordings without a clock, or with one that looks the same in every row."""

from __future__ import annotations

import numpy as np
import pytest
from recordings_of_a_leg import written

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.read import read_recording
from exoid.workbench.command import main


@pytest.fixture
def without(tmp_path):
    """A recording at 100 Hz without its time column."""
    run = written(tmp_path / "run.csv", "t,q1,q2,tau1,tau2")
    lines = [line.partition(",")[2] for line in run.read_text(encoding="utf-8").splitlines()]
    (tmp_path / "bare.csv").write_text("\n".join([*lines, ""]), encoding="utf-8")
    return run, tmp_path / "bare.csv"


def test_the_rate_is_asked_for_and_what_is_typed_works(without, capsys):
    run, bare = without
    assert main(["compare", str(bare)]) == 2
    assert "--rate 100" in capsys.readouterr().err
    assert main(["compare", str(bare), "--rate", "100", "--quiet"]) == 0
    whole, again = read_recording(run), read_recording(bare, rate=100.0)
    assert np.allclose(np.diff(again.t), 0.01) and np.array_equal(again.q, whole.q)
    with pytest.raises(RecordingError, match="of no recording"):
        read_recording(bare, rate=-5.0)


def test_a_clock_in_ms_is_shown_with_differing_digits(tmp_path, capsys):
    run = written(tmp_path / "run.csv", "t,q1,q2,tau1,tau2")
    head, *rows = run.read_text(encoding="utf-8").splitlines()
    late = [f"{1.7e12 + 1000 * float(row.split(',')[0]):.0f},{row.partition(',')[2]}" for row in rows]
    run.write_text("\n".join([head, *late, ""]), encoding="utf-8")
    from exoid.measurement.reading.read import open_table
    from exoid.workbench.commands.map import _show
    from exoid.workbench.terminal.screen import Screen

    _show(Screen(), open_table(run))
    line = next(line for line in capsys.readouterr().out.splitlines() if line.split()[1:2] == ["t"])
    low, _, high = line.split()[2:5]
    assert low != high and low.startswith("17000000")
