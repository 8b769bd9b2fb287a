"""Recordings of machines with any number of joints: columns by number or by name, units by kind of joint."""

import numpy as np
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement import read_recording
from exoid.measurement.reading.names import recognise
from exoid.measurement.recording import Recording, write_recording
from exoid.symbolic.joints import LEG, Joint

DRIVE = (Joint("drive"),)
SLIDE = (Joint("stage", "prismatic"),)
LEG3 = (Joint("hip", length=0.4), Joint("knee", length=0.4), Joint("ankle"))
LEGS = (
    Joint("left_hip", length=0.4), Joint("left_knee"), Joint("right_hip", length=0.4, parent="base"),
    Joint("right_knee"),
)  # fmt: skip
T = np.arange(0.0, 12.0, 0.01)


def signals(count, seed=0):
    """Return smooth angles and torques (N, count) that differ from joint to joint."""
    rng = np.random.default_rng(seed)
    q = np.column_stack([0.6 * np.sin((0.9 + 0.3 * k) * T + k) for k in range(count)])
    return q, 5.0 * np.roll(q, 40, axis=0) + 0.05 * rng.standard_normal(q.shape)


def table(joints, q_name, tau_name):
    q, tau = signals(len(joints))
    columns = {"t": T}
    for k, joint in enumerate(joints):
        columns[q_name.format(k + 1, joint.name)] = q[:, k]
        columns[tau_name.format(k + 1, joint.name)] = tau[:, k]
    return columns


@pytest.mark.parametrize("joints", [DRIVE, SLIDE, LEG3, LEGS], ids=["drive", "slide", "leg3", "legs"])
@pytest.mark.parametrize(
    "names",
    [("q{0}", "tau{0}"), ("q_{1}", "tau_{1}"), ("{1} position", "{1} effort"), ("/js/{1}/pos", "/js/{1}/torque")],
)
def test_columns_are_found_by_number_and_by_name(joints, names):
    q, tau = signals(len(joints))
    run = read_recording(table(joints, *names), joints=joints)
    assert run.joints == joints
    assert np.allclose(run.q, q) and np.allclose(run.tau, tau)


def test_one_joint_need_not_be_named():
    q, tau = signals(1)
    run = read_recording({"t": T, "q": q[:, 0], "tau": tau[:, 0]}, joints=SLIDE)
    assert np.allclose(run.q, q) and np.allclose(run.tau, tau)
    run = read_recording({"time": T, "position [mm]": 1e3 * q[:, 0], "force [N]": tau[:, 0]}, joints=SLIDE)
    assert np.allclose(run.q, q) and np.allclose(run.tau, tau)


def test_units_are_those_of_the_kind_of_joint():
    joints = (Joint("boom", length=0.5), Joint("reach", "prismatic"))
    q, tau = signals(2)
    columns = {"t": T, "q_boom": np.degrees(q[:, 0]), "q_reach": 1e3 * q[:, 1], "tau1": tau[:, 0], "tau2": tau[:, 1]}
    run = read_recording(columns, units={"q": "deg", "q_reach": "mm"}, joints=joints)
    assert np.allclose(run.q, q)
    assert run.to_xarray()["q2"].attrs["units"] == "m" and run.to_xarray()["tau2"].attrs["units"] == "N"
    with pytest.raises(RecordingError, match="unit 'deg'"):
        read_recording(columns, units={"q2": "deg"}, joints=joints)
    mapped = read_recording(
        {"t": T, "a": q[:, 0], "b": q[:, 1], "tau1": tau[:, 0], "tau2": tau[:, 1]}, {"q_boom": "a", "q2": "b"},
        joints=joints,
    )  # fmt: skip
    assert np.allclose(mapped.q, q)


def test_a_slide_is_not_unwrapped():
    q = np.where(T < 6.0, 0.0, 2 * np.pi) + 0.3 * np.sin(T)
    tau = np.sin(2.0 * T)
    assert np.ptp(read_recording({"t": T, "q": q, "tau": tau}, joints=SLIDE).q) > 6.0
    assert np.ptp(read_recording({"t": T, "q": q, "tau": tau}, joints=DRIVE).q) < 1.0


def test_as_many_joints_as_the_file_has_where_nobody_says():
    for count in (1, 3):
        q, tau = signals(count)
        columns = (
            {"t": T} | {f"q{k + 1}": q[:, k] for k in range(count)} | {f"tau{k + 1}": tau[:, k] for k in range(count)}
        )
        assert read_recording(columns).q.shape == (len(T), count)
    q, tau = signals(2)
    assert read_recording({"t": T, "q1": q[:, 0], "q2": q[:, 1], "tau1": tau[:, 0], "tau2": tau[:, 1]}).joints is LEG
    with pytest.raises(RecordingError, match="no column for tau2"):
        read_recording({"t": T, "q1": q[:, 0], "tau1": tau[:, 0], "knee_angle": q[:, 1]})


def test_a_missing_joint_is_named():
    columns = table(LEG3, "q_{1}", "tau_{1}")
    del columns["tau_ankle"]
    with pytest.raises(RecordingError, match="no column for tau3"):
        read_recording(columns, joints=LEG3)


def test_names_of_joints_are_no_fillers_nor_sides():
    assert recognise("drive_torque", DRIVE).name == "tau1"
    assert recognise("hip_flexion_r", LEGS).name == "q3"
    assert recognise("left_knee_moment", LEGS).name == "tau2"
    assert recognise("q5", LEGS) is None


@pytest.mark.parametrize(
    "names",
    [("A", "a"), ("theta", "tau"), ("q_hip", "hip"), ("q2", "q1"), ("knee_left", "left_knee"), ("roll", "double")],
)
def test_a_column_called_as_the_model_writes_its_joint_is_that(names):
    first, second = (Joint(name, length=0.3) for name in names)
    for number, name in enumerate(names, 1):
        for quantity in ("q", "dq", "ddq", "tau", "f"):
            meant = recognise(f"{quantity}_{name}", (first, second))
            assert meant is not None and meant.name == f"{quantity}{number}", (quantity, name)


@pytest.mark.slow
def test_written_and_read_again(tmp_path):
    q, tau = signals(3)
    run = Recording("three", T, q, tau, joints=LEG3).with_passive("ankle")
    assert run.passive == ("ankle",)
    again = read_recording(write_recording(run, tmp_path / "three.csv"), joints=LEG3)
    assert np.array_equal(again.q, run.q) and np.array_equal(again.tau, run.tau)
    assert "hip" in run.plot().axes[0].get_legend().get_texts()[0].get_text()
