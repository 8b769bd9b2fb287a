"""Rows are chosen by a column and a number, stance is left out where only a foot switch knows of it; nothing leaks."""

from contextlib import suppress

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exoid.diagnosis.discovery import discover
from exoid.ground.errors import RecordingError
from exoid.measurement import stance
from exoid.measurement.finding import SELECTION
from exoid.measurement.reading.read import read_recording
from exoid.measurement.selection import Condition, conditions
from exoid.symbolic.model import Model
from tests.walking import on_the_ground, walked


def table(count=400, **more):
    t = np.arange(count) * 0.01
    q1, q2 = 0.4 * np.sin(3.0 * t), -0.6 + 0.3 * np.cos(4.0 * t)
    return {"t": t, "q1": q1, "q2": q2, "tau1": 20.0 * np.sin(q1), "tau2": 5.0 * np.sin(q1 + q2), **more}


def chosen(recording):
    return recording.torque_valid.all(axis=1)


def test_conditions_are_read():
    text = "contact == 0 and gait phase>=0.6 and t < 2e1"
    wanted = (Condition("contact", "==", 0.0), Condition("gait phase", ">=", 0.6), Condition("t", "<", 20.0))
    assert conditions(text) == wanted


@pytest.mark.parametrize("text", ("contact", "contact = 0", "contact == x", "== 3", "a == 0 or 1", "and", "t < nan"))
def test_what_is_no_condition_is_refused(text):
    with pytest.raises(RecordingError, match="no condition"):
        conditions(text)


@given(st.text(max_size=60))
def test_any_text_is_read_or_refused(text):
    with suppress(RecordingError):
        assert all(np.isfinite(one.value) and one.column for one in conditions(text))


@pytest.mark.parametrize(
    ("only", "expected"),
    (
        ("phase > 0.6", lambda one: np.arange(len(one)) % 100 > 60),
        ("t < 1 and q1 > 0", lambda one: (one.t < 1.0) & (one.q[:, 0] > 0.0)),
        ("phase != 0", lambda one: np.arange(len(one)) % 100 != 0),
    ),
)
def test_rows_are_chosen_by_the_columns_of_the_file_and_our_own(only, expected):
    one = read_recording(table(phase=np.arange(400) % 100 / 100.0), only=only)
    assert np.array_equal(chosen(one), expected(one))
    assert one.angle_valid.all()
    assert [found.check for found in one.findings if found.severity == "repaired"] == [SELECTION]


def test_rows_are_found_again_where_the_file_is_not_in_order():
    columns = table(phase=np.arange(400) % 100 / 100.0)
    order = np.arange(400)[::-1]
    straight = read_recording(columns, only="phase < 0.3")
    mixed = read_recording({name: values[order] for name, values in columns.items()}, only="phase < 0.3")
    assert np.array_equal(chosen(straight), chosen(mixed))


def test_a_column_that_is_not_there_and_an_empty_choice_are_refused():
    with pytest.raises(RecordingError, match="no column 'fase'") as error:
        read_recording(table(phase=np.arange(400)), only="fase < 3")
    assert "phase" in error.value.remedy
    with pytest.raises(RecordingError, match="only 0 usable rows"):
        read_recording(table(), only="t < -1")


def test_stance_is_left_out_where_only_a_switch_knows_of_it():
    contact = (np.arange(400) % 100 < 60).astype(float)
    one = read_recording(table(contact=contact))
    assert not chosen(one)[contact > 0].any() and 0.3 < chosen(one).mean() < 0.4
    assert any("left out" in found.what for found in one.findings)
    assert chosen(read_recording(table(contact=contact), only="contact >= 0")).all()
    force = {"grf_x": 10.0 * contact, "grf_z": 100.0 * contact}
    assert chosen(read_recording(table(contact=contact, **force))).all()


def test_a_switch_that_never_changes_leaves_nothing_out():
    one = read_recording(table(contact=np.ones(400)))
    assert chosen(one).all() and any("hardly changes" in found.what for found in one.findings)


def test_an_insole_is_never_quite_zero(monkeypatch):
    load = np.where(np.arange(400) % 100 < 60, 300.0, 4.0) + np.random.default_rng(0).uniform(0.0, 6.0, 400)
    assert 0.3 < chosen(read_recording(table(insole_force=load))).mean() < 0.4
    monkeypatch.setattr(stance, "LOADED", 0.0)
    assert chosen(read_recording(table(insole_force=load))).all()  # it seems never to leave the ground


@pytest.mark.slow
def test_on_the_swings_the_leg_is_explained_as_in_the_air():
    def seen(seed, **more):
        one = on_the_ground(seed)
        names = dict(zip(("t", "q1", "q2", "tau1", "tau2"), (one.t, *one.q.T, *one.tau.T), strict=True))
        return read_recording({**names, **more}, name=one.name)

    swings = [seen(seed, foot_switch=walked(seed)[2].astype(float)) for seed in range(3)]
    air = [walked(seed)[0] for seed in range(3)]
    answers = [discover(Model.standard(), runs[:2], runs[2:]) for runs in (swings, air)]
    assert [answer.verdict for answer in answers] == ["adequate", "adequate"]
    assert np.all(answers[0].steps[-1].evaluation_rms < 1.5 * answers[0].noise_floor)
    assert np.all(answers[0].noise_floor > 0.5 * answers[1].noise_floor)
