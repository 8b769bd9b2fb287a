"""A stop has one place on the machine unless places of their own pay, judged on the half they were not fitted to."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exoid.diagnosis.discovery import discover
from exoid.diagnosis.evidence.fitted import fitted_model, places_pay
from exoid.diagnosis.extend import add
from exoid.measurement.bench.hidden import parse_hidden
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.simulation import simulate_runs
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import Model, read_model
from exoid.symbolic.model_file import write_model

PLACES = (0.95, 0.9, 0.85, 0.8)


def recordings(count, place):
    """Return so many runs of a leg with a stop of the hip at `place`."""
    hidden = parse_hidden(f"end_stop:hip=c=35,theta_s={place},side=1")
    return [run.recording for run in simulate_runs(count, None, standard_leg(), effects=[hidden], seed=5)]


@pytest.fixture(scope="module")
def still():
    return recordings(4, 0.8)


@pytest.fixture(scope="module")
def moving():
    return [recordings(k + 1, place)[k] for k, place in enumerate(PLACES)]


@pytest.mark.slow
def test_a_stop_has_one_place_with_an_interval(still):
    found = discover(Model.standard(), still[:3], still[3])
    (stop,) = found.accepted
    place = stop.parameters["theta_s"]
    assert not found.model.terms[-1].own_places
    assert place.low < 0.8 < place.high and place.high - place.low < 0.02
    assert "one half" not in found.sentence


@pytest.mark.slow
def test_places_of_their_own_are_found_where_the_stop_moves_and_it_is_said(moving):
    found = discover(Model.standard(), moving[:3], moving[3])
    (stop,) = found.accepted
    assert found.model.terms[-1].own_places
    assert (stop.parameters["theta_s"].low, stop.parameters["theta_s"].high) == pytest.approx((0.85, 0.95), abs=0.01)
    assert "another in every recording" in found.sentence
    assert "found in one half and judged on the other" in found.sentence


@pytest.mark.slow
def test_adding_the_effect_decides_alike(still, moving):
    for runs, own in ((still, False), (moving, True)):
        done = add(Model.standard(), "end_stop:hip", runs[:3], runs[3])
        assert done.helped and done.model.terms[-1].own_places == own


def test_each_half_of_an_unseen_recording_is_judged_by_the_place_of_the_other(moving):
    model = Model.standard().with_effect("end_stop:hip", own_places=True)
    prepared = prepare(model, moving[:3], moving[3:])
    fit = identify(model, prepared.train, optimisers=())
    usual = fitted_model(fit, prepared)
    unseen = prepared.verify[0]
    torque = unseen.torque.copy()
    torque[0, torque.shape[1] // 2 :] += 1.0  # moves the place of the second half, not that which judges it
    changed = fitted_model(fit, replace(prepared, verify=(replace(unseen, torque=torque),)))
    late = slice(torque.shape[1] // 2, None)
    assert np.allclose(changed.residuals[3][:, late] - usual.residuals[3][:, late], [[1.0], [0.0]])


@pytest.mark.slow
def test_places_that_are_the_same_do_not_pay(still):
    once, each = (Model.standard().with_effect("end_stop:hip", own_places=own) for own in (False, True))
    prepared = prepare(once, still)
    fits = [fitted_model(identify(model, prepared.train, optimisers=()), prepared) for model in (once, each)]
    assert not places_pay(*fits)


def test_a_model_file_keeps_whether_places_are_their_own(tmp_path):
    model = Model.standard().with_effect("end_stop:hip", own_places=True).with_effect("stribeck:knee")
    write_model(model, tmp_path / "leg.toml")
    again = read_model(tmp_path / "leg.toml")
    assert [(term.name, term.own_places) for term in again.terms] == [("end_stop:hip", True), ("stribeck:knee", False)]
