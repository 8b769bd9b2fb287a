"""What recordings would have shown is told where nothing is missing, and an effect of that size is found."""

from types import SimpleNamespace

import numpy as np
import pytest

from exoid.diagnosis import discover
from exoid.diagnosis.evidence import power
from exoid.diagnosis.evidence.power import Power, power_said
from exoid.diagnosis.report.sections import power as power_section
from exoid.measurement.bench.hidden import Hidden
from exoid.measurement.bench.leg import random_leg
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model

SEED = 3


def found(hidden=(), seconds=20.0):
    """Return what is said of four short runs of a leg, and of which model."""
    leg = random_leg(np.random.default_rng([SEED, 77]))
    model = Model.standard(thigh_length=leg.thigh_length)
    runs = simulate_runs(4, model, leg, effects=hidden, seed=SEED, bench=Bench(duration=seconds))
    recordings = [run.recording for run in runs]
    return discover(model, recordings[:3], recordings[3:])


@pytest.fixture(scope="module")
def nothing():
    return found()


def test_an_answer_that_nothing_is_missing_says_what_would_have_shown(nothing):
    assert nothing.verdict == "adequate" and nothing.power
    assert "usual size" in nothing.sentence
    told = {one["effect"]: one for one in nothing.to_json()["power"]}
    assert set(told["viscous_cubic"]) == {"effect", "joint", "parameter", "smallest", "usual", "unit", "would_show"}
    assert told["viscous_cubic"]["unit"] == "N·m·s³/rad³"


@pytest.mark.slow
def test_a_size_that_no_effect_has_is_none_that_would_have_shown(monkeypatch):
    monkeypatch.setattr(power, "LARGEST", 1.0)
    shown = found(seconds=8.0).power
    assert any(np.isinf(one.smallest) for one in shown)
    assert all(one.smallest <= one.usual or np.isinf(one.smallest) for one in shown)


@pytest.mark.slow
def test_what_is_so_large_is_found_and_what_is_much_smaller_is_not(nothing):
    size = next(one.smallest for one in nothing.power if one.name == "viscous_cubic:knee")
    large = found(Hidden("viscous_cubic", "knee", size=1.5 * size))
    assert "viscous_cubic:knee" in {name for one in large.accepted for name in (one.name, *one.look_alikes)}
    assert found(Hidden("viscous_cubic", "knee", size=0.1 * size)).verdict == "adequate"
    assert not large.power


@pytest.mark.slow
def test_less_motion_shows_less(nothing):
    short = {one.name: one.smallest for one in found(seconds=8.0).power}
    long = {one.name: one.smallest for one in nothing.power}
    assert np.median([short[name] / long[name] for name in short if np.isfinite(short[name] + long[name])]) > 1.0


def test_the_sentence_names_what_would_not_have_shown():
    shown = Power("stribeck", "hip", "c", 1.0, 5.0, "N·m")
    assert power_said([]) == ""
    assert power_said([shown]) == "Each effect of the catalogue would have shown at its usual size."
    hidden = [Power("stribeck", "knee", "c", 17.6, 5.0, "N·m"), Power("end_stop", "hip", "c", np.inf, 50.0, "N·m/rad")]
    text = power_said([shown, *hidden])
    assert text.startswith("At its usual size 1 of 3 effects would have shown; too little is said")
    assert "End stop at the hip (at any size); Stribeck friction at the knee (found from 17.6 N·m, usually 5)" in text
    assert power_said(hidden).startswith("At its usual size no effect would have shown")


def test_at_a_joint_that_slides_sizes_have_its_units_and_none_is_beyond_its_range():
    rail = Model("rail", gravity=0.0, joints=(Joint("rail", "prismatic"),))
    runs = [run.recording for run in simulate_runs(3, rail, seed=SEED, bench=Bench(duration=12.0))]
    told = {one.name: one for one in discover(rail, runs[:2], runs[2:]).power}
    assert told["stribeck:rail"].unit == "N" and told["viscous_cubic:rail"].unit == "N·s³/m³"
    at_the_rail = [one for one in told.values() if one.joint]
    assert not [one for one in at_the_rail if "rad" in one.unit]
    for one in at_the_rail:
        parameters = rail.with_effect(one.name).parameters
        most = {p.name.rpartition(".")[2]: p.max for p in parameters}.get(one.parameter)
        assert most is None or one.smallest <= most or one.smallest == np.inf


def test_the_report_has_what_would_have_shown_least_first(nothing):
    material = SimpleNamespace(diagnosis=nothing, model=nothing.model)
    shown = power_section.context(material)
    assert len(shown["rows"]) == len(nothing.power) and all(len(row) == len(shown["head"]) for row in shown["rows"])
    ratios = [one.smallest / one.usual for one in nothing.power]
    assert shown["rows"][0][-1] == nothing.power[int(np.argmax(ratios))].name
    assert power_section.context(SimpleNamespace(diagnosis=None, model=nothing.model)) is None
