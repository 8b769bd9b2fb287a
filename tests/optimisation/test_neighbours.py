"""Neighbouring cut-offs: an honest fit agrees with itself, and a parameter that moves is named with where to."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.fitting.neighbours import FACTORS, neighbours
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import Model


@pytest.fixture(scope="module")
def fitted():
    runs = simulate_runs(2, None, standard_leg(), seed=4, bench=Bench(duration=20.0))
    recordings, model = [run.recording for run in runs], Model.standard()
    prepared = prepare(model, recordings)
    return model, recordings, prepared, identify(model, prepared.train, optimisers=())


def test_a_complete_model_agrees_with_its_neighbours(fitted):
    model, recordings, prepared, fit = fitted
    near = neighbours(fit, model, prepared, recordings)
    assert near.agree and near.findings() == ()
    assert near.cutoffs == tuple(f * prepared.choice.cutoff for f in FACTORS)
    assert json.loads(json.dumps(near.to_json()))["agree"] is True


def test_what_moves_is_named(fitted):
    model, recordings, prepared, fit = fitted
    sure = tuple(replace(e, low=e.value - 1e-9, high=e.value + 1e-9) for e in fit.estimates)
    near = neighbours(replace(fit, estimates=sure), model, prepared, recordings)
    assert not near.agree
    assert {name for name, _, _ in near.moved} >= {"Phi1", "coulomb:knee"}
    assert all("outside its interval" in f.what and " Hz" in f.what for f in near.findings())


@pytest.mark.slow
def test_a_cut_off_too_fast_for_the_clock_is_left_out(fitted):
    model, _, _, _ = fitted
    runs = simulate_runs(2, None, standard_leg(), seed=4, bench=Bench(duration=20.0, rate=25.0))
    slow = [run.recording for run in runs]
    prepared = prepare(model, slow, cutoff=9.0)
    fit = identify(model, prepared.train, optimisers=())
    assert neighbours(fit, model, prepared, slow).cutoffs == (pytest.approx(7.2),)
    assert np.isfinite(neighbours(fit, model, prepared, slow).values[0]).all()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["stribeck:knee", "end_stop:hip"])
def test_shape_values_have_neighbours_too(fitted, name):
    _, recordings, _, _ = fitted
    model = Model.standard().with_effect(name)
    prepared = prepare(model, recordings)
    fit = identify(model, prepared.train, optimisers=())
    near = neighbours(fit, model, prepared, recordings)
    assert all(row.size == len(fit.estimates) for row in near.values) and len(near.values) == 2
