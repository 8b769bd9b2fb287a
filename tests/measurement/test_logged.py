"""Further columns: a temperature says in what state the machine was; a battery's voltage only follows the torque."""

from __future__ import annotations

import numpy as np
import pytest

from exoid.measurement.reading.read import read_recording

T = np.arange(0.0, 30.0, 0.02)
TABLE = {
    "t": T,
    "q1": 0.5 * np.sin(2.0 * T),
    "q2": 0.4 * np.sin(3.0 * T),
    "tau1": 5.0 * np.cos(2.0 * T),
    "tau2": 3.0 * np.cos(3.1 * T),
}
WARM = 25.0 + 8.0 * (1.0 - np.exp(-T / 15.0)) + 0.1 * np.sin(40.0 * T)


@pytest.mark.parametrize("name", ["motor_temp", "hip temperature [°C]", "Wicklungstemperatur", "oil", "motor_u_temp"])
def test_a_column_that_says_how_warm_it_was_is_kept_as_means_of_a_second(name):
    recording = read_recording({**TABLE, name: WARM})
    ((found, logged),) = recording.logged.items()
    assert name.startswith(found) and len(logged.values) == 30 and logged.unit == ("°C" if "[" in name else "")
    np.testing.assert_allclose(logged.at(T[100:-100]), (WARM)[100:-100], atol=0.3)
    assert 0.01 < logged.noise < 0.2


@pytest.mark.parametrize(
    "name",
    [
        "battery_voltage",
        "Vbat",
        "bus [V]",
        "motor_current_limit",
        "soc",
        "charge [%]",
        "frame",
        "trial",
        "hip_target",
    ],
)
def test_what_follows_from_the_torque_or_counts_is_not(name):
    assert not read_recording({**TABLE, name: WARM}).logged


def test_neither_is_a_clock_by_another_name_or_what_is_mostly_missing():
    assert not read_recording({**TABLE, "beat": 1e-3 * T + 7.0, "oil": np.where(T < 25.0, np.nan, WARM)}).logged


def test_a_drive_that_warms_up_steadily_is_no_clock():
    assert list(read_recording({**TABLE, "motor_temp": 30.0 + 0.5 * T}).logged) == ["motor_temp"]


def test_what_is_logged_takes_nothing_from_the_recording():
    plain, more = read_recording(TABLE), read_recording({**TABLE, "oil": WARM})
    np.testing.assert_array_equal(plain.q, more.q)
    np.testing.assert_array_equal(plain.tau, more.tau)
    assert list(plain.columns()) == list(more.columns())
