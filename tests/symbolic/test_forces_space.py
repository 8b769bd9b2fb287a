"""Measured forces and wrenches on arms in space: by virtual work, by Newton and Euler, and by Pinocchio."""

from dataclasses import replace

import numpy as np
import pytest

from exoid.diagnosis.comparison import compare
from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.diagnosis.hypotheses.channels import doubts_before
from exoid.ground.errors import EffectError
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.measurement.forces import usual_forces
from exoid.measurement.reading.names import recognise
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.check import check_equations
from exoid.symbolic.force import FIXED, LINK, NORMAL, TORQUE, Force
from exoid.symbolic.model import Model, model_of, read_model
from exoid.symbolic.model_file import Numbers, write_model
from exoid.symbolic.motion import Motion
from exoid.symbolic.robot_file import parse_robot
from exoid.symbolic.spatial_machine import spatial_machine
from exoid.workbench.export import numpy as numpy_export
from exoid.workbench.identified import Options, ready
from tests.exported_module import python_module
from tests.symbolic.arms import arm_text

TEXT = arm_text(7, 4, ("revolute", "revolute", "prismatic"))
ARM = model_of(spatial_machine(parse_robot(TEXT.encode())).model)
WRENCH = tuple(f"wrench_{what}_{axis}" for what in ("force", "torque") for axis in "xyz")
FLANGE = Force("flange", "j3", WRENCH, (0.1, 0.2, -0.05), rpy=(0.3, -0.2, 1.0))


def motion_of(model, seed=0, count=12):
    rng = np.random.default_rng(seed)
    states = (rng.normal(size=(count, len(model.joints))) for _ in range(3))
    return Motion(np.arange(count) * 0.01, *states, force=rng.normal(size=(count, len(model.channels))))


@pytest.mark.slow
@pytest.mark.parametrize("columns", [WRENCH[:3], WRENCH], ids=["force", "wrench"])
@pytest.mark.parametrize("frame", [LINK, FIXED])
@pytest.mark.parametrize("link", ["j2", "j3"])
def test_the_torque_is_that_of_pinocchios_jacobian(link, frame, columns):
    pin = pytest.importorskip("pinocchio")
    force = replace(FLANGE, link=link, columns=columns, frame=frame)
    model = ARM.with_forces(force)
    motion = motion_of(model)
    found = model.torque(motion, np.zeros(len(model.parameters)))
    robot = pin.buildModelFromXML(TEXT)
    sensor = pin.SE3(pin.rpy.rpyToMatrix(*force.rpy), np.array(force.at))
    place = robot.addFrame(pin.Frame("sensor", robot.getJointId(link), sensor, pin.FrameType.OP_FRAME))
    axes, data = pin.LOCAL if frame == LINK else pin.LOCAL_WORLD_ALIGNED, robot.createData()
    for k in range(len(motion)):
        jacobian = pin.computeFrameJacobian(robot, data, motion.q[k], place, axes)[: len(columns)]
        np.testing.assert_allclose(found[k], -jacobian.T @ motion.force[k], rtol=1e-9, atol=1e-9)


@pytest.mark.slow
def test_newton_and_euler_confirm_virtual_work_also_behind_a_wrong_zero():
    model = ARM.with_forces(FLANGE, Force("about", "j1", ("interaction_torque_j1",), frame=TORQUE))
    checks = [check for check in check_equations(model) if check.name == "measured forces"]
    assert len(checks) == 2 and all(check.holds for check in checks), [str(check) for check in checks]
    off = ARM.with_forces(FLANGE).with_effect("encoder_offset:j0")
    motion = motion_of(off)
    shifted = replace(motion, q=motion.q + np.array([0.2, 0.0, 0.0, 0.0]))
    numbers = np.zeros(len(off.parameters))
    plain = ARM.with_forces(FLANGE).torque(shifted, np.zeros(len(ARM.parameters)))
    both = [off.torque(motion, numbers, np.array([sign * 0.2])) for sign in (1.0, -1.0)]
    assert min(np.abs(one - plain).max() for one in both) < 1e-12


@pytest.mark.slow
def test_the_gain_may_be_a_number_of_the_model_and_the_sign_turned():
    known, open_ = (ARM.with_forces(replace(FLANGE, gain=gain, sign=-1)) for gain in (1.7, None))
    motion = motion_of(known)
    numbers = np.zeros(len(open_.parameters))
    numbers[[p.name for p in open_.parameters].index("flange.gain")] = 1.7
    wanted = known.torque(motion, np.zeros(len(known.parameters)))
    np.testing.assert_allclose(open_.torque(motion, numbers), wanted)
    plain = ARM.with_forces(FLANGE).torque(motion, np.zeros(len(ARM.parameters)))
    np.testing.assert_allclose(wanted, -1.7 * plain)


def test_a_model_file_says_where_the_sensor_is(tmp_path):
    model = ARM.with_forces(FLANGE, Force("hand", "j2", ("a", "b", "c"), frame=FIXED, gain=None))
    assert read_model(write_model(model, tmp_path / "arm.toml")).forces == model.forces


def test_what_belongs_to_a_plane_or_to_space_is_refused_elsewhere():
    for model, force, match in (
        (ARM, Force("cuff", "j1", ("f1",)), "are a force in a plane"),
        (Model.standard(), replace(FLANGE, link="knee"), "are a force in space"),
        (ARM, replace(FLANGE, at=0.3), "at is 0.3"),
        (ARM, Force("about", "j1", ("m",), (0.0, 0.0, 0.1), frame=TORQUE), "at is"),
    ):
        with pytest.raises(EffectError, match=match):
            model.with_forces(force)
    with pytest.raises(EffectError, match="5 columns"):
        Force("flange", "j3", WRENCH[:5], frame=LINK)
    with pytest.raises(EffectError, match="at is"):
        Force("flange", "j3", WRENCH, (0.0, 0.0, 9.0))
    with pytest.raises(EffectError, match="rpy is"):
        replace(FLANGE, rpy=(0.0, "a", 0.0))


def test_columns_of_a_force_torque_sensor_are_known_by_their_usual_names():
    for name, meant in {
        "wrench.force.x": "wrench_force_x", "ft_sensor_torque_z": "wrench_torque_z", "Fy [N]": "wrench_force_y",
        "flange_fz": "wrench_force_z", "Mx": "wrench_torque_x", "tcp_force_y": "wrench_force_y",
    }.items():  # fmt: skip
        assert recognise(name, ARM.joints).name == meant, name
    assert recognise("Fx", Model.standard().joints).name == "grf_x"
    assert usual_forces((*WRENCH, "f1", "grf_z"), ARM.joints) == (), "nobody knows where it sits"
    assert NORMAL not in {one.frame for one in usual_forces(("interaction_torque_j1",), ARM.joints)}


def fitted(model, recordings):
    prepared = prepare(model, recordings)
    return fitted_model(identify(model, prepared.train, optimisers=()), prepared)


@pytest.mark.slow
def test_recordings_of_a_pushed_arm_are_explained_by_their_sensor():
    model = ARM.with_forces(FLANGE)
    runs = [run.recording for run in simulate_runs(2, model, seed=3, bench=Bench(duration=12.0))]
    assert {*WRENCH} <= {*runs[0].forces}
    with_it, without = compare(model, runs), compare(ARM, runs)
    assert "in the frame of j3" in with_it.forces[0].sentence and with_it.forces[0].at == FLANGE.at
    assert np.all(with_it.fit.rms < 0.5 * without.fit.rms)
    doubt = doubts_before(fitted(ARM.with_forces(replace(FLANGE, sign=-1)), runs))
    assert "counts the other way round" in doubt.sentence and "along the axes" in doubt.sentence
    assert "wrench_torque_x=-Nm" in doubt.remedy and doubts_before(fitted(model, runs)) is None


def test_exported_code_takes_the_wrench(tmp_path):
    model = ARM.with_forces(FLANGE)
    rng = np.random.default_rng(1)
    numbers = dict(zip([p.name for p in model.parameters], map(float, rng.random(len(model.parameters))), strict=True))
    text = numpy_export.write(ready(model, Numbers(numbers, {}, None)), Options(name="arm"))["arm.py"]
    motion = motion_of(model)
    module = python_module(text, tmp_path, "arm")
    found = module.torque(motion.t, motion.q, motion.dq, motion.ddq, motion.force)
    wanted = model.torque(motion, np.array([*numbers.values()]))
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9)
