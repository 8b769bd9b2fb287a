"""Spikes of a force at 1 kHz are taken off before it is decimated; its jumps are not."""

import numpy as np
import pytest

from measurement.signals.conditioning import spikes

T = np.arange(0.0, 10.0, 1e-3)


def force(wide: int) -> np.ndarray:
    """A command that jumps by 80 N twenty times and is taken back within 20 ms; noise, and spikes of `wide` samples."""
    since = T % 0.5
    jumps = 80.0 * np.where((T % 1.0) < 0.5, 1.0, -1.0) * np.exp(-since / 0.02)
    out = 20.0 * np.sin(2.0 * T) + jumps + 0.3 * np.random.default_rng(0).standard_normal(T.size)
    for k in range(wide):
        out[300 + k :: 500] += 30.0
    return out[:, None]


def test_a_jump_is_no_spike():
    found, _ = spikes(force(0), 1000.0)
    assert found.mean() < 2e-4


@pytest.mark.parametrize("wide", [1, 2, 3])
def test_a_spike_of_a_few_milliseconds_is(wide):
    found, middle = spikes(force(wide), 1000.0)
    hit = np.zeros(T.size, bool)
    for k in range(wide):
        hit[300 + k :: 500] = True
    assert found[hit, 0].mean() > 0.95 and found[~hit, 0].mean() < 1e-3
    assert np.abs(middle[hit, 0] - force(0)[hit, 0]).max() < 3.0
