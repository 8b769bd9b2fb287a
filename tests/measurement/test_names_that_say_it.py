"""Names that say which column is what, as loggers in several languages and counting write them."""

from __future__ import annotations

import numpy as np
import pytest

from exoid.diagnosis.comparison import compare
from exoid.ground.errors import RecordingError
from exoid.measurement.reading.read import read_recording
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model

T = np.arange(800) * 0.01


def machine(*names):
    return tuple(Joint(name, length=0.4) for name in names)


def written(path, header, joints, scale=1.0, more=()):
    """Write t, q1, ..., tau1, ... (angles times `scale`) and further columns, under the names of `header`."""
    q = np.column_stack([np.sin((1.0 + 0.3 * k) * T) for k in range(joints)])
    tau = np.column_stack([3.0 * np.cos((0.9 + 0.3 * k) * T) for k in range(joints)])
    rows = np.column_stack([T, scale * q, tau, *more])
    lines = [header, *(",".join(f"{cell:.6g}" for cell in row) for row in rows)]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return q, tau


@pytest.mark.parametrize(
    ("header", "names"),
    [
        ("t,hip_deg,knee_deg,ankle_deg,hip_Nm,knee_Nm,ankle_Nm", ("hip", "knee", "ankle")),
        ("t,hip [deg],knee [deg],hip [Nm],knee [Nm]", ("hip", "knee")),
        ("Zeit [s],Istposition Hüfte [°],Istposition Knie [°],Drehmoment Hüfte,Drehmoment Knie", ("hip", "knee")),
        ("temps,angle hanche mesuré [deg],angle du genou [deg],couple hanche,couple genou", ("hip", "knee")),
        ("tiempo,ángulo cadera [deg],posición rodilla [deg],par cadera,par rodilla", ("hip", "knee")),
    ],
)
def test_a_joint_and_a_unit_or_a_word_of_another_language_say_it(tmp_path, header, names):
    q, tau = written(tmp_path / "run.csv", header, len(names), scale=57.29578)
    found = read_recording(tmp_path / "run.csv", joints=machine(*names))
    assert np.allclose(found.q, q, atol=1e-4) and np.allclose(found.tau, tau, atol=1e-4)


@pytest.mark.parametrize("joints", [1, 2, 7])
def test_joints_counted_from_zero_are_not_shifted_by_one(tmp_path, joints):
    numbers = range(joints)
    header = ",".join(["t", *(f"actual_q_{k}" for k in numbers), *(f"actual_moment_{k}" for k in numbers),
                       *(f"target_moment_{k}" for k in numbers)])  # fmt: skip
    wanted = [0.0 * T] * joints
    q, tau = written(tmp_path / "run.csv", header, joints, more=wanted)
    found = read_recording(tmp_path / "run.csv", joints=machine(*(f"j{k}" for k in numbers)))
    assert np.allclose(found.q, q, atol=1e-4) and np.allclose(found.tau, tau, atol=1e-4)


def test_a_set_point_is_no_torque(tmp_path):
    written(tmp_path / "run.csv", "t,actual_q_0,actual_q_1,target_moment_0,target_moment_1", 2)
    with pytest.raises(RecordingError) as refusal:
        read_recording(tmp_path / "run.csv", joints=machine("a", "b"))
    assert "target" not in refusal.value.remedy


def test_short_names_and_arrays_of_one_joint(tmp_path):
    q, tau = written(tmp_path / "run.csv", "t,pos_1,pos_2,eff_1,eff_2", 2)
    assert np.allclose(read_recording(tmp_path / "run.csv").tau, tau, atol=1e-4)
    np.savez(tmp_path / "one.npz", times=T, q=q[:, 0], tau=tau[:, 0])
    one = read_recording(tmp_path / "one.npz")
    assert len(one.joints) == 1 and np.allclose(one.q[:, 0], q[:, 0])


def test_brackets_that_are_no_unit_belong_to_the_name_and_a_spare_column_never_stops_reading(tmp_path):
    header = "t,Hip Angle (R),Knee Angle (R),Hip Torque (filtered),Knee Torque (filtered),Heel FSR (strange),dq1 [odd]"
    q, _ = written(tmp_path / "run.csv", header, 2, more=[np.sign(np.sin(T)), T])
    found = read_recording(tmp_path / "run.csv")
    assert np.allclose(found.q, q, atol=1e-4) and found.dq is None
    said = [one.what for one in found.findings if "left out, and not needed" in one.what]
    assert len(said) == 2 and any("'odd'" in text for text in said)


def test_an_ankle_at_20_to_75_is_in_degrees(tmp_path):
    """An ankle on a spring: a gear of any ratio would explain the torque as well."""
    rng = np.random.default_rng(3)
    q = np.radians(47.0 + 20.0 * np.sin(1.3 * T) + 7.0 * np.sin(3.1 * T))
    tau = 9.0 * (q - np.radians(20.0)) + 0.4 * np.sign(np.cos(1.3 * T)) + 0.02 * rng.standard_normal(T.size)
    rows = [f"{a:.2f},{b:.2f},{c:.3f}" for a, b, c in zip(T, np.degrees(q), tau, strict=True)]
    (tmp_path / "run.csv").write_text("\n".join(["t,Ankle Angle,Measured Torque (R)", *rows, ""]), encoding="utf-8")
    found = read_recording(tmp_path / "run.csv", joints=(Joint("ankle"),))
    assert np.allclose(found.q[:, 0], q, atol=1e-3)


def test_a_spare_column_in_a_unit_that_is_none_of_it_is_left_out_and_told_once(tmp_path):
    written(tmp_path / "run.csv", "t,q1,q2,tau1,tau2,f1 [kg]", 2, more=(np.full(T.size, 3.0),))
    found = read_recording(tmp_path / "run.csv")
    said = [finding.what for finding in found.findings if "f1" in finding.what]
    assert not found.forces and len(said) == 1 and "left out, and not needed" in said[0]
    whole = [line.split(",") for line in (tmp_path / "run.csv").read_text("utf-8").splitlines()]
    (tmp_path / "run.csv").write_text("\n".join(",".join(row[:5]) for row in whole) + "\n", encoding="utf-8")
    (tmp_path / "plate.csv").write_text("\n".join(f"{row[0]},{row[5]}" for row in whole) + "\n", encoding="utf-8")
    with pytest.raises(RecordingError, match="is in kg"):  # what is joined was meant
        read_recording(tmp_path / "run.csv", join=tmp_path / "plate.csv")


@pytest.mark.parametrize("unit", ["Grad", "grados", "degrés", "gradi", "graden", "graus", "Degrees"])
def test_units_are_known_written_out_in_several_languages(unit, tmp_path):
    header = f"t,q1 [{unit}],q2 [{unit}],tau1 [Newtonmeter],tau2 [newton-metre],dq1 [{unit}/s],dq2 [{unit}/s]"
    q, tau = written(tmp_path / "run.csv", header, 2, more=[np.cos(T), np.cos(T)])
    found = read_recording(tmp_path / "run.csv")
    assert np.allclose(found.q, np.radians(q), atol=1e-4) and np.allclose(found.tau, tau, atol=1e-4)
    assert np.allclose(found.dq, np.radians(np.cos(T))[:, None], atol=1e-4)


@pytest.mark.parametrize(
    ("unit", "size", "proposed"),
    [("stopnie", 50.0, "deg"), ("radz", 50.0, "deg"), ("radz", 1.0, "rad"), ("dge", 50.0, "deg"), ("foo", 1.0, "rad")],
)
def test_no_unit_is_proposed_in_which_the_numbers_go_too_far(unit, size, proposed):
    table = {"t": T, "q1": np.sin(T), f"q2 [{unit}]": size * np.sin(T), "tau1": np.cos(T), "tau2": np.cos(T)}
    with pytest.raises(RecordingError) as refusal:
        read_recording(table)
    assert refusal.value.remedy.startswith(f"--units q2={proposed} if it is so")


@pytest.mark.parametrize("name", ["q_{} tau_{}", "panda_joint{}_pos panda_joint{}_effort", "pos_{} current_{}"])
@pytest.mark.parametrize("first", [0, 1])
def test_seven_joints_without_a_model_are_no_leg(name, first, tmp_path):
    parts = enumerate(name.split())
    columns = {part.format(k + first): np.sin(T * (1 + 0.1 * k) + j) for j, part in parts for k in range(7)}
    with pytest.raises(RecordingError) as refusal:
        compare(Model.standard(), read_recording({"t": T, **columns}))
    assert "7 joints" in refusal.value.what and "--model FILE" in refusal.value.remedy
    assert "--map" not in refusal.value.remedy


def test_numbers_beside_named_joints_count_other_things(tmp_path):
    columns = {"t": T, "hip_angle": T, "knee_angle": T, "hip_torque": T, "knee_torque": T}
    columns |= {f"pos_{k}": T for k in range(4)} | {f"load_{k}": T for k in range(4)}
    table = {name: np.sin(values) for name, values in columns.items()} | {"t": T}
    assert read_recording(table).joint_names == ("hip", "knee")


def test_currents_are_called_as_the_file_calls_them():
    table = {"t": T} | {f"actual_{what}_{k}": np.sin(T + k) for what in ("q", "current") for k in (0, 1)}
    with pytest.raises(RecordingError, match="'actual_current_0', 'actual_current_1'"):
        read_recording(table)
