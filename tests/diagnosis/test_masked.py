"""Torques that are left out leak into nothing: however many are hidden, and wherever, 15 s of motion are enough."""

from dataclasses import replace

import numpy as np
import pytest

from exoid.diagnosis.comparison import compare
from exoid.diagnosis.discovery import discover
from exoid.measurement.bench.hidden import Hidden
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.symbolic.model import Model

LEG = Model.standard()


@pytest.fixture(scope="module")
def runs():
    hidden = [Hidden("load_friction", "knee", size=0.3)]
    return [run.recording for run in simulate_runs(3, effects=hidden, seed=2, bench=Bench(duration=30.0))]


def masked(one, kept):
    """The recording with torques where `kept` (N,) is true alone."""
    return replace(one, torque_valid=one.torque_valid & kept[:, None])


def in_each_second(one, share, rng):
    """Which samples are left where `share` of each second is hidden, in one piece anywhere in it."""
    second = round(one.rate)
    width, kept = round(share * second), np.ones(len(one), dtype=bool)
    for first in range(0, len(one), second):
        begin = first + int(rng.integers(0, second - width + 1))
        kept[begin : begin + width] = False
    return kept


def named_and_left(recordings, whole):
    """What is accepted, and the error of its numbers on a whole recording that was not fitted."""
    found = discover(LEG, recordings[:2], recordings[2:])
    return [one.name for one in found.accepted], compare(found.fit, whole[:2], whole[2:]).verify_rms


@pytest.fixture(scope="module")
def of_all(runs):
    return named_and_left(runs, runs)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.1, 0.45, 0.65])
def test_what_is_hidden_anywhere_changes_neither_the_name_nor_the_error(runs, of_all, share):
    rng = np.random.default_rng(5)
    names, left = named_and_left([masked(one, in_each_second(one, share, rng)) for one in runs], runs)
    assert names == of_all[0] == ["load_friction:knee"]
    assert left == pytest.approx(of_all[1], rel=0.1)


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["a quarter of each second of a minute", "a second of every six"])
def test_fifteen_seconds_are_enough(runs, of_all, kind):
    rng = np.random.default_rng(5)
    if kind.startswith("a quarter"):
        some = [masked(one, in_each_second(one, 0.75, rng) & (one.t < 20.0)) for one in runs]
    else:
        some = [masked(one, one.t % 6.0 < 1.0) for one in runs]
    assert sum(one.torque_valid.all(axis=1).sum() / one.rate for one in some) < 15.1
    names, left = named_and_left(some, runs)
    assert names == of_all[0]
    assert left == pytest.approx(of_all[1], rel=0.1)


def test_a_fit_is_held_against_recordings_of_another_length(runs):
    some = [masked(one, one.t < 8.0) for one in runs]
    fit = compare(LEG, some[:1]).fit
    found = compare(fit, runs[1:2], runs[2:])
    assert found.thigh_length is None and np.all(found.verify_rms < 3.0)
