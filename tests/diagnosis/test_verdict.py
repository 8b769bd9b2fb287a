"""The verdict: a table of what was found and what it is called, and what is said beside it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from synthetic import search, state_with

from exoid.diagnosis.evidence.agreement import Agreement
from exoid.diagnosis.evidence.remainder import Remainder
from exoid.diagnosis.results import Accepted, Possible
from exoid.diagnosis.search.doubt import DELAY
from exoid.diagnosis.verdict import _deciding, conclude

ONE = Accepted("stribeck", "hip", {}, (), (), 0.001, np.ones(2), 0.5 * np.ones(2), "Stribeck", Agreement(4, 4))
ALIKE = replace(ONE, look_alikes=("torque_ripple:hip",))
CURVE = Remainder("knee", "q2", "", 0.4, 0.3, 0.001, np.zeros(2), np.zeros(2), np.zeros(2), joint_share=0.4)


@pytest.fixture(scope="module")
def near():
    """A model that leaves the noise."""
    return state_with(search({}, ["torque_offset:knee"])).last.fitted


@pytest.fixture(scope="module")
def far():
    """A model that leaves ten times the noise at the knee."""
    return state_with(search({"torque_offset:knee": ([1.0], [])}, ["torque_offset:knee"])).last.fitted


TABLE = [
    ("near the noise, nothing found", (), None, "near", "adequate", "nothing is missing"),
    ("far above the noise, nothing found", (), None, "far", "unexplained", "not as good as the sensors"),
    ("a curve and no entry", (), CURVE, "near", "unexplained", "does not know"),
    ("a curve and no entry, far above the noise", (), CURVE, "far", "unexplained", "does not know"),
    ("an effect", (ONE,), None, "near", "missing", "Missing: Stribeck"),
    ("an effect, and more", (ONE,), None, "far", "missing", "Beyond that"),
    ("an effect, and a curve", (ONE,), CURVE, "near", "missing", "Still unexplained"),
    ("look-alikes", (ALIKE,), None, "near", "ambiguous", "cannot say"),
    ("look-alikes, and more", (ALIKE,), None, "far", "ambiguous", "Beyond that"),
    ("an effect and look-alikes of another", (ONE, ALIKE), None, "near", "missing", "the others they can"),
]


@pytest.mark.parametrize(("what", "accepted", "left", "error", "verdict", "said"), TABLE)
def test_what_was_found_has_one_verdict(what, accepted, left, error, verdict, said, request):
    last = request.getfixturevalue(error)
    found = conclude(accepted, left, last, last, True, 4)
    assert found.verdict == verdict and said in found.sentence
    assert (found.error is not None) is (error == "far")


@pytest.mark.parametrize(
    ("verified", "recordings", "said"), [(True, 4, ""), (False, 4, "--verify"), (False, 1, "two more motions")]
)
def test_what_to_record_next_depends_on_what_was_held_out(near, verified, recordings, said):
    assert said in conclude((), None, near, near, verified, recordings).next_experiment


def test_no_experiment_separates_what_is_no_entry():
    also = ("a filter of first order on the torque (8 Hz)",)
    one = Accepted("time_delay", "hip", {}, also, (), 0.001, 1.0, 0.5, "", outside=also)
    assert "--separate" not in _deciding([one])
    assert "--separate time_delay:hip,stribeck:hip finds" in _deciding([replace(one, look_alikes=("stribeck:hip",))])


def test_a_model_is_not_adequate_where_only_an_early_torque_helps():
    context = search({}, ["torque_offset:knee"])
    last = state_with(context).last.fitted
    early = Possible(DELAY, "hip", Agreement(4, 4), {}, 0.04, "the torque would come 0.03 s before", early=True)
    found = conclude((), None, last, last, True, 4, possible=(early,))
    assert found.verdict == "unexplained" and "drive" in found.next_experiment
    assert "Time delay at the hip, 4 %" in found.sentence
    assert conclude((), None, last, last, True, 4, possible=(replace(early, early=False),)).verdict == "adequate"


def test_a_model_is_not_adequate_where_what_is_missing_shows_in_fitted_recordings_only():
    context = search({"torque_offset:knee": ([1.0], [])}, ["torque_offset:knee"], scales=(1.0, -1.0, 1.0, 0.0))
    last = state_with(context).last.fitted
    near = replace(last, prepared=replace(last.prepared, noise_floor=np.maximum(last.evaluation_rms, 0.1) / 2.0))
    assert np.any(near.train_rms > 3.0 * near.prepared.noise_floor)
    offset = Possible("torque_offset", "knee", Agreement(1, 2), {}, 0.48, "supported by 1 of 2 splits")
    found = conclude((), None, near, near, True, 4, possible=(offset,))
    assert found.verdict == "unexplained"
    assert "left in run_0, run_1, run_2 that" in found.sentence
    assert "Torque offset at the knee, 48 %" in found.sentence and "hold out a recording" in found.next_experiment
    assert conclude((), None, near, near, True, 4).verdict == "unexplained"
    near = replace(last, prepared=replace(last.prepared, noise_floor=np.maximum(last.train_rms, last.evaluation_rms)))
    assert conclude((), None, near, near, True, 4).verdict == "adequate"


@pytest.mark.parametrize(("after", "recordings", "said"), [(1.1, 9, True), (0.9, 9, False), (1.1, 4, False)])
def test_it_is_said_where_the_recordings_held_out_lose_by_what_nearly_all_splits_support(after, recordings, said):
    last = state_with(search({}, ["torque_offset:knee"])).last.fitted
    agreement = Agreement(81, 83, {}, (), 84, recordings)
    one = Accepted(
        "rotor_inertia", "knee", {}, (), (), 0.001, np.ones(2), np.array([1.0, after]), "Rotor inertia", agreement
    )
    found = conclude((one,), None, last, last, True, recordings)
    assert ("lose a little by Rotor inertia at the knee" in found.sentence) is said
    assert ("though not on those held out" in found.rule) is said and found.verdict == "missing"
