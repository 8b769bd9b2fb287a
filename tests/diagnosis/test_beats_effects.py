"""What is said of the channels has to beat the machine with its best effects."""

from dataclasses import replace

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


@pytest.mark.slow
def test_a_knee_counted_the_other_way_is_no_set_of_effects_though_these_leave_about_the_noise():
    runs = [run.recording for run in simulate_runs(4, Model.standard(), seed=1)]
    flipped = [replace(run, q=run.q * [1, -1], tau=run.tau * [1, -1]) for run in runs]
    found = discover(Model.standard(), flipped[:3], flipped[3])
    assert found.verdict == "check_channels" and not found.accepted
    assert "--convention flexion-positive" in found.next_experiment
    assert "option" not in found.to_json()["audit"][0]  # the remedy says it
