"""Angles and torques are valid each for itself: what is missing of one is missing of nothing else."""

import numpy as np
import pytest
from tables import leg

from exoid.measurement.reading.read import read_recording

NAMES = ("t", "q1", "q2", "tau1", "tau2")


def written(path, empty):
    """A table of the leg in which the cells of {name: (N,)} `empty` are empty."""
    columns = leg()
    rows = [",".join(NAMES)]
    for k in range(len(columns["t"])):
        cells = ("" if name in empty and empty[name][k] else repr(float(columns[name][k])) for name in NAMES)
        rows.append(",".join(cells))
    path.write_text("\n".join(rows) + "\n")
    return read_recording(path)


@pytest.mark.parametrize("rows", [1, 3, 50, 900])
def test_the_first_rows_may_be_without_torques(tmp_path, rows):
    first = np.arange(1500) < rows
    recording = written(tmp_path / "a.csv", {"tau1": first, "tau2": first})
    assert len(recording) == 1500 and recording.angle_valid.all()
    np.testing.assert_array_equal(recording.torque_valid, np.column_stack([~first, ~first]))


def test_most_of_a_torque_may_be_missing(tmp_path):
    stance = np.arange(1500) % 100 < 65
    recording = written(tmp_path / "a.csv", {"tau2": stance})
    assert recording.angle_valid.all() and recording.torque_valid[:, 0].all() and recording.valid.all()
    np.testing.assert_array_equal(recording.torque_valid[:, 1], ~stance)
    assert "975 rows masked" in repr(recording)
    assert any(one.check == "length" and "65%" in one.what for one in recording.findings)
    (said,) = [one for one in recording.findings if one.check == "cells"]
    assert "975 of 1500 cells of tau2" in said.what and "right column" in said.remedy


def test_a_missing_angle_loses_no_other_angle(tmp_path):
    gone = (np.arange(1500) > 300) & (np.arange(1500) < 340)
    recording = written(tmp_path / "a.csv", {"q2": gone})
    assert recording.angle_valid[:, 0].all() and recording.torque_valid.all()
    np.testing.assert_array_equal(recording.angle_valid[:, 1], ~gone)
