"""Registers as drives hold them: signs written in ways of their own, and counts that nobody gave a unit."""

from __future__ import annotations

import numpy as np
import pytest

from exoid.diagnosis.comparison import compare
from exoid.ground.errors import RecordingError
from exoid.measurement.reading.read import read_recording
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.workbench.commands.demo import DATA

DEMO = [np.genfromtxt(path, delimiter=",", names=True) for path in sorted(DATA.glob("train*.csv"))]
SERVO = (Joint("servo", length=1.0),)
T = np.arange(1200) * 0.01
POSITION = np.round(2048 + 600 * np.sin(T) + 200 * np.sin(2.3 * T))
CURRENT = np.round(150 * np.cos(1.7 * T) + 40 * np.sin(5 * T))
UNITS = {"q1": "deg/11.3778", "tau1": "Nm*0.005"}


def told(numbers):
    return read_recording({"t": T, "Present_Position": POSITION, "tau": numbers}, units=UNITS, joints=SERVO)


WRITTEN = {
    "jumps by 65536": np.where(CURRENT < 0, CURRENT + 65536, CURRENT),
    "jumps by 4294967296": np.where(CURRENT < 0, CURRENT + 2.0**32, CURRENT),
    "sign in bit 10": np.where(CURRENT < 0, 1024 - CURRENT, CURRENT),
    "sign in bit 15": np.where(CURRENT < 0, 32768 - CURRENT, CURRENT),
}


@pytest.mark.parametrize("said", WRITTEN)
def test_signs_are_put_right_and_said(said):
    found = told(WRITTEN[said])
    assert np.allclose(found.tau[:, 0], 0.005 * CURRENT)
    notes = [finding for finding in found.findings if finding.check == "registers"]
    assert len(notes) == 1 and said in notes[0].what and notes[0].severity == "repaired"


@pytest.mark.parametrize("written", [lambda x, n: np.where(x < 0, x + 2.0**n, x),
                                     lambda x, n: np.where(x < 0, 2.0 ** (n - 1) - x, x)])  # fmt: skip
@pytest.mark.parametrize("factor", [1.0, 0.01, 0.00269])
@pytest.mark.parametrize("bits", [8, 10, 11, 12, 16])
def test_signs_of_registers_of_any_width_are_put_right_behind_a_factor_too(bits, factor, written):
    numbers = np.round(CURRENT * 0.2 * 2.0 ** (bits - 8))
    table = {"t": T, "q1": np.sin(T), "tau1 [Nm]": np.round(factor * written(numbers, bits), 5)}
    found = read_recording(table, joints=SERVO)
    assert np.allclose(found.tau[:, 0], factor * numbers, atol=0.01 * factor + 1e-5)
    assert [finding.severity for finding in found.findings if finding.check == "registers"] == ["repaired"]


@pytest.mark.parametrize("bits", [24, 32])
def test_signs_of_registers_whose_steps_do_not_show_are_put_right(bits):
    numbers = 1e-6 * np.round(30000 * CURRENT)
    table = {"t": T, "q1": np.sin(T), "tau1": [float(f"{x:.7g}") for x in numbers + 1e-6 * 2.0**bits * (numbers < 0)]}
    assert np.allclose(read_recording(table, joints=SERVO).tau[:, 0], numbers, atol=1e-6 * 2.0**bits * 1e-6)


def test_friction_in_a_register_is_put_right_and_asked_of_a_narrow_one():
    friction = np.round(50 * np.sign(np.cos(T)) + 4 * np.sin(23 * T))
    for bits, severity in ((8, "warning"), (10, "repaired"), (16, "repaired")):
        table = {"t": T, "q1": np.sin(T), "tau1 [Nm]": friction + 2.0**bits * (friction < 0)}
        found = read_recording(table, joints=SERVO)
        assert [one.severity for one in found.findings if one.check == "registers"] == [severity]


def test_angles_and_speeds_in_registers_are_put_right():
    angle, speed = np.round(90000 * np.sin(T)), np.round(900 * np.cos(T))
    ran_over = (angle % 65536, (angle + 32768) % 65536 - 32768)  # as counts of a motor before its gear do
    for written, scale in ((np.round(angle / 100) % 65536, 1000), *((one, 100000) for one in ran_over)):
        table = {"t": T, "q1": written, "dq1": np.where(speed < 0, speed + 65536, speed) * 0.01, "tau1": np.cos(T)}
        found = read_recording(table, units={"q1": f"rad/{scale}"}, joints=SERVO)
        assert np.ptp(found.q) == pytest.approx(1.8, abs=0.01) and np.allclose(found.dq[:, 0], 0.01 * speed)


def test_jumps_of_no_known_register_are_refused_and_always_negative_ones_named():
    odd = 0.37 * np.where(CURRENT < 0, CURRENT + 0.01 * np.sin(9 * T) + 7001.3, CURRENT + 0.01 * np.sin(9 * T))
    with pytest.raises(RecordingError, match=r"jumps by about .* read without the sign"):
        read_recording({"t": T, "q1": np.sin(T), "tau1": np.abs(odd)}, joints=SERVO)
    table = {"t": T, "q1": np.sin(T), "load": 65536 - 400 + CURRENT}
    with pytest.raises(RecordingError, match="--map tau1=load-65536") as error:
        read_recording(table, {"tau1": "load"}, joints=SERVO)
    assert "stays close under 65536" in error.value.remedy
    found = read_recording(table, {"tau1": "load-65536"}, {"tau1": "Nm*0.001"}, joints=SERVO)
    assert found.tau.mean() == pytest.approx(-0.4, abs=0.02)


@pytest.mark.parametrize(
    "numbers",
    [
        CURRENT,
        CURRENT + 1024,  # passes the value of the bit without a jump
        np.where(np.arange(1200) % 97 == 0, 65535, 200 + CURRENT),  # a code for an error, now and then
        np.where(np.sin(3 * T) > 0, 20.0, 0.0) + 0.1 * np.sin(40 * T) + 0.1,  # switched on and off
        np.where(np.sin(3 * T) > 0, 255, 0),  # a valve
        np.abs(CURRENT),
        np.where(np.sin(3 * T) > 0, 100, 1100) + np.round(3 * np.sin(40 * T)),  # two levels
    ],
)
def test_what_is_not_certain_is_left_alone(numbers):
    assert not [finding for finding in told(numbers).findings if finding.check == "registers"]


def test_counts_without_a_unit_are_asked_once_and_the_answer_works():
    table = {"t": T, "Present_Position": POSITION, "tau": WRITTEN["jumps by 65536"]}
    table["Present_Velocity"] = np.where(np.gradient(POSITION) < 0, 2.0**32 - 3, 3)
    with pytest.raises(RecordingError) as error:
        read_recording(table, joints=SERVO)
    assert "q1 ('Present_Position', " in error.value.what and "tau1" in error.value.what
    options = error.value.remedy.partition(" with ")[0].removeprefix("--units ")
    units = dict(option.split("=") for option in options.split(","))
    found = read_recording(table, units=units, joints=SERVO)
    assert np.ptp(found.q) == pytest.approx(np.ptp(POSITION) / 4096 * 2 * np.pi, rel=1e-4)
    assert found.dq is None and any("dq1 left out" in finding.what for finding in found.findings)


def test_whole_numbers_of_a_plausible_size_are_not_asked():
    found = read_recording({"t": T, "q1": np.sin(T), "tau1": np.round(40 * np.cos(T))}, joints=SERVO)
    assert found.tau.max() == 40


@pytest.mark.slow
def test_the_zeros_of_encoders_are_found_and_named_where_a_scale_was_given(tmp_path):
    """Recordings of the demo, written as counts."""
    made = [{name: run[name] for name in ("t", "q1", "q2", "tau1", "tau2")} for run in DEMO[:2]]
    units = {"q1": "deg/20", "q2": "deg/45.5"}
    counts = []
    for one in made:
        hip, knee = np.degrees(one["q1"]) + 64.25, np.degrees(one["q2"]) + 26.6
        counts.append({**one, "q1": np.round(20 * hip), "q2": np.round(45.5 * knee)})
    (doubt,) = compare(Model.standard(), [read_recording(one, units=units) for one in counts]).misread
    option = doubt.remedy.partition("--convention ")[2]
    zeros = [float(part.partition("=")[2]) for part in option.split(",")]
    assert zeros == pytest.approx([-64.25, -26.6], abs=4.0)  # of a leg whose friction the rough one does not have
    again = compare(Model.standard(), [read_recording(one, units=units, convention=option) for one in counts])
    assert not again.misread and again.where
    assert not compare(Model.standard(), [read_recording(one) for one in made]).misread


@pytest.mark.slow
def test_encoders_are_offered_one_resolution_and_a_wrong_one_is_named_as_steps_a_turn():
    """2000 counts a radian, of which 4096 a turn are said."""
    made = [
        {"t": one["t"], **{f"q{k}": np.round(2000 * one[f"q{k}"]) % 65536 for k in (1, 2)}, "tau1": one["tau1"],
         "tau2": one["tau2"]}
        for one in DEMO[:2]
    ]  # fmt: skip
    with pytest.raises(RecordingError, match=r"'q2', -\d+ to -\d+") as error:
        read_recording(made[0])
    assert error.value.remedy.startswith("--units q1=deg/11.3778,q2=deg/11.3778 with")
    units = {"q1": "deg/11.3778", "q2": "deg/11.3778"}
    (doubt,) = compare(Model.standard(), [read_recording(one, units=units) for one in made]).misread
    assert "hip-motor-angle=3" in doubt.remedy and "other steps a turn" in doubt.what


def test_counts_are_asked_together_with_the_columns_that_are_missing():
    """One message, and what it says works as it is printed."""
    load = np.where(CURRENT < 0, 1024 - CURRENT, CURRENT)
    with pytest.raises(RecordingError) as error:
        read_recording({"t": T, "Present_Position": POSITION, "Present_Load": load}, joints=SERVO)
    assert "--map tau1=Present_Load --units q1=deg/11.3778,tau1=Nm*0.001 with your numbers" in error.value.remedy
    with pytest.raises(RecordingError) as error:
        read_recording({"t": T, "Present_Position": POSITION, "Present_Current": load}, joints=SERVO)
    assert "--units tau1=Nm/A*0.1*50,q1=deg/11.3778 with your numbers" in error.value.remedy


def test_whole_degrees_are_called_degrees():
    table = {"t": T, "q1": np.round(40 * np.sin(T)), "q2": np.round(50 * np.cos(T))}
    table |= {"tau1": np.cos(T), "tau2": np.cos(T)}
    with pytest.raises(RecordingError, match="degrees, or counts of an encoder, and not rad") as error:
        read_recording(table)
    assert error.value.remedy.startswith("--units q1=deg,q2=deg if it is so (angles: here degrees;")
