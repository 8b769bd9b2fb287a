"""Strides: walks are cut into them, other motions are not; what is told over the stride."""

from types import SimpleNamespace

import numpy as np
import pytest

from exoid.diagnosis.compare import compare
from exoid.diagnosis.evidence import strides as module
from exoid.diagnosis.evidence.strides import PHASES, cut
from exoid.measurement.bench.simulation import Bench, simulate
from exoid.measurement.bench.walk import Walk
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


def recorded(q, rate=25.0):
    motion = SimpleNamespace(q=q)
    return SimpleNamespace(motion=motion, kept=np.arange(len(q)), kept_rate=rate, reach=np.ones(q.shape[1]))


@pytest.mark.shows("strides.ALIKE")
@pytest.mark.parametrize(("spread", "alike"), [(0.2, True), (0.8, False)])
def test_strides_of_very_different_sizes_are_not_laid_over_one_another(spread, alike, monkeypatch):
    t = np.arange(0.0, 30.0, 0.04)
    size = 1.0 + spread * np.random.default_rng(0).choice([-1.0, 1.0], 31)[(t // 1.0).astype(int)]
    one = recorded(np.column_stack([size * np.sin(2.0 * np.pi * t), 0.0 * t]))
    assert (cut(one) is not None) == alike
    monkeypatch.setattr(module, "ALIKE", 2.0 if not alike else 0.05)
    assert (cut(one) is not None) != alike


def test_what_stands_or_stops_has_none():
    t = np.arange(0.0, 30.0, 0.04)
    assert cut(recorded(np.zeros((len(t), 2)))) is None
    assert cut(recorded(np.sin(2.0 * np.pi * t)[:, None] * (t < 8.0)[:, None])) is None


def test_the_share_that_comes_again_is_that_of_the_mean_stride():
    rng = np.random.default_rng(0)
    rest = 2.0 * np.sin(np.linspace(0.0, 6.0, PHASES)) + rng.standard_normal((200, 1, PHASES))
    rest[rng.random(rest.shape) < 0.2] = np.nan
    part = 4.0 * np.mean(np.sin(np.linspace(0.0, 6.0, PHASES)) ** 2)
    assert module._again(rest) == pytest.approx(part / (part + 1.0), abs=0.03)
    assert module._again(rng.standard_normal((200, 1, PHASES)))[0] < 0.05
