"""Filters as sums of modes against SciPy's recursions."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import signal

from exoid.measurement.signals import bridging as bridges_of
from exoid.measurement.signals import butterworth, compiled
from exoid.measurement.signals.bridging import bridging
from exoid.measurement.signals.butterworth import band_pass_filter, both_ways, low_pass_filter
from exoid.measurement.signals.conditioning import low_pass, low_pass_at, wave_products, welch
from exoid.symbolic.waves import Waves

RNG = np.random.default_rng(4)


@pytest.mark.parametrize(("order", "share"), [(4, 0.1), (4, 0.004), (4, 0.95), (2, 0.3)])
@pytest.mark.parametrize("samples", [70, 128, 3001])
def test_a_low_pass_is_that_of_scipy(order, share, samples):
    x = RNG.standard_normal((samples, 2, 3)).cumsum(axis=0)
    pad = min(samples - 1, int(6.0 / share))
    wanted = signal.sosfiltfilt(signal.butter(order, share, output="sos"), x, axis=0, padlen=pad)
    np.testing.assert_allclose(both_ways(low_pass_filter(order, share), x, pad), wanted, atol=1e-11 * np.abs(x).max())


@pytest.mark.parametrize("band", [(0.1, 0.3), (0.02, 0.9)])
def test_a_band_pass_is_that_of_scipy(band):
    x = RNG.standard_normal((700, 4))
    wanted = signal.sosfiltfilt(signal.butter(2, band, "bandpass", output="sos"), x, axis=0, padlen=0)
    np.testing.assert_allclose(both_ways(band_pass_filter(2, *band), x, 0), wanted, atol=1e-12)


CASES = [(5.0, 50, 3, 3000), (12.0, 0, 1, 700), (3.0, 9, 11, 900)]


@pytest.mark.parametrize(("cutoff", "first", "step", "samples"), CASES)
def test_kept_samples_are_those_of_the_whole_filter(cutoff, first, step, samples):
    x = RNG.standard_normal((samples, 5)).cumsum(axis=0)
    kept = np.arange(first, samples - first, step)
    whole = both_ways(low_pass_filter(4, cutoff / 50.0), x, min(samples - 1, int(1000.0 / cutoff)))[kept]
    np.testing.assert_allclose(low_pass_at(x.T.copy(), cutoff, 100.0, kept).T, whole, atol=1e-6 * np.abs(x).max())


@pytest.mark.parametrize(("cutoff", "first", "step", "samples"), [*CASES, (5.0, 50, 3, 310)])
@pytest.mark.parametrize("rows", [1, 8, 21])
def test_c_filters_as_products_do(cutoff, first, step, samples, rows):
    x = RNG.standard_normal((rows, samples)).cumsum(axis=1)
    one, count, reach = low_pass_filter(4, cutoff / 50.0), -(-(samples - 2 * first) // step), int(670.0 / cutoff)
    library = butterworth.row_library(one.poles.size)
    if library is None:
        pytest.skip("no compiler here")
    wanted = butterworth._by_products(one, x, first, step, count, reach)
    found = butterworth._compiled(library, one, x, first, step, reach, np.empty((rows, count)))
    np.testing.assert_allclose(found, wanted, atol=1e-12 * np.abs(x).max())


@pytest.mark.parametrize("hidden", [[(5, 9)], [(0, 30), (31, 33), (200, 310)], [(0, 310)], []])
@pytest.mark.parametrize("shape", [(9, 310), (4, 3, 310)])
def test_c_bridges_as_numpy_does(hidden, shape, monkeypatch):
    mask = np.zeros(310, dtype=bool)
    for first, last in hidden:
        mask[first:last] = True
    one, found = bridging(mask, 100.0), RNG.standard_normal((*shape[:-1], 2, shape[-1]))
    wanted = found.copy()
    one.across(found[..., 1, :])
    monkeypatch.setattr(bridges_of, "row_library", lambda poles: None)
    one.across(wanted[..., 1, :])
    np.testing.assert_allclose(found, wanted, atol=1e-13)


@pytest.mark.parametrize(("pairs", "joints", "count"), [(1, 1, 8), (2, 2, 37), (1, 2, 70)])
def test_products_of_waves_are_those_of_filtered_rows(pairs, joints, count):
    samples, kept = 900, np.arange(9, 891, 11)
    phase = RNG.standard_normal(samples).cumsum() * 0.1
    waves, shapes = Waves(RNG.standard_normal((pairs, joints, samples)), phase, 1), np.zeros((count, 2))
    shapes[:, 1] = np.linspace(0.5, 30.0, count)
    bridges = [bridging(RNG.random(samples) < 0.1 * k, 100.0) for k in range(joints)]
    weights, signals = RNG.random((3, joints, kept.size)), RNG.standard_normal((2, joints, kept.size, 5))
    found = wave_products(waves, shapes, bridges, 3.0, 100.0, kept, weights, signals)
    if found is None:
        pytest.skip("no compiler here")
    rows = np.ascontiguousarray(np.swapaxes(waves(shapes), 1, 2))
    for joint, bridge in enumerate(bridges):
        bridge.across(rows[:, :, joint])
    x = low_pass_at(rows.reshape(-1, samples), 3.0, 100.0, kept).reshape(count, 2 * pairs, joints, kept.size)
    np.testing.assert_allclose(found.both, np.einsum("vmak,uakq->uvmq", x, signals), atol=1e-11)
    np.testing.assert_allclose(found.square, np.einsum("vmak,vnak,uak->uvmn", x, x, weights), atol=1e-11)
    np.testing.assert_allclose(found.largest, (x**2).max(axis=(1, 2)), atol=1e-12)


@pytest.mark.parametrize("size", [1, 2, 3, 200])
def test_banded_equations_are_solved_as_scipy_does(size, monkeypatch):
    bands = np.stack([RNG.uniform(-1.0, 1.0, size), RNG.uniform(-1.0, 1.0, size), RNG.uniform(4.5, 6.0, size)])
    right = RNG.standard_normal(size)
    upper = sum((np.diag(bands[2 - k, k:], k) for k in (1, 2) if k < size), np.zeros((size, size)))
    full = np.diag(bands[2]) + upper + upper.T
    np.testing.assert_allclose(full @ compiled.solved_banded(bands, right), right, atol=1e-12)
    if size > 2:
        found = compiled.solved_banded(bands, right)
        monkeypatch.setattr(compiled, "row_library", lambda poles: None)
        np.testing.assert_allclose(found, compiled.solved_banded(bands, right), atol=1e-12)


def test_a_recording_shorter_than_the_response_is_filtered_as_a_whole():
    x = RNG.standard_normal((60, 2))
    kept = np.arange(5, 55, 2)
    np.testing.assert_array_equal(low_pass_at(x.T.copy(), 3.0, 100.0, kept).T, low_pass(x, 3.0, 100.0)[kept])


@pytest.mark.parametrize("length", [100, 101, 640])
def test_the_spectrum_is_that_of_scipy(length):
    x = RNG.standard_normal((640, 2)).cumsum(axis=0)
    frequency, power = welch(x, 50.0, length)
    wanted = signal.welch(x, 50.0, nperseg=length, detrend="linear", axis=0)
    np.testing.assert_allclose(frequency, wanted[0])
    np.testing.assert_allclose(power, wanted[1], rtol=1e-9, atol=1e-15)
