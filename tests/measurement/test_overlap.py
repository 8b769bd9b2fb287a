"""Recordings that share samples are recognised by their samples; motion that was recorded again is not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement.overlap import held_apart, overlap
from exoid.measurement.recording import Recording, Source
from exoid.symbolic.joints import Joint

COUNT = 2400


def run(seed, motion=0, noise=1.0, count=COUNT, period=6.0, name=""):
    """Periodic motion number `motion` with noise of its own (angles 3e-4 rad, torques 0.1 N·m)."""
    rng, way = np.random.default_rng(seed), np.random.default_rng(1000 + motion)
    t = 0.01 * np.arange(count)
    w = 2 * np.pi / period * np.arange(1, 6)
    a, b = way.normal(0.0, 0.1, (2, 5, 4))
    clean = np.sin(t[:, None] * w) @ a + np.cos(t[:, None] * w) @ b
    clean[:, 2:] = 30.0 * clean[:, 2:] + 3.0 * np.sign(np.gradient(clean[:, :2], axis=0))
    noisy = clean + noise * rng.standard_normal(clean.shape) * [3e-4, 3e-4, 0.1, 0.1]
    return Recording(name or f"run{seed}", t, noisy[:, :2], noisy[:, 2:])


def cut(one, rows, name="other", **changes):
    return Recording(name, one.t[rows], one.q[rows], one.tau[rows], **changes)


def at(one, t):
    columns = [np.interp(t, one.t, c) for c in (*one.q.T, *one.tau.T)]
    return Recording("other", t, np.column_stack(columns[:2]), np.column_stack(columns[2:]))


ONE = run(1)


@pytest.mark.parametrize(
    ("other", "share"),
    [
        (cut(ONE, slice(None)), 1.0),
        (replace(ONE, name="later", t=ONE.t + 12.3), 1.0),
        (replace(ONE, name="clock", t=ONE.t * 1.1), 1.0),
        (replace(ONE, name="units", q=np.degrees(ONE.q), tau=-1000 * ONE.tau), 1.0),
        (cut(ONE, slice(700, 1400)), 1.0),
        (replace(ONE, name="digits", q=np.round(ONE.q, 3), tau=np.round(ONE.tau, 1)), 1.0),
        (cut(ONE, slice(1, None, 2)), 1.0),
        (at(ONE, np.arange(0.0, ONE.t[-1], 0.0125)), 0.95),
    ],
    ids=["copy", "later", "clock", "units", "piece", "digits", "half", "resampled"],
)
def test_a_copy_is_recognised(other, share):
    for first, second in ((ONE, other), (other, ONE)):
        found = overlap(first, second)
        assert found is not None
    assert overlap(ONE, other).share >= 0.9 * share
    with pytest.raises(RecordingError, match="shares samples with a fitted one") as error:
        held_apart([run(5, 5), ONE], [other])
    assert error.value.where == other.name and ONE.name in str(error.value)


def test_motion_recorded_again_is_no_copy():
    assert overlap(ONE, run(2)) is None
    assert overlap(ONE, run(2, count=1500)) is None
    assert overlap(ONE, run(2, motion=1)) is None
    quantised = [replace(one, q=np.round(one.q / 5e-4) * 5e-4) for one in (ONE, run(2))]
    assert overlap(*quantised) is None


def test_periods_of_one_recording_do_not_count_twice():
    whole = run(3)
    assert overlap(cut(whole, slice(0, 1200)), cut(whole, slice(1200, 2400))) is None


def test_motion_simulated_twice_without_noise_is_the_same_samples():
    assert overlap(run(1, noise=0.0), run(2, noise=0.0)) is not None
    assert overlap(run(1, noise=0.0), run(2, motion=1, noise=0.0)) is None


def test_pieces_joined_with_others_are_found_and_placed():
    other, m = run(7, 7), 800
    mixed = Recording(
        "mixed",
        ONE.t[: 2 * m],
        np.vstack([other.q[:m], ONE.q[m : 2 * m]]),
        np.vstack([other.tau[:m], ONE.tau[m : 2 * m]]),
    )
    found = overlap(ONE, mixed)
    assert not found.rows[: m - 40].any() and found.rows[m + 140 : 2 * m - 140].all()


def test_fitted_twice_counts_once():
    named = replace(ONE, source=Source("b.csv"))
    kept, unseen, (finding,) = held_apart([run(5, 5), ONE, named], [run(6, 6)])
    assert [one.name for one in kept] == ["run5", "run1"] and len(unseen) == 1
    assert finding.severity == "warning" and "b.csv holds the same samples as run1" in finding.what
    half = Recording("half", 0.01 * np.arange(2000), *(np.vstack([a[:1000], b[:1000]]) for a, b in (
        (ONE.q, run(8, 8).q), (ONE.tau, run(8, 8).tau))))  # fmt: skip
    kept, _, (finding,) = held_apart([half, ONE], [])
    assert [one.name for one in kept] == ["half", "run1"]
    assert not kept[0].valid[200:800].any() and kept[0].valid[1200:].all()


def test_little_or_dead_data_is_no_copy():
    still = Recording("still", ONE.t, ONE.q * 0.0, ONE.tau * 0.0)
    assert overlap(still, still) is None
    assert overlap(cut(ONE, slice(0, 20)), cut(ONE, slice(0, 20))) is None


def bench(seed, count=25000):
    """A drive at 1 kHz that makes the same strokes again: its encoder's grid sounds in the torque, each start jolts."""
    rng, t = np.random.default_rng(seed), 1e-3 * np.arange(count)
    speed = np.repeat([0.01515, -0.03, 0.1, -0.06, 0.02], count // 5)
    q = np.round(np.cumsum(speed) * 1e-3 / 1e-6 + 0.3 * seed) * 1e-6
    rough = np.gradient(q, t) - speed
    jolts = 300.0 * np.gradient(speed) * (1.0 + 0.01 * seed)
    tau = 20.0 * np.sign(speed) + 3e4 * rough + jolts + 0.3 * rng.standard_normal(count)
    return Recording(f"bench{seed}", t, q[:, None], tau[:, None], joints=(Joint("axis", "prismatic"),))


def test_strokes_made_again_by_a_drive_are_no_copy():
    one, again = bench(0), bench(1)
    assert overlap(one, again) is None
    assert overlap(one, replace(one, name="copy")).share == 1.0


def test_a_thinned_copy_is_recognised_of_any_machine():
    one = bench(0)
    rows = slice(0, None, 2)
    assert overlap(one, Recording("half", one.t[rows], one.q[rows], one.tau[rows], joints=one.joints)).share > 0.9


def noisier(one, times, seed=0):
    """The recording with so many times its own noise added."""
    rng = np.random.default_rng(seed)
    q, tau = (x + times * size * rng.standard_normal(x.shape) for x, size in ((one.q, 3e-4), (one.tau, 0.1)))
    return replace(one, name="noisier", q=q, tau=tau)


@pytest.mark.parametrize("step", [0.01, 0.0125, 0.0081], ids=["same rate", "slower", "quicker"])
@pytest.mark.parametrize("times", [0.3, 1.0])
def test_a_copy_that_was_resampled_and_given_noise_is_no_unseen_motion(step, times):
    copy = noisier(at(ONE, np.arange(0.0033, ONE.t[-1], step)), times)
    for fitted, held in ((ONE, copy), (copy, ONE)):
        with pytest.raises(RecordingError, match="shares samples with a fitted one"):
            held_apart([fitted], [held])


def test_a_copy_with_noise_counts_once():
    kept, _, (finding,) = held_apart([run(5, 5), ONE, noisier(ONE, 1.0)], [])
    assert [one.name for one in kept] == ["run5", "run1"] and "noisier holds the same samples as run1" in finding.what


@pytest.mark.parametrize("noise", [0.3, 1.0, 4.0])
def test_motion_recorded_again_by_other_sensors_is_no_copy(noise):
    assert overlap(ONE, run(2, noise=noise)) is None and overlap(run(2, noise=noise), ONE) is None


def jig(times, seed):
    """One waveform at `times` the speed: dry friction, and of an encoder that is as good as free of noise."""
    rng, t = np.random.default_rng(seed), 0.01 * np.arange(COUNT)
    q = np.round(0.1 * times * (1.0 - np.cos(np.pi * t / 3.0)), 5)
    speed = np.gradient(q, t)
    tau = 0.6 * np.tanh(speed / 0.002) + 0.05 * speed + 0.01 * rng.standard_normal(COUNT)
    return Recording(f"jig{times}", t, q[:, None], tau[:, None], joints=(Joint("axis"),))


def test_one_waveform_at_several_speeds_is_no_copy():
    runs = [jig(times, k) for k, times in enumerate((0.25, 0.5, 1.0, 2.0, 4.0))]
    kept, unseen, found = held_apart(runs[:-1], runs[-1:])
    assert len(kept) == 4 and len(unseen) == 1 and not found
