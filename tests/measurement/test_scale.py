"""Factors of torques that no leg agrees with."""

import numpy as np
import pytest
from tables import leg

from exoid.measurement.auditing.scale import check_scales
from exoid.measurement.reading.read import read_recording


def recording(hip=1.0, knee=1.0, seed=1):
    columns = leg(3000, seed=seed)
    return read_recording({**columns, "tau1": hip * columns["tau1"], "tau2": knee * columns["tau2"]})


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_torques_of_one_leg_are_left_alone(seed):
    assert not check_scales([recording(seed=seed)])
    assert not check_scales([recording(hip=3.0, knee=3.0, seed=seed)])
    assert not check_scales([recording(knee=1 / 4, seed=seed)])  # a wrong gain is no gear


@pytest.mark.parametrize(("hip", "knee"), [(1.0, 1 / 6), (1.0, 50.0), (1.0, 1 / 60), (1 / 20, 1.0)])
def test_the_factor_that_the_leg_wants_is_said(hip, knee):
    (found,) = check_scales([recording(hip, knee)])
    assert found.value == pytest.approx(hip / knee, rel=0.25)
    assert "--units tau2=Nm*" in found.remedy


def test_noise_is_no_factor():
    columns = leg(3000)
    rng = np.random.default_rng(0)
    columns["tau2"] = rng.normal(size=3000)
    assert not check_scales([read_recording(columns)])
