"""Torques with memory, on clocks that are not even."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from exoid.ground.errors import EffectError
from exoid.symbolic.language.operators import MEMORY, dahl, ddt, delay, lag, play

signals = arrays(float, st.integers(1, 40), elements=st.floats(-3.0, 3.0))


@settings(deadline=None)
@given(signals, st.floats(0.0, 1.0))
def test_play_is_the_last_position_held_inside_the_gap(x, h):
    w, held = x[0], []
    for value in x:
        w = min(max(w, value - h), value + h)
        held.append(w)
    assert play(np.arange(len(x)), x, h).tolist() == held


@settings(max_examples=30, deadline=None)
@given(arrays(float, st.integers(2, 8), elements=st.floats(-0.1, 0.1)), st.floats(0.0, 60.0))
def test_dahl_is_the_solution_of_its_differential_equation(x, sigma):
    z, states, parts = 0.0, [0.0], 100
    for dx in np.diff(x) / parts:
        s = np.sign(dx)
        for _ in range(parts):  # Runge-Kutta, which knows nothing of exponentials
            k1 = sigma * (1.0 - z * s)
            k2 = sigma * (1.0 - (z + dx * k1 / 2) * s)
            k3 = sigma * (1.0 - (z + dx * k2 / 2) * s)
            k4 = sigma * (1.0 - (z + dx * k3) * s)
            z += dx * (k1 + 2 * k2 + 2 * k3 + k4) / 6
        states.append(z)
    np.testing.assert_allclose(dahl(np.arange(len(x)), x, sigma), states, atol=1e-6)


@settings(deadline=None)
@given(signals, st.lists(st.floats(1e-3, 1.0), min_size=40, max_size=40), st.just(0.0) | st.floats(1e-6, 5.0))
def test_lag_is_a_filter_of_first_order_on_any_clock(x, steps, constant):
    t, y, wanted = np.cumsum(steps)[: len(x)], x[0], [x[0]]
    for value, step in zip(x[1:], np.diff(t), strict=True):
        y += (value - y) * (1.0 - np.exp(-step / constant) if constant else 1.0)
        wanted.append(y)
    np.testing.assert_allclose(lag(t, x, constant), wanted, atol=1e-12)
    np.testing.assert_allclose(lag(t, x, np.array([[constant], [0.3]]))[0], wanted, atol=1e-12)


@settings(deadline=None)
@given(signals, st.floats(0.0, 1.0))
def test_play_stays_within_its_gap_and_moves_only_when_pushed(x, h):
    w = play(np.arange(len(x)), x, h)
    assert np.all(np.abs(w - x) <= h * (1 + 1e-12) + 1e-12)
    moved = np.diff(w) != 0.0
    pushed = np.abs(np.abs(w - x)[1:] - h) < 1e-9
    assert np.all(pushed[moved])


def test_play_without_a_gap_is_the_angle_itself():
    x = np.array([0.2, 0.5, -0.1])
    assert play(np.arange(3.0), x, 0.0).tolist() == x.tolist()


def test_play_lags_on_the_way_back():
    w = play(np.arange(5.0), np.array([0.0, 1.0, 0.9, 0.5, 0.9]), 0.2)
    np.testing.assert_allclose(w, [0.0, 0.8, 0.8, 0.7, 0.7])


@settings(deadline=None)
@given(signals, st.floats(0.0, 500.0))
def test_dahl_stays_between_minus_one_and_one_and_is_odd(x, sigma):
    z = dahl(np.arange(len(x)), x, sigma)
    assert np.all(np.abs(z) <= 1.0 + 1e-12)
    np.testing.assert_allclose(dahl(np.arange(len(x)), -x, sigma), -z, atol=1e-12)


@settings(deadline=None)
@given(signals.filter(lambda x: len(x) > 1), st.floats(10.0, 500.0), st.integers(2, 5))
def test_dahl_does_not_depend_on_how_finely_a_path_is_sampled(x, sigma, parts):
    at = np.arange(len(x), dtype=float)
    fine = np.linspace(0.0, len(x) - 1.0, (len(x) - 1) * parts + 1)
    z = dahl(at, x, sigma)
    np.testing.assert_allclose(dahl(fine, np.interp(fine, at, x), sigma)[::parts], z, atol=1e-9)


def test_dahl_builds_up_exponentially_after_a_reversal():
    x = np.concatenate([np.linspace(0.0, 1.0, 50), np.linspace(1.0, 0.9, 50)])
    z = dahl(np.arange(100.0), x, 30.0)
    np.testing.assert_allclose(z[:50], 1.0 - np.exp(-30.0 * x[:50]), atol=1e-12)
    np.testing.assert_allclose(z[50:], -1.0 + (1.0 + z[49]) * np.exp(-30.0 * (1.0 - x[50:])), atol=1e-12)


def uneven(n=400):
    rng = np.random.default_rng(5)
    return np.cumsum(0.01 * (0.5 + rng.random(n)))


def test_delay_moves_a_signal_and_holds_its_edges():
    t = uneven()
    x = np.sin(t)
    np.testing.assert_allclose(delay(t, x, 0.05)[20:], np.sin(t - 0.05)[20:], atol=1e-4)
    assert delay(t, x, 0.05)[0] == x[0]
    assert delay(t, x, -0.05)[-1] == x[-1]
    assert delay(t, x, 0.0).tolist() == x.tolist()


def test_delay_is_the_straight_line_between_two_samples():
    t = uneven(50)
    x = np.random.default_rng(6).normal(size=50)
    expected = []
    for at in t - 0.033:
        k = max(sum(t <= at) - 1, 0)
        share = max((at - t[k]) / (t[k + 1] - t[k]), 0.0)
        expected.append((1.0 - share) * x[k] + share * x[k + 1])
    np.testing.assert_allclose(delay(t, x, 0.033), expected, atol=1e-12)


def test_ddt_is_the_slope_of_the_parabola_through_three_samples():
    t = uneven(50)
    x = np.random.default_rng(7).normal(size=50)
    slopes = []
    for k in range(50):
        three = slice(min(max(k - 1, 0), 47), min(max(k - 1, 0), 47) + 3)
        slopes.append(np.polyfit(t[three] - t[k], x[three], 2)[1])
    np.testing.assert_allclose(ddt(t, x), slopes, rtol=1e-9, atol=1e-9)


def test_ddt_is_exact_for_a_parabola_on_an_uneven_clock():
    t = uneven()
    np.testing.assert_allclose(ddt(t, 3.0 * t**2 - t), 6.0 * t - 1.0, atol=1e-9)


@pytest.mark.parametrize("n", [1, 2, 3])
def test_short_recordings(n):
    t, x = np.arange(n, dtype=float), np.arange(n, dtype=float)
    for word, operator in MEMORY.items():
        out = operator(t, x) if word == "ddt" else operator(t, x, 0.1)
        assert out.shape == (n,)
        assert np.isfinite(out).all()


@pytest.mark.parametrize("operator", [play, dahl, lag])
@pytest.mark.parametrize("value", [-0.1, float("nan")])
def test_a_negative_parameter_is_refused(operator, value):
    with pytest.raises(EffectError, match="give a number that is not negative"):
        operator(np.arange(2.0), np.arange(2.0), value)


@pytest.mark.parametrize("word", sorted(MEMORY))
def test_a_long_recording_stays_finite(word):
    t = np.arange(100_000) * 1e-3
    x = np.sin(t) + 0.01 * np.sin(900.0 * t)
    parameter = () if word == "ddt" else (0.02,)
    out = MEMORY[word](t, x, *parameter)
    assert out.shape == t.shape and np.isfinite(out).all()
