"""A machine whose base moves and is measured: recordings are read, fitted with its motion, and diagnosed."""

from __future__ import annotations

import copy
from dataclasses import replace

import numpy as np
import pytest

from exoid.ground.errors import EffectError, RecordingError
from exoid.measurement.bench.machine import standard_machine
from exoid.measurement.bench.simulation import Bench, run_bench
from exoid.measurement.reading.names import recognise
from exoid.measurement.reading.read import read_recording
from exoid.measurement.recording import write_recording
from exoid.optimisation.excitation.design import design
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model

PACK = Model("backpack", limits={}, joints=(Joint("hip", length=0.42), Joint("knee")), moving_base=True)
FIXED = replace(PACK, moving_base=False)


@pytest.fixture(scope="module")
def run():
    return run_bench(PACK, bench=Bench(duration=15.0), seed=4)


def test_the_bench_moves_the_base_and_its_torque_is_that_of_the_model(run):
    assert run.motion.base.shape == (len(run.motion), 5) and np.ptp(run.recording.base[:, 0]) > 0.05
    np.testing.assert_allclose(run.true.torque(run.motion), run.torque, atol=1e-6)
    still = replace(run.motion, base=None)
    assert np.abs(run.true.torque(still) - run.torque).max() > 0.5, "what the base does is felt at the joints"


@pytest.mark.slow
def test_the_numbers_are_those_of_the_machine_and_without_the_base_they_are_not(run):
    truth = np.array(standard_machine(PACK).base)
    fit, blind = (
        identify(model, prepare(model, [run.recording]).train, optimisers=()) for model in (PACK, FIXED)
    )
    np.testing.assert_allclose(fit.linear[:4], truth[:4], rtol=0.1, atol=0.01)
    assert np.all(fit.rms < 0.6 * blind.rms)


def test_a_recording_goes_to_a_file_and_back_with_its_base(run, tmp_path):
    path = write_recording(run.recording, tmp_path / "run.csv")
    again = read_recording(path, joints=PACK.joints)
    np.testing.assert_array_equal(again.base, run.recording.base)
    text = path.read_text().splitlines()
    head = text[0].replace("base_angle", "backpack tilt [deg]")
    path.write_text("\n".join([head, *text[1:]]))
    np.testing.assert_allclose(read_recording(path, joints=PACK.joints).base[:, 0], np.radians(again.base[:, 0]))


@pytest.mark.parametrize(
    ("name", "meaning"),
    [("base_angle", "base_angle"), ("base_angle_deg", "base_angle"), ("Backpack Tilt", "base_angle"),
     ("base_ax", "base_ax"), ("base_az_m_s2", "base_az"), ("base/angle", "base_angle")],
)  # fmt: skip
def test_columns_of_the_base(name, meaning):
    assert recognise(name).name == meaning


def test_a_recording_without_the_base_is_refused_and_a_base_that_nobody_asked_for_is_told(run):
    with pytest.raises(RecordingError, match="no base_angle"):
        prepare(PACK, [replace(run.recording, base=None)])
    (found,) = [f for f in prepare(FIXED, [run.recording]).findings if f.check == "base"]
    assert "stands still" in found.what and "measured" in found.remedy


def test_what_takes_the_base_to_stand_still_says_so():
    with pytest.raises(EffectError, match="that of this model is measured"):
        design(PACK)


def test_a_leg_of_the_usual_length_may_hang_from_a_measured_base():
    model = Model("leg", limits={}, joints=(Joint("hip", length=0.4), Joint("knee")), moving_base=True)
    again = copy.copy(model)  # as in another process
    for one in (model, again, replace(model, name="other")):
        assert one.moving_base and one.chain and one.chain[0].length == 0.4
    assert Model(moving_base=True, thigh_length=0.37).chain[0].length == 0.37
