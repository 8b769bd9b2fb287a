"""Recordings of blind trials made worse as real machines are."""

import numpy as np
import pytest

from diagnosis.trials.cases import Case, cases
from diagnosis.trials.machines import LEFT, MACHINES, TIMES
from measurement.bench.simulation import Bench, simulate_runs

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
