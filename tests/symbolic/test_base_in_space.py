"""An arm on a base that moves in space: confirmed by Lagrange in the program, and by Pinocchio's free flyer here."""

from dataclasses import replace

import numpy as np
import pytest

from exoid.diagnosis.comparison import compare
from exoid.ground.errors import RecordingError
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.measurement.reading.names import recognise
from exoid.measurement.reading.read import read_recording
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.check import check_equations
from exoid.symbolic.force import FIXED, Force
from exoid.symbolic.model import model_of, read_model
from exoid.symbolic.model_file import Numbers, write_model
from exoid.symbolic.motion import Motion
from exoid.symbolic.robot_file import parse_robot
from exoid.symbolic.spatial_machine import spatial_machine
from exoid.workbench.export import numpy as numpy_export
from exoid.workbench.identified import Options, ready
from tests.exported_module import python_module
from tests.symbolic.arms import arm_text

TEXT = arm_text(7, 4, ("revolute", "revolute", "prismatic"))
STILL = model_of(spatial_machine(parse_robot(TEXT.encode())).model)
ARM = replace(STILL, moving_base=True)
SHORT = replace(model_of(spatial_machine(parse_robot(arm_text(6, 3).encode())).model), moving_base=True)


def motion_of(model, seed=0, count=12):
    rng = np.random.default_rng(seed)
    q, dq, ddq = (rng.normal(size=(count, len(model.joints))) for _ in range(3))
    force = rng.normal(size=(count, len(model.channels))) if model.forces else None
    return Motion(np.arange(count) * 0.01, q, dq, ddq, base=rng.normal(size=(count, 12)), force=force)


def inertial_of(pin, robot, model):
    """The base parameters of Pinocchio's own links."""
    numbers = []
    for joint in model.joints:
        own = robot.inertias[robot.getJointId(joint.name)]
        tensor = own.inertia + own.mass * (own.lever @ own.lever * np.eye(3) - np.outer(own.lever, own.lever))
        numbers.append([*tensor[np.triu_indices(3)], *(own.mass * own.lever), own.mass])
    return np.einsum("pjk,jk->p", model.mixture, numbers)


@pytest.mark.slow
def test_the_torque_is_that_of_a_free_flyer():
    pin = pytest.importorskip("pinocchio")
    robot = pin.buildModelFromXML(TEXT, pin.JointModelFreeFlyer())
    data, motion = robot.createData(), motion_of(ARM)
    numbers = np.concatenate([inertial_of(pin, robot, ARM), np.zeros(2 * len(ARM.joints))])
    found = ARM.torque(motion, numbers)
    for k, state in enumerate(motion.base):
        angles, rates, turning, carried = state[:3], state[3:6], state[6:9], state[9:]
        turned = pin.rpy.rpyToMatrix(*angles)
        to_rate = pin.rpy.computeRpyJacobian(angles, pin.LOCAL)
        changing = pin.rpy.computeRpyJacobianTimeDerivative(angles, rates, pin.LOCAL)
        place = np.concatenate([np.zeros(3), pin.Quaternion(turned).coeffs(), motion.q[k]])
        speed = np.concatenate([np.zeros(3), to_rate @ rates, motion.dq[k]])
        faster = np.concatenate([turned.T @ carried, to_rate @ turning + changing @ rates, motion.ddq[k]])
        wanted = pin.rnea(robot, data, place, speed, faster)[6:]
        np.testing.assert_allclose(found[k], wanted, rtol=1e-9, atol=1e-9)


@pytest.mark.slow
def test_a_base_that_rests_is_none_and_more_of_the_first_link_is_seen_otherwise():
    still = replace(motion_of(STILL), base=None)
    resting = replace(still, base=np.zeros((len(still), 12)))
    own = [np.einsum("pjk,jk->p", m.mixture, np.random.default_rng(2).normal(size=(4, 10))) for m in (STILL, ARM)]
    both = [m.torque(on, np.concatenate([phi, np.zeros(8)]))
            for m, on, phi in zip((STILL, ARM), (still, resting), own, strict=True)]  # fmt: skip
    np.testing.assert_allclose(*both, rtol=1e-9, atol=1e-9)
    assert len(ARM.inertial) > len(STILL.inertial)


@pytest.mark.slow
def test_the_equations_are_checked():
    model = ARM.with_forces(Force("hand", "j3", ("a", "b", "c"), (0.1, 0.0, 0.2), FIXED))
    checks = check_equations(model)
    assert all(check.holds for check in checks), [str(check) for check in checks]


def test_a_model_file_says_that_the_base_is_measured(tmp_path):
    path = write_model(ARM, tmp_path / "arm.toml")
    assert 'motion = "measured"' in path.read_text(encoding="utf-8") and read_model(path).moving_base


def test_columns_of_a_base_are_known_by_their_usual_names():
    for name, meant in {"base_roll": "base_roll", "pelvis pitch [deg]": "base_pitch", "base_ay": "base_ay"}.items():
        assert recognise(name, ARM.joints).name == meant
    assert recognise("pelvis pitch").name == "base_angle", "of a leg"


@pytest.mark.slow
def test_numbers_of_an_arm_on_a_moving_base_are_found_again(tmp_path):
    runs = simulate_runs(2, SHORT, seed=4, bench=Bench(duration=20.0))
    recordings = [run.recording for run in runs]
    assert recordings[0].base.shape[1] == 6 and "base_yaw" in recordings[0].columns()
    fit = identify(SHORT, recordings, optimisers=(), physical=True)
    assert fit.certificate.holds
    for estimate, true in zip(fit.estimates, runs[0].true.linear, strict=True):
        assert estimate.low - 0.03 * abs(true) - 5e-3 < true < estimate.high + 0.03 * abs(true) + 5e-3, estimate
    path = tmp_path / "run.csv"
    recordings[0].to_frame().to_csv(path, index=False)
    again = read_recording(path, joints=SHORT.joints)
    np.testing.assert_allclose(again.base, recordings[0].base)
    fixed = replace(SHORT, moving_base=False)
    assert np.all(compare(fixed, recordings).fit.rms > 1.4 * fit.rms), "as if the base stood still"
    assert any("the base turns" in str(one) for one in prepare(fixed, recordings).findings)
    with pytest.raises(RecordingError, match="no base_roll, base_pitch, base_yaw"):
        prepare(SHORT, [replace(recordings[0], base=None)])


def test_exported_code_takes_the_base(tmp_path):
    values = np.linspace(0.2, 1.0, len(ARM.parameters))
    numbers = dict(zip([p.name for p in ARM.parameters], map(float, values), strict=True))
    text = numpy_export.write(ready(ARM, Numbers(numbers, {}, None)), Options(name="arm"))["arm.py"]
    motion = motion_of(ARM)
    found = python_module(text, tmp_path, "arm").torque(motion.t, motion.q, motion.dq, motion.ddq, motion.base)
    wanted = ARM.torque(motion, np.array([*numbers.values()]))
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9)
