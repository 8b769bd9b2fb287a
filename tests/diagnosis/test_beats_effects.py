"""What is said of the channels has to beat the machine with its best effects."""

import pytest

from exoid.diagnosis.comparison import compare
from exoid.diagnosis.discovery import discover
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.symbolic.model import Model

HIDDEN = {"cross_coulomb": 8.0, "cross_viscous": 4.0}


@pytest.mark.slow
def test_friction_of_a_drive_at_the_base_is_named_and_no_convention_accused():
    given = simulate_runs(3, effects=[f"{k}={v}" for k, v in HIDDEN.items()], seed=3, bench=Bench(duration=15.0))
    runs = [one.recording for one in given]
    assert compare(Model.standard(), runs[:2], runs[2:]).misread  # another reading explains more than the bare model
    found = discover(Model.standard(), runs[:2], runs[2:])
    assert found.verdict == "missing" and {one.name for one in found.accepted} == set(HIDDEN)
    model = Model.standard().with_effect("cross_coulomb").with_effect("cross_viscous")
    assert not compare(model, runs[:2], runs[2:]).misread
