"""Each effect hidden in a random leg on the virtual bench, and found: three motions to fit, one to verify."""

from __future__ import annotations

import numpy as np
import pytest

from exoid.diagnosis.discovery import discover
from exoid.measurement.bench.hidden import parse_hidden
from exoid.measurement.bench.leg import random_leg, standard_leg
from exoid.measurement.bench.simulation import simulate_runs
from exoid.symbolic.model import Model

HIDDEN = (
    "stribeck:hip=c=2.6,v_s=0.15",
    "stribeck:knee=c=2.2,v_s=0.15",
    "viscous_quadratic:hip=4",
    "viscous_quadratic:knee=3",
    "torque_offset:hip=1.5",
    "torque_offset:knee=1.2",
    "load_friction:hip=0.15",
    "load_friction:knee=0.22",
    "joint_spring:hip=k=8,c=-5",
    "joint_spring:knee=k=4,c=3",
    "end_stop:hip=c=35,theta_s=0.9,side=1",
    "end_stop:knee=c=25,theta_s=-1.2,side=-1",
    "rotor_inertia:knee=0.15",
    "com_offset_shank=0.12",
    "gravity_tilt=0.05",
    "torque_ripple:hip=a=0.8,b=0.3,n=31",
    "torque_ripple:knee=a=0.8,b=0,n=24",
    "time_delay:hip=0.02",
    "time_delay:knee=0.03",
    "hysteresis:hip=c=2.5,sigma=25",
    "hysteresis:knee=c=2,sigma=25",
)


@pytest.mark.slow
@pytest.mark.parametrize("text", HIDDEN, ids=lambda t: t.partition("=")[0])
def test_hidden_effect_is_found(text):
    hidden = parse_hidden(text)
    seed = sum(map(ord, text))
    leg = random_leg(np.random.default_rng(seed))
    runs = [r.recording for r in simulate_runs(4, None, leg, effects=(hidden,), seed=seed)]
    found = discover(Model.standard(thigh_length=leg.thigh_length), runs[:3], runs[3:])
    named = [{a.name, *a.look_alikes} for a in found.accepted]
    assert found.verdict in ("missing", "ambiguous"), found
    assert any(hidden.name in group for group in named), found
    assert len(named) == 1, f"more than was hidden: {found}"
    first, last = found.steps[0], found.steps[-1]
    assert np.min(last.verify_rms / first.verify_rms) < 0.95


@pytest.mark.slow
@pytest.mark.parametrize("joint", ["hip", "knee"])
def test_a_known_mass_tells_whose_gain_is_wrong(joint):
    hidden, leg = (parse_hidden(f"drive_gain:{joint}=0.08"),), standard_leg()
    bare = [r.recording for r in simulate_runs(3, None, leg, effects=hidden, seed=5)]
    heavy = simulate_runs(2, None, leg.with_payload(3.0, 0.35), effects=hidden, seed=6, name="heavy")
    loaded = [r.recording.with_payload(3.0, 0.35) for r in heavy]
    told = discover(Model.standard(), [*bare[:2], loaded[0]], [bare[2], loaded[1]])
    assert [(a.name, a.look_alikes) for a in told.accepted] == [(f"drive_gain:{joint}", ())], told
    (gain,) = told.accepted[0].parameters.values()
    assert gain.low < 0.08 < gain.high
    assert discover(Model.standard(), bare[:2], bare[2:]).verdict == "ambiguous"


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_nothing_hidden_nothing_named(seed):
    leg = random_leg(np.random.default_rng(seed))
    runs = [r.recording for r in simulate_runs(4, None, leg, seed=seed)]
    found = discover(Model.standard(thigh_length=leg.thigh_length), runs[:3], runs[3:])
    assert found.verdict == "adequate" and not found.accepted, found
