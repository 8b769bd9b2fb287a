"""`--join`: which file belongs to which recording."""

import pytest
from recordings_of_a_leg import written

from exoid.workbench.command import main
from exoid.workbench.command_line.inputs import joins_of
from exoid.workbench.command_line.parser import UsageError


def test_files_find_their_recordings():
    assert joins_of(["b.csv@0.5", "c.csv"], ["a.csv"]) == {"a.csv": [("b.csv", 0.5), ("c.csv", None)]}
    two = joins_of(["x.csv", "y.csv@-1e-3"], ["a.csv", "b.csv"])
    assert two == {"a.csv": [("x.csv", None)], "b.csv": [("y.csv", -1e-3)]}
    assert joins_of(["b.csv=x@y.csv@2"], ["runs/a.csv", "runs/b.csv"])["runs/b.csv"] == [("x@y.csv", 2.0)]
    with pytest.raises(UsageError, match="nothing says to which"):
        joins_of(["x.csv"], ["a.csv", "b.csv"])
    with pytest.raises(UsageError, match="not a lag"):
        joins_of(["x.csv@inf"], ["a.csv"])


def test_joined_files_are_compared_and_the_lag_is_said(tmp_path, capsys):
    motion = written(tmp_path / "motion.csv", "t,q1,q2", ("t", "q1", "q2"))
    torque = written(tmp_path / "torque.csv", "t,tau1,tau2", ("t", "tau1", "tau2"))
    assert main(["compare", str(motion), "--join", f"{torque}@0"]) == 0
    assert "given lag of 0 s" in capsys.readouterr().err
    assert main(["compare", str(motion), "--quiet"]) == 2
