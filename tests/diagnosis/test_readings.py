"""Readings are suspected as effects are: where one is accepted, no effect is named in its place."""

from __future__ import annotations

from dataclasses import replace

import pytest

from exoid.diagnosis.discovery import discover
from exoid.diagnosis.hypotheses.readings import is_reading, readings_of, thigh_length
from exoid.diagnosis.machine_answer import in_words
from exoid.diagnosis.results import Accepted
from exoid.measurement.bench.hidden import Hidden
from exoid.measurement.bench.simulation import simulate_runs
from exoid.symbolic.effect_catalogue import find_effect
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.model_structure import Limits

LENGTH = 0.40
CHAIN = (Joint("boom", length=0.5), Joint("arm", length=0.4), Joint("hand"))


def runs(*hidden):
    return [run.recording for run in simulate_runs(4, Model.standard(LENGTH), effects=hidden, seed=11)]


def stop():
    return Hidden(find_effect("end_stop"), "hip", {"c": 40.0, "theta_s": 0.5, "side": 1.0})


@pytest.mark.slow
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


def chain(*lengths):
    joints = tuple(replace(joint, length=length) for joint, length in zip(CHAIN, (*lengths, None), strict=True))
    limits = {joint.name: Limits((-0.8, 0.8), 2.0, 8.0) for joint in joints}
    return Model("chain", limits=limits, joints=joints)


@pytest.mark.slow
@pytest.mark.parametrize(("lengths", "wrong"), [((0.62, 0.4), "boom"), ((0.5, 0.3), "arm")])
def test_a_wrong_length_of_a_chain_is_told_and_no_effect_in_its_place(lengths, wrong):
    true = chain(0.5, 0.4)
    made = [run.recording for run in simulate_runs(4, true, seed=6)]
    found = discover(chain(*lengths), made[:3], made[3:])
    assert found.verdict == "check_channels" and not found.accepted
    assert f"length of link {wrong} contradicts the recordings" in found.sentence
    told = float(found.next_experiment.partition("length = ")[2].split()[0])
    assert told == pytest.approx({"boom": 0.5, "arm": 0.4}[wrong], rel=0.06)


def test_machines_without_a_length_to_tell_are_not_asked_for_one():
    from types import SimpleNamespace

    nothing = SimpleNamespace(misread=(), train=())
    misread = SimpleNamespace(misread=("swapped",), train=())

    def lengths(model):
        return [one for one in readings_of(model, nothing) if one.id.endswith("length")]

    assert lengths(Model.standard()) == [thigh_length.EFFECT]
    assert [one.joints for one in lengths(Model(joints=CHAIN))] == [("boom", "arm")]
    assert not lengths(Model(joints=["axis"]))
    assert not readings_of(Model.standard(), misread) and not readings_of(Model(joints=CHAIN), misread)


def test_a_reading_that_cannot_be_told_apart_is_named_in_words():
    alike = ("thigh_length", "backlash:knee")
    one = Accepted("rotor_inertia", "knee", {}, alike, alike[:1], 0.001, 1.0, 0.5, "")
    told = in_words(one)
    assert told.look_alikes == ("another thigh length", "backlash:knee")
    assert told.never_separable == told.outside == ("another thigh length",)
    assert in_words(replace(one, look_alikes=(), never_separable=())).outside == ()
