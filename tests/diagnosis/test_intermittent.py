"""What acts from outside in part of the time is suspected, and nothing else accused; a stop or a load is not it."""

from dataclasses import replace

import numpy as np
import pytest

from exoid.diagnosis.comparison import compare
from exoid.diagnosis.discovery import discover
from exoid.diagnosis.evidence import intermittent as module
from exoid.diagnosis.evidence.best_effects import may_be_explained
from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.diagnosis.evidence.intermittent import intermittent
from exoid.diagnosis.rules import RULES
from exoid.measurement.auditing import trimmed
from exoid.measurement.auditing.convention import check_conventions
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.measurement.bench.walk import Walk
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.force import Force
from exoid.symbolic.joints import Joint
from exoid.symbolic.mechanics.pushed import placed_joints, pushed_torques
from exoid.symbolic.model import Model
from tests.walking import on_the_ground, walked

MODEL = Model.standard()
PREDICTED = replace(RULES, unexplained_share=10.0)
"""Rules by which curves predict everything."""


def fitted(recordings):
    prepared = prepare(MODEL, recordings[:-1], recordings[-1:])
    return fitted_model(identify(MODEL, prepared.train, optimisers=()), prepared)


@pytest.fixture(scope="module")
def walks():
    return [on_the_ground(seed) for seed in range(3)]


def with_torque(change):
    """Return what is found in three walks in the air with a torque (N, 2) made by change(recording, rng)."""
    out = []
    for seed in range(3):
        one = walked(seed)[0]
        out.append(replace(one, tau=one.tau + change(one, np.random.default_rng(seed))))
    return fitted(out)


@pytest.mark.slow
def test_a_foot_on_the_ground_is_suspected_with_its_size(walks):
    found = intermittent(fitted(walks))
    stance = np.mean([walked(seed)[2].mean() for seed in range(3)])
    assert abs(found.share - stance) < 0.12
    assert 0.6 < found.seconds < 1.1 and 1.1 < found.period < 1.6
    pushed = np.concatenate([walked(seed)[1][walked(seed)[2]] for seed in range(3)])
    assert np.allclose(found.torque, np.sqrt(np.mean(pushed**2, axis=0)), rtol=0.2)
    assert np.all(found.quiet < 0.7)
    assert "upwards" in found.force


@pytest.mark.slow
def test_no_channel_is_accused_and_no_effect_named(walks):
    answer = discover(MODEL, walks[:2], walks[2:])
    assert answer.verdict == "unexplained" and not answer.accepted
    assert "outside the model" in answer.sentence and "ground" in answer.sentence
    assert "grf_z" in answer.next_experiment and "contact" in answer.next_experiment
    said = [one for one in compare(MODEL, walks[:2], walks[2:]).audit if one.severity == "warning"]
    assert "outside" in {one.check for one in said}
    assert not {"convention", "sign", "scale", "channels", "units"} & {one.check for one in said}


def test_in_the_air_nothing_is_suspected():
    assert intermittent(with_torque(lambda one, rng: np.zeros(one.tau.shape))) is None


@pytest.mark.slow
def test_contact_is_no_convention(walks, monkeypatch):
    assert check_conventions(walks) == ()
    monkeypatch.setattr(trimmed, "PART", 0.95)
    assert check_conventions(walks)


@pytest.mark.slow
def test_a_third_of_the_time_is_enough_although_the_search_begins_with_more(walks, monkeypatch):
    base = fitted(walks)
    assert intermittent(base) is not None
    monkeypatch.setattr(trimmed, "PART", 0.8)
    assert intermittent(base) is not None


@pytest.mark.slow
@pytest.mark.parametrize(("knee", "ground"), [(0.9, False), (1.7, True)])
def test_what_hardly_moves_one_of_the_joints_is_no_ground(knee, ground, monkeypatch):
    """A push that follows the motion, 30 N·m at the hip; at the knee it is 2.2 and 4 times the error of the rest."""

    def bent(one, rng):
        push = np.clip((one.q[:, 0] - 0.1) / 0.05, 0.0, 1.0)
        return np.outer(push, [30.0, knee])

    monkeypatch.setattr(module, "_force", lambda *asked: "it moves as a force upwards would")
    assert (intermittent(with_torque(bent)) is not None) is ground


@pytest.mark.slow
def test_an_end_stop_is_no_contact(monkeypatch):
    base = with_torque(lambda one, rng: np.column_stack([400.0 * np.maximum(one.q[:, 0] - 0.4, 0.0), 0.0 * one.t]))
    loose = replace(RULES, most=0.0, artefact=1.0)
    monkeypatch.setattr(module, "_beyond_curves", lambda *given: True)
    assert intermittent(base, loose) is None
    monkeypatch.setattr(module, "most_effects", lambda base, rules: base)
    assert intermittent(base, loose) is not None and may_be_explained(base, RULES)  # an effect is the better answer


@pytest.mark.slow
def test_what_is_now_small_now_large_has_no_quiet_part():
    def hand(one, rng):
        slow = np.sin(np.outer(one.t, rng.uniform(1.0, 6.0, 5)) + rng.uniform(0.0, 6.0, 5)).sum(axis=1)
        return np.column_stack([slow**3, 0.5 * slow**3])

    base = with_torque(hand)
    assert intermittent(base) is None
    assert intermittent(base, replace(RULES, most=0.0)) is not None


@pytest.mark.slow
def test_a_load_that_hangs_there_twice_is_no_contact(monkeypatch):
    def load(one, rng):
        since = one.t - rng.uniform(4.0, 6.0)
        hangs = ((since > 0.0) & (since < 4.0)) | ((since > 7.0) & (since < 11.0))
        return np.where(hangs, 40.0 * (1.0 + np.sin(3.0 * one.t)), 0.0)[:, None] * np.array([1.0, 0.5])

    base = with_torque(load)
    assert intermittent(base) is None
    monkeypatch.setattr(module, "TIMES", 2.0)
    assert intermittent(base) is not None


def test_a_bump_that_curves_blur_is_no_contact():
    base = with_torque(lambda one, rng: np.outer(20.0 * np.exp(-(((one.q[:, 0] - 0.3) / 0.05) ** 2)), (1.0, 0.0)))
    assert intermittent(base) is None


@pytest.mark.slow
def test_a_light_foot_of_the_bench_is_suspected():
    runs = simulate_runs(3, seed=4, bench=Bench(duration=20.0, walk=Walk(load=150.0), measured=()))
    found = intermittent(fitted([run.recording for run in runs]))
    assert 0.55 < found.share < 0.75 and 1.2 < found.period < 1.8 and "upwards" in found.force


@pytest.mark.slow
def test_contact_is_contact_although_curves_in_the_motion_predict_it(walks, monkeypatch):
    base = fitted(walks)
    assert intermittent(base, PREDICTED) is not None
    monkeypatch.setattr(module, "_force", lambda *given: "")
    assert "foot" in intermittent(base, PREDICTED).foot
    monkeypatch.setattr(module, "_foot", lambda *given: "")
    assert intermittent(base, PREDICTED) is None


@pytest.mark.slow
@pytest.mark.parametrize(("late", "ground"), [(0.0, True), (0.25, False)])
def test_what_acts_while_the_foot_moves_one_way_is_the_ground_whichever_way_it_pushes(late, ground):
    """As on a person's leg, whose foot reaches beyond the link: torques change their signs in stance. Between steps, a
    quarter of a second late, it is no foot.
    """
    def stance(one, rng):
        size = np.hypot(*walked(int(one.name[-1]))[1].T)[:, None]
        turning = np.column_stack([np.sin(3.0 * one.t), np.cos(3.0 * one.t)])
        return np.roll(size * turning, round(late * one.rate), axis=0)

    base = with_torque(stance)
    found = intermittent(base, PREDICTED)
    assert (found is not None) is ground
    if ground:
        assert not found.force and "backwards while it acts" in found.foot
    assert (intermittent(base, replace(PREDICTED, most=1.0 if ground else 0.5)) is None) is ground


@pytest.mark.slow
def test_soft_ground_at_a_height_is_contact_although_it_is_a_function_of_the_angles():
    def ground(one, rng):
        height = 1.0 - 0.4 * np.cos(one.q[:, 0]) - 0.43 * np.cos(one.q.sum(axis=1))
        push = 4000.0 * np.maximum(np.quantile(height, 0.45) - height, 0.0)
        shin = 0.43 * np.sin(one.q.sum(axis=1))
        return -push[:, None] * np.column_stack([0.4 * np.sin(one.q[:, 0]) + shin, shin])

    assert "upwards" in intermittent(with_torque(ground)).force


def test_a_hard_stop_is_no_contact():
    base = with_torque(lambda one, rng: np.outer(1000.0 * np.maximum(one.q[:, 0] - 0.45, 0.0), (1.0, 0.0)))
    assert intermittent(base) is None


@pytest.mark.slow
def test_three_joints_tell_where_the_foot_is():
    model = Model("leg with ankle", joints=tuple(Joint(name, length=0.4) for name in ("hip", "knee", "ankle")))
    at, out = Force("ground", "ankle", ("grf_x", "grf_z")), []
    for index, run in enumerate(simulate_runs(3, model, seed=2, bench=Bench(duration=20.0))):
        one, rng = run.recording, np.random.default_rng(index)
        begins = np.arange(1.0, 19.0, 1.5) + rng.uniform(0.0, 0.3, 12)
        part = np.clip((one.t[:, None] - begins) / 0.8, 0.0, 1.0)
        force = np.column_stack([0.0 * one.t, (np.sin(np.pi * part) * rng.uniform(100.0, 200.0, 12)).sum(axis=1)])
        pushed = pushed_torques(placed_joints(model), one.q, at, 0.12, force)
        out.append(replace(one, tau=one.tau + pushed))
    prepared = prepare(model, out[:-1], out[-1:])
    found = intermittent(fitted_model(identify(model, prepared.train, optimisers=()), prepared))
    assert "0.12 m along" in found.force and "upwards" in found.force
