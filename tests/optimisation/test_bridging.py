"""Around standstill dry friction takes any value: whatever the torque does there must not reach the samples fitted."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.simulation import simulate_runs
from exoid.measurement.signals.bridging import BRIDGE_ENDS, bridging
from exoid.measurement.signals.conditioning import quiet_noise
from exoid.optimisation.fitting.assemble import assemble
from exoid.optimisation.linear.solve import solve_sse
from exoid.optimisation.preparation.noise import _apart
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import Model

RATE = 100.0


@given(st.lists(st.booleans(), min_size=1, max_size=60))
@settings(max_examples=60, deadline=None)
def test_a_bridge_uses_only_what_is_beside_it_and_keeps_what_is_level(hidden):
    hidden = np.array(hidden)
    matrix = np.eye(hidden.size)
    bridging(hidden, RATE).across(matrix)
    if not hidden.all():
        assert not matrix[hidden].any()
        assert matrix.sum(axis=0) == pytest.approx(np.ones(hidden.size))
    np.testing.assert_array_equal(matrix[:, ~hidden], np.eye(hidden.size)[:, ~hidden])


def test_a_straight_line_goes_on_straight():
    hidden = np.zeros(40, bool)
    hidden[15:22] = True
    ends = round(BRIDGE_ENDS * RATE)
    line = np.arange(40.0)
    bridging(hidden, RATE).across(line)
    bridged = line[hidden]
    assert np.all(np.diff(bridged) > 0.0)
    assert bridged[0] > 15 - ends and bridged[-1] < 21 + ends
    assert bridged.mean() == pytest.approx(18.0)


@pytest.mark.slow
def test_torque_near_standstill_is_of_no_consequence():
    model = Model.standard()
    recording = simulate_runs(1, None, standard_leg(), seed=2)[0].recording
    (one,) = prepare(model, [recording], cutoff=5.0).train
    beta = np.array([1.8, 0.4, 0.5, 0.2, 4.0, 2.0, 3.0, 1.2])
    exact = model.torque(one.motion, beta)
    rng = np.random.default_rng(0)
    wild = np.where(one.stuck, exact + rng.normal(0.0, 50.0, exact.shape), exact)
    assert one.stuck.any(axis=0).all()
    np.testing.assert_allclose(one.smooth(wild), one.smooth(exact), atol=1e-10)
    fitted = solve_sse(assemble(model, [replace(one, torque=one.smooth(wild))]))
    np.testing.assert_allclose(fitted, beta, rtol=1e-8)
    other = rng.normal(size=(2, len(one.motion), 3))
    by_column = [one.smooth(x.T) for x in np.moveaxis(other, 2, 0)]
    np.testing.assert_allclose(one.smooth_columns(other), np.stack(by_column, axis=2))


@pytest.mark.parametrize("seen", [3, 6, 12, 40])
def test_bridges_have_no_noise_to_tell_it_by(seen):
    rng = np.random.default_rng(0)
    hidden = np.ones((6000, 1), bool)
    for first in range(20, 5900, 50):
        hidden[first : first + seen] = False
    x = 0.4 * rng.standard_normal((6000, 1))
    at = np.flatnonzero(~hidden[:, 0])
    x[:, 0] = np.interp(np.arange(6000), at, x[at, 0])
    told = quiet_noise(x, 100.0, 1.0, _apart(hidden))
    assert 0.5 < told[0] / (0.4 * np.sqrt(1.0 / 50.0)) < 1.5
