"""Names, units and what the user says by hand."""

import numpy as np
import pytest
from tables import HEADER, leg, text

from exoid.measurement.reading.names import recognise
from exoid.measurement.reading.read import read_recording
from exoid.measurement.reading.units import factor

NAMES = {
    "q1": "q1",
    "theta_1": "q1",
    "θ2": "q2",
    "Hip Angle": "q1",
    "kneeAngle": "q2",
    "joint2_position": "q2",
    "dq1": "dq1",
    "thetaDot2": "dq2",
    "hip_velocity": "dq1",
    "qdd1": "ddq1",
    "τ1": "tau1",
    "Knee Moment": "tau2",
    "u1": "tau1",
    "cuff_force_2": "f2",
    "time": "t",
    "Timestamp": "t",
    "run.hip.angle": "q1",
    "leg/run1/q2": "q2",
    "measured_q1": "q1",
    "MAIN.fHipAngle": "q1",
    "GVL.lrKneeTorque": "tau2",
    "left_hip_pitch_joint/position": "q1",
}
STRANGERS = (
    "q1_ref",
    "desired.q1",
    "tau1_cmd",
    "torque_error_1",
    "q12",
    "q3",
    "hip",
    "hip_adduction_r",
    "shank_angle",
    "left_hip_roll_joint/position",
    "u_angle_1",
    "hip_flexion_r_beta",
    "run1/position",
    "left_right_hip_angle",
    "",
    "1",
)


@pytest.mark.parametrize("name", NAMES)
def test_usual_names_are_recognised(name):
    assert recognise(name).name == NAMES[name]


@pytest.mark.parametrize("name", STRANGERS)
def test_set_points_and_strangers_are_not_measurements(name):
    assert recognise(name) is None


@pytest.mark.parametrize(
    ("quantity", "unit", "value"),
    [
        ("q", "deg", np.pi / 180),
        ("q", "°", np.pi / 180),
        ("tau", "mN·m", 1e-3),
        ("tau", "N*m", 1.0),
        ("tau", "Nm", 1.0),
        ("dq", "rad/s", 1.0),
        ("dq", "rad·s^-1", 1.0),
        ("dq", "°/s", np.pi / 180),
        ("ddq", "rad/s²", 1.0),
        ("ddq", "rad/s^2", 1.0),
        ("dq", "rpm", np.pi / 30),
        ("t", "µs", 1e-6),
        ("t", "10 ms", 1e-2),
        ("tau", "-Nm", -1.0),
        ("f", "kN", 1e3),
        ("tau", "Nm/A*0.123*6", 0.738),
        ("tau", "-N·m/A * 0.1 × 50", -5.0),
        ("tau", "A*0.123*6", 0.738),
        ("tau", "mNm/mA*30.2*100/1000", 3.02e-3),
        ("tau", "%*45", 0.45),
        ("tau", "Nm/kg*75", 75.0),
        ("tau", "Nm*6", 6.0),
        ("q", "deg/6", np.pi / 1080),
        ("q", "rev/4096", 2 * np.pi / 4096),
    ],
)
def test_units(quantity, unit, value):
    assert factor(quantity, unit) == pytest.approx(value, rel=1e-15)


@pytest.mark.parametrize(
    "unit",
    ["furlong", "", "1e999 s", "0 s", "rad/s", "rad*0", "rad*1e999", "rad**2", "rad*(2)", "2*3", "/2", "rad*" * 50],
)
def test_unknown_units(unit):
    assert factor("q", unit) is None


def test_units_convert_from_header_row_and_option(tmp_path):
    columns = leg()
    rad = columns | {}
    columns["q1"], columns["q2"] = np.degrees(rad["q1"]), np.degrees(rad["q2"])
    columns["tau2"] = columns["tau2"] * 1000
    path = tmp_path / "a.csv"
    for header, units, option in (
        ("t,q1 [deg],q2 (°),tau1,tau2_mNm", "", None),
        (HEADER, "s,deg,deg,Nm,mNm", None),
        (HEADER, "", {"q": "deg", "tau2": "mNm"}),
    ):
        path.write_text(text(columns, header=header, units=units))
        recording = read_recording(path, units=option)
        np.testing.assert_allclose(recording.q[:, 0], rad["q1"], rtol=1e-7)
        np.testing.assert_allclose(recording.tau[:, 1], rad["tau2"], rtol=1e-6)
        assert any("converted to SI" in finding.what for finding in recording.findings)


def test_map_names_columns_and_half_pairs_are_left_aside(tmp_path):
    path = tmp_path / "a.csv"
    path.write_text(text(header="t,enc_a,enc_b,tau1,tau2"))
    recording = read_recording(path, columns={"q1": "enc_a", "q2": "ENC_B"})
    np.testing.assert_allclose(recording.q[:, 0], leg()["q1"], rtol=1e-7)
    columns = leg()
    columns["dq1"] = columns["q1"]
    path.write_text(text(columns, header=HEADER + ",dq1"))
    recording = read_recording(path)
    assert recording.dq is None and any("partner is missing" in f.what for f in recording.findings)
    path.write_text(text(header=""))
    numbered = dict(zip(("t", "q1", "q2", "tau1", "tau2"), "12345", strict=True))
    assert len(read_recording(path, columns=numbered)) == 1500


def test_a_product_needs_its_number_and_the_unit_of_the_column():
    assert factor("tau", "Nm/A") is None and factor("tau", "%") is None
    assert factor("tau", "Nm/A*0.1", "mA") == pytest.approx(1e-4)
    assert factor("tau", "A*0.1", "mA") == pytest.approx(1e-4)
    assert factor("tau", "%*45", "‰") == pytest.approx(0.045)
    assert factor("tau", "Nm/A*0.1", "V") is None
    assert factor("tau", "Nm/kg*75", "Nmm/kg") is None
