"""Recordings of blind trials made worse as real machines are."""

import numpy as np
import pytest

from exoid.apps.campaign.trials.cases import Case, cases
from exoid.apps.campaign.trials.count import right
from exoid.apps.campaign.trials.machines import CONVENTIONS, LEFT, MACHINES, TIMES, kept_in, without_knee_drive
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.measurement.reading.conventions import read_as

RUNS = simulate_runs(4, seed=1, bench=Bench(duration=6.0))


@pytest.mark.parametrize("kind", MACHINES)
def test_a_kind_changes_recordings_and_not_their_form(kind):
    changed = MACHINES[kind](RUNS, np.random.default_rng(0))
    assert len(changed) == len(RUNS)
    for now, before in zip(changed, RUNS, strict=True):
        assert now.recording.tau.shape == before.recording.tau.shape and np.isfinite(now.recording.tau).all()
    assert any(not np.array_equal(a.recording.tau, b.recording.tau) for a, b in zip(changed, RUNS, strict=True))


def test_model_error_is_smooth_and_another_one_in_every_run():
    added = [
        now.recording.tau - before.recording.tau
        for now, before in zip(MACHINES["rough"](RUNS, np.random.default_rng(0)), RUNS, strict=True)
    ]
    for one in added:
        assert LEFT * TIMES[0] <= one.std(axis=0).max() * 1.001 and one.std(axis=0).max() <= LEFT * TIMES[1] * 1.001
        assert np.abs(np.diff(one, axis=0)).max() < 0.2 * one.std()
    assert abs(np.corrcoef(added[0][:, 0], added[1][:, 0])[0, 1]) < 0.9


def test_a_locked_knee_still_carries_the_shank():
    run = MACHINES["locked"](RUNS, np.random.default_rng(0))[1]
    assert np.ptp(run.motion.q[:, 1]) == 0.0 and np.ptp(run.recording.q[:, 1]) < 2e-3
    assert run.torque[:, 1].std() > 0.5


def test_each_kind_is_part_of_a_campaign():
    names = [case.name for case in cases(list(MACHINES), 1)]
    assert {Case.named(name).kind for name in names} == set(MACHINES)


def test_recordings_in_another_convention_are_the_same_once_they_are_read_rightly():
    for name in CONVENTIONS:
        for run, before in zip(kept_in(name, RUNS), RUNS, strict=True):
            assert not np.allclose(run.recording.q, before.recording.q) or "torque" in name
            np.testing.assert_allclose(read_as(run.recording, name).q, before.recording.q, atol=1e-12)


def test_a_trial_of_conventions_is_right_only_with_the_option_that_helps():
    line = {"kind": "convention", "case": "convention/flexion-positive/3", "verdict": "check_channels"}
    assert right({**line, "next": "first give --convention flexion-positive"})
    assert not right({**line, "next": "first give --convention swapped-joints"})
    assert not right({**line, "verdict": "adequate", "next": ""})


def test_a_knee_without_a_drive_gives_no_torque():
    leg = without_knee_drive(standard_leg())
    run = simulate_runs(1, None, leg, seed=3, bench=Bench(duration=4.0))[0]
    assert np.abs(run.torque[:, 1]).max() < 1e-6 < np.abs(run.torque[:, 0]).max()
    assert np.ptp(run.motion.q[:, 1]) > 0.1
