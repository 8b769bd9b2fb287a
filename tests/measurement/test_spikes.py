"""Spikes of a torque are found at any rate and any noise; its jumps, its ripple and its noise are none."""

import numpy as np
import pytest

from exoid.measurement.signals.spikes import far_off, spikes

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
    assert spikes(force(0), 1000.0).mean() < 5e-4


@pytest.mark.parametrize("wide", [1, 2, 3])
def test_a_spike_of_a_few_milliseconds_is(wide):
    found = spikes(force(wide), 1000.0)
    hit = np.zeros(T.size, bool)
    for k in range(wide):
        hit[300 + k :: 500] = True
    assert found[hit, 0].mean() > 0.95 and found[~hit, 0].mean() < 5e-3  # what lies among three in a row is hidden, too


def dense(strength: float, aligned: bool) -> np.ndarray:
    """A slow torque and a spike at every seventh sample: with its sign, or with any."""
    rng, slow = np.random.default_rng(2), np.sin(np.pi * T[::3])
    signs = np.sign(slow) if aligned else rng.choice([-1.0, 1.0], slow.size)
    pulses = strength * (rng.random(slow.size) < 0.15) * signs
    return (0.3 * slow + pulses + 0.02 * rng.standard_normal(slow.size))[:, None]


def test_the_chatter_of_a_drive_that_moves_its_machine_is_kept():
    assert far_off(dense(2.0, True), 333.0).mean() > 0.12 and not spikes(dense(2.0, True), 333.0).any()


def test_dense_spikes_of_any_sign_are_a_sensors():
    assert spikes(dense(6.0, False), 333.0).mean() > 0.12


def swing(rate: float, noise: float, seed: int) -> np.ndarray:
    """The torque (N, 1) of a joint with inertia, weight and viscous friction on a smooth motion."""
    t = np.arange(0.0, 20.0, 1.0 / rate)
    q = 0.8 * np.sin(2.2 * t) + 0.4 * np.sin(4.8 * t + 1.0)
    dq, ddq = np.gradient(q, 1.0 / rate), np.gradient(np.gradient(q, 1.0 / rate), 1.0 / rate)
    tau = 0.3 * ddq + 3.0 * np.sin(q) + 0.5 * dq
    return (tau + noise * np.random.default_rng(seed).standard_normal(t.size))[:, None]


@pytest.mark.parametrize("rate", [100.0, 500.0, 1000.0])
@pytest.mark.parametrize("noise", [0.005, 0.05, 0.5])
def test_eight_deviations_are_a_spike_and_noise_is_none(rate, noise):
    tau = swing(rate, noise, seed=1)
    rng = np.random.default_rng(2)
    hit = rng.random(tau.shape) < 0.03
    found = spikes(tau + np.where(hit, 8.0 * noise * rng.choice([-1.0, 1.0], tau.shape), 0.0), rate)
    assert found[hit].mean() > 0.93 and found[~hit].mean() < 0.004
    assert spikes(tau, rate).mean() < 0.004
    three = tau + np.where(hit, 3.0 * noise, 0.0)
    assert spikes(three, rate)[hit].mean() < 0.2


@pytest.mark.parametrize("jump", [0.5, 5.0, 50.0])
def test_dry_friction_that_reverses_is_no_spike(jump):
    tau = swing(100.0, 0.02, seed=3)
    t = np.arange(len(tau)) / 100.0
    back = jump * np.sign(2.2 * 0.8 * np.cos(2.2 * t) + 4.8 * 0.4 * np.cos(4.8 * t + 1.0))
    assert spikes(tau + back[:, None], 100.0).mean() < 0.005


def test_chatter_is_hidden_whole():
    rng = np.random.default_rng(5)
    tau = swing(100.0, 0.05, seed=5)
    burst = np.zeros(tau.shape, bool)
    for start in range(150, 2000, 300):
        burst[start : start + 15] = True
    found = spikes(tau + np.where(burst, 6.0 * rng.choice([-1.0, 1.0], tau.shape) * rng.random(tau.shape), 0.0), 100.0)
    assert found[burst].mean() > 0.7 and found[~burst].mean() < 0.005


def test_what_is_unknown_or_constant_has_no_spikes():
    tau = swing(100.0, 0.02, seed=4)
    unknown = np.zeros(tau.shape, bool)
    unknown[500:600] = True
    tau[500:600] += 50.0
    assert not spikes(tau, 100.0, unknown)[480:620].any()
    assert not spikes(np.full((500, 1), 3.0), 100.0).any()
    assert not spikes(np.zeros((0, 1)), 100.0).any()


def test_means_of_samples_judged_before_are_spikes_only_where_they_are_plain():
    tau = swing(100.0, 0.02, seed=6)
    hit = np.random.default_rng(7).random(tau.shape) < 0.01
    found = [far_off(tau + np.where(hit, size * 0.02, 0.0), 100.0, averaged=True)[hit].mean() for size in (4.5, 9.0)]
    assert found[0] < 0.5 and found[1] > 0.9


@pytest.mark.parametrize("period", [60, 110])
def test_beside_what_is_unknown_a_spike_is_found_as_elsewhere(period):
    noise, rng = 0.3, np.random.default_rng(5)
    tau = swing(100.0, noise, seed=4)
    hit = rng.random(tau.shape) < 0.03
    tau = tau + np.where(hit, 9.0 * noise * rng.choice([-1.0, 1.0], tau.shape), 0.0)
    place = np.arange(len(tau)) % period
    lost = (place < 0.6 * period)[:, None]
    edge = ~lost & ((place >= period - 3) | (place < 0.6 * period + 3))[:, None]
    found = spikes(np.where(lost, 0.0, tau), 100.0, lost)
    assert not found[lost].any()
    assert found[hit & ~lost].mean() > 0.9 and found[hit & edge].mean() > 0.85
    assert found[~hit & ~lost].mean() < 0.02


@pytest.mark.parametrize("length", [4, 5, 9])
def test_of_brief_chatter_the_samples_of_either_sign_are_found(length):
    noise, rng = 0.5, np.random.default_rng(8)
    tau = swing(100.0, noise, seed=8)
    false = np.zeros(tau.shape)
    for start in range(150, 2000, 100):
        k = np.arange(length)
        false[start : start + length, 0] = 6.0 * np.sin(rng.uniform(1.6, 3.1) * k + rng.uniform(0.0, 6.3))
    plain = np.abs(false) > 6.0 * noise
    found = spikes(tau + false, 100.0)
    assert found[plain].mean() > 0.94 and found[false == 0.0].mean() < 0.04
