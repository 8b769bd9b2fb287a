"""Strides: walks are cut into them, other motions are not; what is told over the stride."""

import numpy as np
import pytest

from exoid.diagnosis.comparison import compare
from exoid.diagnosis.evidence import strides as module
from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.diagnosis.evidence.look_alikes import joint_losses
from exoid.measurement.bench.simulation import Bench, simulate
from exoid.measurement.bench.walk import Walk
from exoid.measurement.forces import pushed_model
from exoid.measurement.recording import Recording
from exoid.measurement.stance import stances_of
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation import strides as cutting
from exoid.optimisation.preparation.prepare import prepare
from exoid.optimisation.preparation.strides import PHASES, cut_into_strides
from exoid.symbolic.model import Model


@pytest.fixture(scope="module")
def walked():
    bench = Bench(duration=20.0, walk=Walk(stride=1.3))
    return compare(Model.standard(), [simulate(seed=1, bench=bench)], [simulate(seed=2, bench=bench)])


def test_a_walk_is_cut_into_its_strides(walked):
    found = walked.strides
    assert 12 <= found.count <= 15 and found.seconds == pytest.approx(1.3, rel=0.05)
    assert found.shortest < found.seconds < found.longest
    assert found.measured.shape == (2, PHASES) and found.sentence.startswith(f"{found.count} strides of 1.3 s")
    assert walked.to_json()["strides"]["count"] == found.count
    assert any(title == "Torque and error over the stride" for title, _, _ in walked.figures())


def test_curves_over_the_stride_are_those_of_torque_model_and_error(walked):
    found = walked.strides
    left = found.measured - found.model - found.error
    assert np.nanmax(np.abs(left)) < 1e-9
    assert np.all(found.apart > 5.0 * found.error_apart)
    assert np.all(found.error_apart < 2.0 * walked.noise_floor)


def test_a_motion_that_was_drawn_has_none():
    runs = [simulate(seed=seed, bench=Bench(duration=20.0)) for seed in (1, 2)]
    found = compare(Model.standard(), runs[:1], runs[1:])
    assert found.strides is None and found.to_json()["strides"] is None


def cut(q, stances=None, rate=25.0):
    return cut_into_strides(q, np.arange(len(q)) / rate, stances, np.ones(q.shape[1]))


@pytest.mark.parametrize(("spread", "alike"), [(0.2, True), (0.8, False)])
def test_strides_of_very_different_sizes_are_not_laid_over_one_another(spread, alike, monkeypatch):
    t = np.arange(0.0, 30.0, 0.04)
    size = 1.0 + spread * np.random.default_rng(0).choice([-1.0, 1.0], 31)[(t // 1.0).astype(int)]
    one = np.column_stack([size * np.sin(2.0 * np.pi * t), 0.0 * t])
    assert (cut(one) is not None) == alike
    monkeypatch.setattr(cutting, "ALIKE", 2.0 if not alike else 0.05)
    assert (cut(one) is not None) != alike


def test_what_stands_or_stops_has_none():
    t = np.arange(0.0, 30.0, 0.04)
    assert cut(np.zeros((len(t), 2))) is None
    assert cut(np.sin(2.0 * np.pi * t)[:, None] * (t < 8.0)[:, None]) is None


@pytest.mark.slow
def test_where_contact_is_measured_strides_begin_at_the_step():
    walk = Walk(stride=1.3, stance=0.6)
    for measured in (("plate",), ("switch",)):
        bench = Bench(duration=20.0, walk=walk, measured=measured)
        found = compare(Model.standard(), [simulate(seed=1, bench=bench)], [simulate(seed=2, bench=bench)]).strides
        assert found.joint is None and found.stance == pytest.approx(0.6, abs=0.04)  # loaded from a twentieth on
        assert "from one step of the foot to its next" in found.sentence


def test_what_is_held_out_of_a_lone_walk_is_whole_strides_and_its_losses_are_compared_stride_against_stride():
    walk = simulate(seed=1, bench=Bench(duration=20.0, walk=Walk(stride=1.3), measured=("plate",)))
    model = pushed_model(Model.standard(), [walk])
    prepared = prepare(model, [walk])
    fitted = fitted_model(identify(model, prepared.train, optimisers=()), prepared)
    one, evidence = prepared.train[0], fitted.evidence(seed=0, draws=0)
    steps, units = one.strides.starts(len(one.kept)), evidence.blocks[0].fold
    borders = np.flatnonzero(np.diff(units)) + 1
    assert len(borders) == evidence.rules.blocks - 1 and {*borders} <= {*steps}
    assert np.abs(borders / len(units) - [0.25, 0.5, 0.75]).max() < 0.6 * 1.3 / 20.0
    blank = [Columns((0, 1), np.ones((1, 2, len(one.kept), 1)))]
    assert joint_losses(evidence, blank).shape[1] == len(steps)


def test_a_foot_that_is_seen_once_does_not_cut_a_walk():
    t = np.arange(0.0, 30.0, 0.04)
    q = np.column_stack([np.sin(2.0 * np.pi * t), np.cos(2.0 * np.pi * t)])
    steps = np.arange(0.25, 28.0)
    every = cut(q, np.column_stack([steps, steps + 0.6]))
    assert every.joint is None and every.stance == pytest.approx(0.6) and len(every.ends) == len(steps) - 1
    assert cut(q, np.array([[3.25, 3.85], [4.25, 4.85], [5.25, 5.85]])).joint == 0


def test_a_switch_that_bounces_makes_no_step():
    t = np.arange(0.0, 10.0, 0.01)
    contact = ((t % 1.25) < 0.7).astype(float)
    contact[[20, 21, 90, 91]] = 1.0 - contact[[20, 21, 90, 91]]
    one = Recording("one", t, np.zeros((len(t), 2)), np.zeros((len(t), 2)), contact=contact)
    found = stances_of(one)
    assert found[:, 0] == pytest.approx(1.25 * np.arange(1, 1 + len(found)), abs=0.02) and len(found) >= 6
    assert np.diff(found, axis=1) == pytest.approx(0.7, abs=0.02)


def test_the_share_that_comes_again_is_that_of_the_mean_stride():
    rng = np.random.default_rng(0)
    rest = 2.0 * np.sin(np.linspace(0.0, 6.0, PHASES)) + rng.standard_normal((200, 1, PHASES))
    rest[rng.random(rest.shape) < 0.2] = np.nan
    part = 4.0 * np.mean(np.sin(np.linspace(0.0, 6.0, PHASES)) ** 2)
    assert module._again(rest) == pytest.approx(part / (part + 1.0), abs=0.03)
    assert module._again(rng.standard_normal((200, 1, PHASES)))[0] < 0.05
