"""What can be read in one way only is read so and said; what leaves a doubt is asked."""

from __future__ import annotations

import numpy as np
import pytest
from tables import leg

from exoid.ground.errors import RecordingError
from exoid.measurement.auditing.convention import check_conventions
from exoid.measurement.reading.names import recognise
from exoid.measurement.reading.read import read_recording
from exoid.symbolic.joints import Joint

LEG = leg(600)
RATES = {name: np.gradient(LEG[name], LEG["t"]) for name in ("q1", "q2")}


def changed(**columns):
    return {**LEG, **columns}


def degrees(**columns):
    return changed(q1=np.degrees(LEG["q1"]), q2=np.degrees(LEG["q2"]), **columns)


def said(recording, check="units"):
    return [finding for finding in recording.findings if finding.check == check]


@pytest.mark.slow
def test_angles_that_can_only_be_degrees_are_read_so_and_it_is_said():
    recording = read_recording(degrees(dq1=np.degrees(RATES["q1"]), dq2=np.degrees(RATES["q2"])))
    np.testing.assert_allclose(recording.q, np.column_stack([LEG["q1"], LEG["q2"]]))
    np.testing.assert_allclose(recording.dq[:, 0], RATES["q1"])
    (finding,) = said(recording)
    assert finding.severity == "repaired" and "q1, q2, dq1, dq2 were read in degrees" in finding.what
    assert "--units q=rad" in finding.remedy


@pytest.mark.slow
def test_velocities_in_rad_beside_angles_in_degrees_are_warned_of():
    recording = read_recording(degrees(dq1=RATES["q1"], dq2=RATES["q2"]))
    assert "0.0175 times the derivative" in said(recording, "velocity")[0].what


@pytest.mark.slow
def test_a_base_that_leans_by_degrees_is_read_as_the_joints_are():
    recording = read_recording(degrees(base_angle=8.0 * np.sin(LEG["t"])))
    assert recording.base[:, 0].max() < 0.2


@pytest.mark.parametrize(
    ("columns", "how"),
    [
        (changed(q1=LEG["q1"], q2=np.degrees(LEG["q2"])), {}),  # one in rad beside one in degrees
        (changed(q1=1000 * LEG["q1"], q2=1000 * LEG["q2"]), {}),  # mrad, or counts
        (degrees(), {"units": {"q": "rad"}}),  # somebody said so
    ],
)
def test_what_may_be_something_else_is_asked(columns, how):
    recording = read_recording(columns, **how)
    assert "looks like degrees" in said(recording)[0].what
    np.testing.assert_allclose(recording.q[:, 1], columns["q2"])


def test_whole_numbers_may_be_counts_and_are_not_read_before_somebody_says():
    columns = changed(q1=np.round(np.degrees(LEG["q1"])), q2=np.degrees(LEG["q2"]))
    with pytest.raises(RecordingError, match="whole numbers") as error:
        read_recording(columns)
    assert "--units q1=deg" in error.value.remedy
    assert read_recording(columns, units={"q": "deg"}).q.max() < 2.0


@pytest.mark.slow
def test_a_shaft_before_its_gear_may_turn_often():
    columns = degrees()
    before = {f"{joint}_motor_angle": columns.pop(q) for joint, q in (("hip", "q1"), ("knee", "q2"))}
    assert read_recording({**columns, **before}).q.max() > 50.0
    unnamed = read_recording(changed(q1=30 * LEG["q1"], q2=30 * LEG["q2"]))
    assert unnamed.q.max() > 30.0 and "motor" in check_conventions([unnamed])[0].remedy
    assert read_recording(degrees(), joints=(Joint("arm", length=0.4), Joint("table"))).q.max() > 50.0


@pytest.mark.parametrize(
    ("name", "meant", "unit"),
    [
        ("q_deg1", "q1", "deg"), ("q_deg_2", "q2", "deg"), ("tau_mNm2", "tau2", "mNm"), ("dq_deg_s1", "dq1", "deg/s"),
        ("log.q_deg2", "q2", "deg"), ("joint_position_deg1", "q1", "deg"), ("q_2", "q2", ""), ("angle_l2", "q2", ""),
    ],
)  # fmt: skip
def test_the_columns_of_a_matrix_keep_the_unit_of_its_name(name, meant, unit):
    found = recognise(name)
    assert found is not None and (found.name, found.unit) == (meant, unit)


def test_matrices_named_with_their_units_are_converted(tmp_path):
    savemat = pytest.importorskip("scipy.io").savemat
    q, tau = (np.column_stack([LEG[f"{one}1"], LEG[f"{one}2"]]) for one in ("q", "tau"))
    small = {"t_ms": 1000 * LEG["t"], "q_deg": 0.2 * np.degrees(q), "tau_mNm": 1000 * tau}
    savemat(tmp_path / "run.mat", small)
    np.savez(tmp_path / "run.npz", **small)
    for name in ("run.mat", "run.npz"):
        recording = read_recording(tmp_path / name)
        np.testing.assert_allclose(recording.q, 0.2 * q)
        np.testing.assert_allclose(recording.tau, tau)
        np.testing.assert_allclose(recording.t, LEG["t"])


def test_a_product_of_columns_is_a_channel():
    columns = changed(duty=LEG["tau1"] / 24.0, volts=np.full(600, 24.0))
    del columns["tau1"]
    recording = read_recording(columns, {"tau1": "duty * volts"}, {"tau1": "Nm/V*0.5"})
    np.testing.assert_allclose(recording.tau[:, 0], 0.5 * LEG["tau1"])
    assert "duty * volts as tau1" in said(recording, "columns")[0].what


def test_a_name_with_a_star_is_a_name_first():
    columns = changed(**{"i*k": LEG["tau1"], "i": LEG["tau1"], "k": LEG["tau1"]})
    np.testing.assert_allclose(read_recording(columns, {"tau1": "i*k"}).tau[:, 0], LEG["tau1"])


@pytest.mark.parametrize(
    ("text", "units", "words"),
    [
        ("duty*vols", {}, "did you mean 'volts"),
        ("duty**volts", {}, "is not in the file"),
        ("*".join(["duty"] * 20), {}, "is not in the file"),
        ("duty*volts", {}, "--units tau1=Nm*0.5 with what one"),
        ("duty*volts", {"tau1": "Nm/V*0.5"}, "write the factor for one %*V"),
        ("__import__('os')*volts", {}, "is not in the file"),
    ],
)
def test_what_is_no_product_or_lacks_a_factor_is_refused(text, units, words):
    columns = changed(**{"duty [%]": LEG["tau1"], "volts [V]": LEG["tau1"]})
    with pytest.raises(RecordingError) as refused:
        read_recording(columns, {"tau1": text}, units)
    assert words in str(refused.value)


def test_a_cell_without_a_number_leaves_the_product_without_one():
    volts = np.full(600, 24.0)
    volts[100] = np.nan
    recording = read_recording(changed(duty=LEG["tau1"], volts=volts), {"tau1": "duty*volts"})
    assert np.flatnonzero(~recording.torque_valid[:, 0]).tolist() == [100]


def test_a_passive_joint_needs_no_torque_column():
    columns = {name: LEG[name] for name in ("t", "q1", "q2", "tau1")}
    with pytest.raises(RecordingError, match="--passive knee"):
        read_recording(columns)
    recording = read_recording(columns, passive="knee")
    assert recording.passive == ("knee",) and not recording.tau[:, 1].any()
    assert not [finding for finding in recording.findings if "knee torque" in finding.what]
