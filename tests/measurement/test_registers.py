"""Registers as drives hold them: signs written in ways of their own, and counts that nobody gave a unit."""

from __future__ import annotations

import numpy as np
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.read import read_recording
from exoid.symbolic.joints import Joint

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


@pytest.mark.parametrize(
    "numbers",
    [
        CURRENT,
        CURRENT + 1024,  # passes the value of the bit without a jump
        np.where(np.arange(1200) % 97 == 0, 65535, 200 + CURRENT),  # a code for an error, now and then
        np.where(CURRENT < 0, CURRENT + 65536, CURRENT) + 0.5,  # no register
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
