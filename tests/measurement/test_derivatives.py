"""Three ways to differentiate: right on clean motion, together on noisy one, refused where there are no periods."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.measurement.recording import Recording
from exoid.measurement.signals.conditioning import noise_density, uniform_sampling
from exoid.measurement.signals.derivatives import METHODS, find_period, fourier, savgol
from exoid.measurement.trajectories.trajectory import random_trajectory
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import Model
from exoid.workbench.command import main

LIMITS = Model.standard().limits


def played(period=8.0, seconds=30.0, rate=100.0, noise=0.0, seed=0):
    path = random_trajectory(np.random.default_rng(seed), LIMITS, period=period)
    motion = path.at(np.arange(0.0, seconds, 1.0 / rate))
    q = motion.q + noise * np.random.default_rng(seed).standard_normal(motion.q.shape)
    return motion, Recording("played", motion.t, q, np.zeros_like(q))


@pytest.mark.parametrize("period", [5.0, 8.0, 10.013, 14.9])
def test_the_period_is_found(period):
    _, recording = played(period, noise=1e-4)
    assert find_period(uniform_sampling(recording)) == pytest.approx(period, abs=2e-3)


def test_one_period_is_none():
    _, recording = played(period=20.0)
    assert find_period(uniform_sampling(recording)) is None


def test_a_fourier_series_is_differentiated_exactly():
    motion, recording = played()
    q, dq, ddq, periods = fourier(uniform_sampling(recording), 8.0, "x")
    assert periods == pytest.approx(30.0 / 8.0, abs=0.01)
    for found, wanted in ((q, motion.q), (dq, motion.dq), (ddq, motion.ddq)):
        np.testing.assert_allclose(found, wanted, atol=2e-5)


def test_local_cubics_come_close():
    motion, recording = played()
    _, dq, ddq, _ = savgol(uniform_sampling(recording), 8.0, "x")
    inside = slice(50, -50)
    np.testing.assert_allclose(dq[inside], motion.dq[inside], atol=5e-3)
    np.testing.assert_allclose(ddq[inside], motion.ddq[inside], atol=0.15)


def test_averaging_periods_takes_noise_away():
    motion, recording = played(noise=1e-3)
    even = uniform_sampling(recording)
    errors = [np.std(method(even, 8.0, "x")[2][100:-100] - motion.ddq[100:-100]) for method in (fourier, savgol)]
    assert errors[0] < 0.7 * errors[1]


def test_motion_that_does_not_repeat_is_refused():
    motion, recording = played()
    wander = replace(recording, q=motion.q + 0.05 * np.sin(0.37 * motion.t)[:, None])
    for one in (wander, played(period=20.0)[1]):
        with pytest.raises(RecordingError, match="repeat"):
            prepare(Model.standard(), [one], cutoff=5.0, derivative="fourier")


def test_a_name_that_is_none_is_refused():
    with pytest.raises(RecordingError, match="spline"):
        prepare(Model.standard(), [played()[1]], derivative="spline")


@pytest.mark.slow
@pytest.mark.parametrize("method", METHODS)
def test_all_give_the_leg(method):
    recordings = [r.recording for r in simulate_runs(2, None, standard_leg(), seed=6, bench=Bench(duration=25.0))]
    prepared = prepare(Model.standard(), recordings, derivative=method)
    fit = identify(Model.standard(), prepared.train, optimisers=())
    assert prepared.derivative == method
    np.testing.assert_allclose(fit.linear[:3], standard_leg().base[:3], rtol=0.06)


@pytest.mark.slow
def test_from_the_command_line(tmp_path, capsys):
    assert main(["simulate", "--runs", "1", "--duration", "21", "--out", str(tmp_path), "--quiet"]) == 0
    assert main(["identify", str(tmp_path / "run_0.csv"), "--derivative", "fourier", "--quiet"]) == 0
    assert main(["simulate", "--runs", "1", "--duration", "9", "--out", str(tmp_path / "b"), "--quiet"]) == 0
    assert main(["identify", str(tmp_path / "b" / "run_0.csv"), "--derivative", "fourier", "--quiet"]) == 2
    assert "does not repeat" in capsys.readouterr().err


@pytest.mark.parametrize("seconds", [6.0, 20.0, 60.0])
def test_the_noise_of_angles_is_not_underestimated_in_short_recordings(seconds):
    found = []
    for seed in range(20):
        noise = 1e-4 * np.random.default_rng(seed).standard_normal((round(100.0 * seconds), 2))
        t = np.arange(len(noise)) / 100.0
        found.append(noise_density(uniform_sampling(Recording("", t, noise, noise))))
    assert np.mean(found) == pytest.approx(2.0 * 1e-8 / 100.0, rel=0.1)
