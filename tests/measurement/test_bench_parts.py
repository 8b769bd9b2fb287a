"""Legs, motions, controller and instruments of the bench, each on its own."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exoid.ground.errors import ExoidError
from exoid.measurement.bench.controller import Controller
from exoid.measurement.bench.leg import Leg, LegError, Segment, paper_leg, random_leg, standard_leg
from exoid.measurement.bench.sensors import Sensors
from exoid.measurement.trajectories.trajectory import (
    Fourier,
    TrajectoryError,
    largest_scale,
    paper_trajectory,
    random_trajectory,
    within,
)
from exoid.symbolic.model_structure import TABLE_1


@given(seed=st.integers(0, 2**32 - 1), period=st.floats(4.0, 20.0), harmonics=st.integers(1, 10))
def test_random_motion_stays_inside_table_1_between_the_samples_too(seed, period, harmonics):
    motion = random_trajectory(np.random.default_rng(seed), period=period, harmonics=harmonics, use=1.0)
    fine = motion.at(np.linspace(0.0, period, 20_011))
    for j, limit in enumerate(TABLE_1.values()):
        assert fine.q[:, j].min() >= limit.angle[0] and fine.q[:, j].max() <= limit.angle[1]
        assert np.abs(fine.dq[:, j]).max() <= limit.velocity
        assert np.abs(fine.ddq[:, j]).max() <= limit.acceleration


def test_rescaling_reaches_a_limit_and_is_idempotent():
    motion = within(random_trajectory(np.random.default_rng(1)))
    assert largest_scale(motion) == pytest.approx([1.0, 1.0], abs=1e-9)


def test_derivatives_of_the_series_match_differences():
    t = np.linspace(0.0, 10.0, 20_001)
    motion = paper_trajectory().at(t)
    assert np.gradient(motion.q, t, axis=0)[1:-1] == pytest.approx(motion.dq[1:-1], abs=1e-6)
    assert np.gradient(motion.dq, t, axis=0)[1:-1] == pytest.approx(motion.ddq[1:-1], abs=1e-5)


def test_the_published_motion_touches_the_lower_knee_limit_and_no_other():
    motion = paper_trajectory(period=10.0).at(np.linspace(0.0, 10.0, 20_001))
    assert motion.q[:, 1].min() == pytest.approx(-1.62, abs=0.005)
    assert np.abs(motion.ddq[:, 0]).max() == pytest.approx(4.04, abs=0.01)
    assert largest_scale(paper_trajectory(period=8.0))[0] < 1.0 < largest_scale(paper_trajectory(period=9.5))[0]


def test_a_centre_outside_the_limits_is_refused():
    outside = Fourier(np.array([2.0, -1.0]), np.ones((2, 1)), np.ones((2, 1)), 10.0)
    with pytest.raises(TrajectoryError, match=r"hip: the motion's centre 2 rad lies outside"):
        largest_scale(outside)


def test_standard_leg_carries_the_lumped_numbers_of_its_segments():
    leg = standard_leg()
    assert leg.thigh is not None and leg.shank is not None
    assert leg.base[2] == pytest.approx(leg.shank.mass * 0.40 * leg.shank.com)
    total = leg.base[0] - leg.base[1] + leg.base[3]  # coefficient of (g / a) sin θ1, shank's own pull aside
    assert total == pytest.approx(leg.thigh.mass * leg.thigh.com * 0.40 + leg.shank.mass * 0.40**2)


@given(seed=st.integers(0, 2**32 - 1), knee=st.floats(-3.2, 3.2))
def test_random_legs_can_exist(seed, knee):
    leg = random_leg(np.random.default_rng(seed))
    assert np.linalg.eigvalsh(leg.mass_matrix(knee)).min() > 0
    assert min(leg.base[4:]) > 0


def test_the_papers_leg_is_the_published_one():
    assert paper_leg().base[:4] == (25.14, 7.42, 1.43, -10.42)


def test_impossible_legs_are_refused():
    with pytest.raises(LegError, match="not positive definite"):
        Leg("no leg", (0.1, 0.4, 0.3, 0.2, 1.0, 1.0, 1.0, 1.0), (10.0, 10.0))
    with pytest.raises(LegError, match="must be positive"):
        Leg.of("no leg", Segment(-1.0, 0.2, 0.1), Segment(1.0, 0.2, 0.1), (1.0, 1.0, 1.0, 1.0))


def test_controller_gains_scale_with_inertia():
    leg = standard_leg()
    slow, fast = (Controller(bandwidth=(f, f)).gains(leg) for f in (2.0, 4.0))
    assert fast[0] == pytest.approx(4.0 * slow[0])
    assert fast[1] == pytest.approx(2.0 * slow[1])
    with pytest.raises(ExoidError, match="must be positive"):
        Controller(damping=0.0)


def test_ideal_sensors_change_nothing():
    rng, x = np.random.default_rng(0), np.linspace(0.0, 1.0, 200).reshape(100, 2)
    ideal = Sensors.ideal()
    assert np.array_equal(ideal.angle(x, rng), x)
    assert np.array_equal(ideal.torque(x, 100.0, rng), x)
    assert np.array_equal(ideal.clock(x[:, 0], rng), x[:, 0])


def test_encoder_reads_whole_steps_and_torque_noise_has_its_size():
    rng, still = np.random.default_rng(0), np.full((20_000, 2), 0.3)
    steps = Sensors().angle(still, rng) / Sensors().resolution
    assert steps == pytest.approx(np.round(steps), abs=1e-6)
    plain = Sensors(outlier_share=0.0, burst_rate=0.0).torque(still, 100.0, rng) - still
    assert plain.std() == pytest.approx(0.5, rel=0.03)
    outliers = np.abs(Sensors(torque_noise=0.0, burst_rate=0.0).torque(still, 100.0, rng) - still) > 0
    assert outliers.mean() == pytest.approx(0.06, abs=0.005)


def test_bursts_are_short_and_rare():
    tau = Sensors(torque_noise=0.0, outlier_share=0.0).torque(np.zeros((6_000, 2)), 100.0, np.random.default_rng(3))
    assert 0.002 < (np.abs(tau) > 0).mean() < 0.05
    assert np.abs(tau).max() <= 6.0 * 3


def test_jitter_keeps_time_increasing():
    t = np.arange(1_000) * 0.01
    logged = Sensors(jitter=0.02).clock(t, np.random.default_rng(0))
    assert np.all(np.diff(logged) > 0) and np.abs(logged - t).max() <= 0.004 + 1e-12


def test_impossible_sensors_are_refused():
    with pytest.raises(ExoidError, match="torque_noise = -1"):
        Sensors(torque_noise=-1.0)
    with pytest.raises(ExoidError, match="outlier share above"):
        Sensors(outlier_share=0.9)


def test_the_logger_keeps_a_fixed_number_of_decimals():
    assert Sensors(decimals=3).logged(np.array([1.23456, -0.0001])).tolist() == [1.235, 0.0]
    assert Sensors(decimals=3).logged(np.array([1.23456]), fewer=2).tolist() == [1.2]
    assert Sensors.ideal().logged(np.array([1.23456])).tolist() == [1.23456]
