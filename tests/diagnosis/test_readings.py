"""Readings are suspected as effects are: where one is accepted, no effect is named in its place."""

from __future__ import annotations

from dataclasses import replace

import pytest

from exoid.diagnosis.discover import discover, in_words
from exoid.diagnosis.readings import is_reading, thigh_length
from exoid.diagnosis.results import Accepted
from exoid.measurement.bench.hidden import Hidden
from exoid.measurement.bench.simulation import simulate_runs
from exoid.symbolic.catalogue import find_effect
from exoid.symbolic.model import Model

LENGTH = 0.40


def runs(*hidden):
    return [run.recording for run in simulate_runs(4, Model.standard(LENGTH), effects=hidden, seed=11)]


def stop():
    return Hidden(find_effect("end_stop"), "hip", {"c": 40.0, "theta_s": 0.5, "side": 1.0})


@pytest.mark.parametrize("assumed", [0.5, 0.34])
@pytest.mark.parametrize("hidden", [(), (stop(),)])
def test_a_wrong_thigh_length_is_told_and_no_effect_in_its_place(assumed, hidden):
    made = runs(*hidden)
    found = discover(Model.standard(assumed), made[:3], made[3:])
    assert found.verdict == "check_channels" and not found.accepted
    told = float(found.next_experiment.rpartition("thigh_length = ")[2].split()[0])
    assert told == pytest.approx(LENGTH, abs=0.02)
    assert found.thigh_length is None  # what the audit says of it, beside a model without the effect, may differ


def test_the_right_length_is_not_doubted_and_no_reading_is_listed_among_effects():
    made = runs(stop())
    found = discover(Model.standard(LENGTH), made[:3], made[3:])
    assert [one.name for one in found.accepted] == ["end_stop:hip"]
    assert not any(is_reading(one.name) for one in (*found.suspects, *found.possible))


def test_machines_without_a_length_to_tell_are_not_asked_for_one():
    from types import SimpleNamespace

    nothing = SimpleNamespace(misread=(), train=())
    assert thigh_length.asked(Model.standard(), nothing)
    assert not thigh_length.asked(Model(joints=["axis"]), nothing)
    assert not thigh_length.asked(Model.standard(), SimpleNamespace(misread=("swapped",), train=()))


def test_a_reading_that_cannot_be_told_apart_is_named_in_words():
    alike = ("thigh_length", "backlash:knee")
    one = Accepted("rotor_inertia", "knee", {}, alike, alike[:1], 0.001, 1.0, 0.5, "")
    told = in_words(one)
    assert told.look_alikes == ("another thigh length", "backlash:knee")
    assert told.never_separable == told.outside == ("another thigh length",)
    assert in_words(replace(one, look_alikes=(), never_separable=())).outside == ()
