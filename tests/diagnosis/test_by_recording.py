"""A recording that contradicts the others is named, with what it and what they say; none is named otherwise."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exoid.diagnosis.evidence.consistency import differing
from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.measurement.bench.hidden import parse_hidden
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.simulation import simulate_runs
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import Model

MODEL = Model.standard().with_effect("viscous_quadratic:knee")


@pytest.fixture(scope="module")
def recordings():
    """Four runs, each 20 s, of a leg with quadratic damping at the knee; the last with twice as much of it."""
    usual = simulate_runs(3, None, standard_leg(), effects=[parse_hidden("viscous_quadratic:knee=2")], seed=3)
    more = simulate_runs(4, None, standard_leg(), effects=[parse_hidden("viscous_quadratic:knee=4")], seed=3)
    return [run.recording for run in usual], more[3].recording


def asked(recordings):
    prepared = prepare(MODEL, recordings)
    now = fitted_model(identify(MODEL, prepared.train, optimisers=()), prepared)
    return differing(now, now.evidence(seed=0, draws=0))


def test_nothing_differs_where_nothing_was_changed(recordings):
    assert asked(recordings[0]) == ()


def test_an_effect_of_another_size_is_named(recordings):
    usual, more = recordings
    (one,) = [d for d in asked([*usual, more]) if d.name.startswith("viscous_quadratic")]
    assert one.recording == more.name
    assert one.value == pytest.approx(4.0, abs=0.5) and one.others == pytest.approx(2.0, abs=0.3)
    assert "in the others" in one.sentence and one.to_json()["sentence"] == one.sentence


def test_another_zero_of_a_torque_sensor_is_named(recordings):
    usual = recordings[0]
    moved = replace(usual[1], tau=usual[1].tau + np.array([0.0, -0.8]))
    (one,) = asked([usual[0], moved, usual[2]])
    assert (one.recording, one.name) == (usual[1].name, "zero:knee")
    assert one.value == pytest.approx(-0.8, abs=0.15) and "below" in one.sentence


def test_a_single_recording_has_no_others(recordings):
    assert asked(recordings[0][:1]) == ()
