"""A motion survives the disk, and a wrong file is refused in words."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exoid.measurement.trajectories.trajectory import TrajectoryError, paper_trajectory
from exoid.measurement.trajectories.trajectory_file import read_trajectory, sample_table, write_trajectory

GOOD = """period = 10.0
[hip]
offset = 0.6
sine = [0.1, 0.2]
cosine = [0.0, 0.1]
[knee]
offset = -0.9
sine = [0.1, 0.2]
cosine = [0.0, 0.1]
"""


def test_round_trip(tmp_path):
    path = write_trajectory(paper_trajectory(), tmp_path / "motion.toml")
    back = read_trajectory(path)
    np.testing.assert_array_equal(back.sine, paper_trajectory().sine)
    np.testing.assert_array_equal(back.offset, paper_trajectory().offset)
    assert back.period == 10.0


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("period = 10.0", "", "period is missing"),
        ("period = 10.0", "period = -1", "out of range"),
        ("[knee]", "[ankle]", "unknown key 'ankle'"),
        ("sine = [0.1, 0.2]\ncosine = [0.0, 0.1]\n[knee]", "cosine = [0.0, 0.1]\n[knee]", "sine is missing"),
        ("sine = [0.1, 0.2]\ncosine = [0.0, 0.1]\n[knee]", "sine = [0.1]\ncosine = [0.0]\n[knee]", "harmonics"),
        ("offset = 0.6", "offset = '0.6'", "not a number"),
        ("offset = 0.6", "offset = nan", "not finite"),
        ("[hip]", "[hip", "not valid TOML"),
        ("sine = [0.1, 0.2]", "sine = []", "harmonics"),
    ],
)
def test_a_wrong_file_is_refused(tmp_path, old, new, message):
    path = tmp_path / "motion.toml"
    path.write_text(GOOD.replace(old, new, 1))
    with pytest.raises(TrajectoryError, match=message):
        read_trajectory(path)


@settings(max_examples=60, deadline=None)
@given(st.binary(max_size=200))
def test_no_bytes_crash_the_reader(tmp_path_factory, data):
    path = tmp_path_factory.mktemp("motion") / "motion.toml"
    path.write_bytes(data)
    with pytest.raises(TrajectoryError):
        read_trajectory(path)


def test_samples_are_a_whole_loop():
    lines = sample_table(paper_trajectory(), 50.0).splitlines()
    assert lines[0] == "t,q1,q2,dq1,dq2,ddq1,ddq2" and len(lines) == 501
    values = np.array([[float(x) for x in line.split(",")] for line in lines[1:]])
    motion = paper_trajectory().at(np.append(values[:, 0], values[-1, 0] + 0.02))
    next_one = np.column_stack([motion.q, motion.dq, motion.ddq])[-1]
    np.testing.assert_allclose(values[0, 1:], next_one, atol=1e-8)
    motion = paper_trajectory().at(values[:, 0])
    np.testing.assert_allclose(values[:, 1:3], motion.q, atol=1e-8)


def test_a_loop_that_would_jump_is_refused():
    with pytest.raises(TrajectoryError, match="no whole number"):
        sample_table(paper_trajectory(9.777), 100.0)
    with pytest.raises(TrajectoryError, match="too many"):
        sample_table(paper_trajectory(), 1e9)
