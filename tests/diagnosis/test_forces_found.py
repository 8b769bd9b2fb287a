"""Measured forces through compare and discover: found where they act, told, and doubted where they are turned round."""

import os
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from exoid.diagnosis.comparison import compare
from exoid.diagnosis.discovery import discover
from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.diagnosis.evidence.pushes import wanted_gains
from exoid.diagnosis.hypotheses.channels import doubts_before
from exoid.measurement.auditing.audit import audit
from exoid.measurement.bench.hidden import Hidden
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.measurement.bench.walk import Walk
from exoid.measurement.bench.wearer import Wearer
from exoid.measurement.forces import pushed_model
from exoid.measurement.reading.read import read_recording
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import Model, read_model

LEG = Model.standard()


@pytest.fixture(scope="module")
def worn():
    bench = Bench(duration=20.0, wearer=Wearer(reach=(0.28, 0.21)))
    return [run.recording for run in simulate_runs(3, seed=5, bench=bench)]


@pytest.fixture(scope="module")
def compared(worn):
    return compare(LEG, worn[:2], worn[2:])


def test_cuffs_are_found_where_they_are_and_leave_the_noise(compared):
    thigh, shank = compared.forces
    assert thigh.low - 0.01 < 0.28 < thigh.high + 0.01
    assert shank.low - 0.01 < 0.21 < shank.high + 0.01
    assert np.all(compared.verify_rms < 1.4 * compared.noise_floor)
    assert "along the link after the knee" in shank.sentence and shank.torque[1] > 0.5


def test_without_the_forces_the_error_is_far_above_the_noise(worn, compared):
    bare = [replace(one, forces={}) for one in worn]
    assert np.all(compare(LEG, bare[:2], bare[2:]).verify_rms > 4.0 * compared.verify_rms)


def test_what_is_used_is_told_as_data(compared):
    first = compared.to_json()["forces"][0]
    assert first["name"] == "thigh cuff" and first["columns"] == ["f1"] and 0.2 < first["at"] < 0.35


def fitted(recordings):
    model = pushed_model(LEG, recordings)
    prepared = prepare(model, recordings)
    return fitted_model(identify(model, prepared.train, optimisers=()), prepared)


@pytest.mark.parametrize("turned", ["f1", "f2"])
def test_a_force_that_is_turned_round_is_doubted_and_no_other(worn, turned):
    assert doubts_before(fitted(worn)) is None
    wrong = [replace(one, forces={**one.forces, turned: -one.forces[turned]}) for one in worn]
    base = fitted(wrong)
    doubt = doubts_before(base)
    assert doubt is not None and f"{turned}=-N" in doubt.remedy
    gains = {gain.force.columns[0]: gain.gain for gain in wanted_gains(base)}
    assert gains[turned] < -0.5


@pytest.mark.slow
def test_noise_of_measured_forces_is_no_flexible_drive():
    """The second derivative of the model's torque holds that of the forces' noise, which what is left holds too."""
    bench = Bench(duration=15.0, walk=Walk(), measured=("plate",))
    runs = [run.recording for run in simulate_runs(2, seed=7, bench=bench)]
    one = fitted(runs).prepared.train[0]
    again = one.noisier(np.random.default_rng(0))
    assert np.std(again.motion.force - one.motion.force, axis=0) == pytest.approx(bench.sensors.plate_noise, rel=0.25)


@pytest.mark.slow
def test_on_a_plate_that_was_not_tared_nothing_is_named():
    """35 N that are not there were a spring across both joints."""
    bench = Bench(duration=15.0, walk=Walk(), measured=("plate",))
    runs = [run.recording for run in simulate_runs(3, seed=7, bench=bench)]
    wrong = [replace(one, forces={**one.forces, "grf_z": one.forces["grf_z"] + 35.0}) for one in runs]
    told = [replace(one, findings=audit(one)) for one in wrong]
    answer = discover(LEG, told[:2], told[2:])
    assert answer.verdict == "check_channels" and not answer.accepted
    assert "not tared" in answer.sentence and "subtract 35" in answer.next_experiment


@pytest.mark.slow
def test_an_effect_is_found_beside_a_person_in_the_leg():
    bench = Bench(duration=30.0, wearer=Wearer())
    hidden = [Hidden("load_friction", "knee", size=0.25)]
    runs = [run.recording for run in simulate_runs(4, effects=hidden, seed=2, bench=bench)]
    found = discover(LEG, runs[:3], runs[3:])
    assert [one.name for one in found.accepted] == ["load_friction:knee"]


SHARED = Path(os.environ.get("EXOID_SHARED_DATA", "/nowhere")) / "practice_person"


@pytest.mark.slow
@pytest.mark.skipif(not SHARED.is_dir(), reason="EXOID_SHARED_DATA does not name the shared recordings")
@pytest.mark.parametrize("name", ["cuffs_a", "walk_grf_a"])
def test_practice_recordings_with_forces_leave_the_noise(name):
    model = read_model(SHARED / name / "model.toml")
    runs = [read_recording(path, joints=model.joints) for path in sorted((SHARED / name).glob("run_*.csv"))]
    found = compare(model, runs[:3], runs[3:])
    assert np.all(found.verify_rms <= 1.15 * found.noise_floor)


@pytest.mark.slow
def test_a_person_who_is_not_measured_is_no_noise(worn):
    answer = discover(LEG, [replace(one, forces={}) for one in worn])
    assert answer.verdict != "adequate"


@pytest.mark.slow
@pytest.mark.skipif(not SHARED.is_dir(), reason="EXOID_SHARED_DATA does not name the shared recordings")
@pytest.mark.parametrize(
    ("name", "verdict", "accepted"),
    [("walk_unmeasured", "unexplained", []), ("walk_switch", "missing", ["load_friction:knee"])],
)
def test_practice_walks_without_the_force_of_the_ground(name, verdict, accepted):
    model = read_model(SHARED / name / "model.toml")
    runs = [read_recording(path, joints=model.joints) for path in sorted((SHARED / name).glob("run_*.csv"))]
    assert not [one for run in runs for one in run.findings if one.severity == "warning" and one.check == "convention"]
    found = discover(model, runs[:3], runs[3:])
    assert (found.verdict, [one.name for one in found.accepted]) == (verdict, accepted)
