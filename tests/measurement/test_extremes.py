"""The bound between samples holds, and the limits of the paper's motion are what they are."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exoid.measurement.trajectories.extremes import bounds, margin, shortest_period, uses
from exoid.measurement.trajectories.trajectory import Fourier, TrajectoryError, paper_trajectory
from exoid.symbolic.model_structure import TABLE_1

coefficients = st.lists(st.floats(-1.0, 1.0), min_size=20, max_size=20)


@settings(max_examples=60, deadline=None)
@given(coefficients, st.integers(11, 60))
def test_no_motion_leaves_the_proven_bounds(values, grid):
    a = np.array(values).reshape(2, 2, 5)
    motion = Fourier(np.array([0.5, -0.9]), a[0], a[1], 7.0)
    everywhere = motion.at(np.linspace(0.0, 7.0, 4001))
    for use in uses(motion, grid=grid):
        j = 0 if use.joint == "hip" else 1
        signal = {"angle": everywhere.q, "velocity": everywhere.dq, "acceleration": everywhere.ddq}[use.quantity][:, j]
        assert use.low <= signal.min() + 1e-9 and signal.max() - 1e-9 <= use.high


def test_the_bound_is_sharp_for_a_cosine_between_grid_points():
    grid = 40
    shift = np.pi * 5 / grid  # its peaks fall in the middle between points
    cosine, sine = np.zeros((2, 5)), np.zeros((2, 5))
    cosine[0, 4], sine[0, 4] = np.cos(shift), np.sin(shift)
    angle = uses(Fourier(np.zeros(2), sine, cosine, 1.0), grid=grid)[0]
    assert angle.high == pytest.approx(1.0, rel=1e-9)


def test_too_few_points_prove_nothing():
    with pytest.raises(TrajectoryError, match="cannot bound"):
        margin(5, 10)


def test_the_papers_motion_keeps_table_1_from_nine_and_a_half_seconds():
    assert shortest_period(paper_trajectory()) == pytest.approx(9.51, abs=0.01)
    assert all(use.holds for use in uses(paper_trajectory(9.52)))
    assert [f"{u.joint} {u.quantity}" for u in uses(paper_trajectory(9.4)) if not u.holds] == ["knee velocity"]
    pull = next(u for u in uses(paper_trajectory()) if (u.joint, u.quantity) == ("hip", "acceleration"))
    assert max(pull.high, -pull.low) == pytest.approx(4.04, abs=0.01)


def test_an_angle_outside_is_helped_by_no_period():
    wide = paper_trajectory().scaled(np.array([2.0, 1.0]))
    assert shortest_period(wide) == float("inf")


def test_a_share_of_the_limits_shrinks_about_the_middle():
    room = bounds(TABLE_1, 0.5)
    np.testing.assert_allclose(room[0], [0.565 - 0.3475, 0.565 + 0.3475, 0.96, 2.58])
