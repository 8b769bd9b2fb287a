"""How a watch filters a stream, learns numbers from it, and says when a change began."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exoid.apps.watch.alarm import Detector
from exoid.apps.watch.course import onset
from exoid.apps.watch.front import FrontEnd, Samples
from exoid.apps.watch.recursive.estimator import Estimator, Pace
from exoid.apps.watch.scores import Scores
from exoid.apps.watch.window import window
from exoid.diagnosis.against.result import Course
from exoid.diagnosis.separation.result import Separation

SEEDS = range(60)
TWO = SimpleNamespace(parameters=[SimpleNamespace(name=name, unit="") for name in "ab"], inertial=())
"""What an estimator of two numbers asks of a model."""


def jump(seed: int) -> Course:
    t = np.arange(0.0, 120.0, 2.0)
    noise = 0.8 * np.random.default_rng(seed).standard_normal(t.size)
    return Course(t, (t >= 61.0) + noise, np.ones(t.size))


def test_the_interval_of_a_beginning_contains_it() -> None:
    found = [onset(jump(seed)) for seed in SEEDS]
    assert sum(one.low <= 61.0 <= one.high for one in found) >= 0.9 * len(SEEDS)


def test_a_jump_in_noise_is_not_called_slow() -> None:
    assert not any(onset(jump(seed)).slow for seed in SEEDS)


def estimated(rng: np.random.Generator, burst: float = 0.0) -> Estimator:
    """An estimator of two parameters after 60 s, of which the last half second may be a burst."""
    one = Estimator.start(
        TWO, np.zeros(2), np.full(2, 1e3), np.array([0.1]), 10.0, Pace(rest=20.0, block=1.0)
    )
    for k in range(600):
        row = rng.standard_normal((1, 2))
        one.step(row, row @ [2.0, -1.0] + 0.1 * rng.standard_normal(1) + burst * (k >= 595), [True])
    return one


def test_a_burst_hardly_moves_the_numbers() -> None:
    assert np.abs(estimated(np.random.default_rng(0), 5.0).linear - [2.0, -1.0]).max() < 0.2


def test_what_was_learnt_long_ago_is_not_forgotten_at_rest() -> None:
    one = estimated(np.random.default_rng(1))
    before = one.variance[1]
    for _ in range(100):  # 10 s in which nothing is learnt of the second number
        one.step(np.array([[1.0, 0.0]]), np.array([2.0]), [True])
    assert one.variance[1] < 1.3 * before


def stream(seconds: float = 6.0, rate: float = 100.0) -> np.ndarray:
    t = np.arange(0.0, seconds, 1.0 / rate)
    q = np.column_stack([0.6 + 0.4 * np.sin(1.7 * t), -0.9 + 0.4 * np.cos(2.3 * t)])
    return np.column_stack([t, q, 3.0 * q])


def test_a_spike_does_not_ring_in_the_filter() -> None:
    rows = stream()
    spoilt = rows.copy()
    spoilt[400, 3] += 50.0
    clean, made = FrontEnd(2).push(rows), FrontEnd(2).push(spoilt)
    assert np.abs(made.tau - clean.tau).max() < 1.0


@pytest.mark.parametrize(("steps", "unused"), [(2, False), (3, True)])
def test_samples_are_missing_where_the_clock_leaps(steps: int, unused: bool) -> None:
    def without(rows: np.ndarray) -> int:
        return int((FrontEnd(2).push(rows).good == 0.0).sum())

    rows = stream()
    more = without(np.delete(rows, slice(400, 400 + steps - 1), axis=0)) - without(rows)
    assert bool(more > 0) is unused


@pytest.mark.parametrize(("seconds", "restarts"), [(0.9, 0), (1.1, 1)])
def test_no_motion_is_made_up_across_a_long_hole(seconds: float, restarts: int) -> None:
    rows = stream()
    rows[400:, 0] += seconds
    one = FrontEnd(2)
    Samples.joined([one.push(rows[k : k + 50]) for k in range(0, len(rows), 50)])
    assert one.restarts == restarts


@pytest.mark.parametrize(("seconds", "restarts"), [(0.03, 0), (0.5, 1)])
def test_a_clock_that_was_set_back_starts_the_filters_anew(seconds: float, restarts: int) -> None:
    rows = stream()
    rows[400:, 0] -= seconds
    one = FrontEnd(2)
    Samples.joined([one.push(rows[k : k + 50]) for k in range(0, len(rows), 50)])
    assert one.restarts == restarts


@pytest.mark.parametrize(("every", "used"), [(2, True), (5, False)])
def test_samples_made_of_holes_are_not_fitted(every: int, used: bool) -> None:
    one = FrontEnd(2)
    made = one.push(stream())
    assert one.filters is not None
    good = np.repeat((np.arange(len(made)) % every == 0)[:, None], 2, axis=1).astype(float)
    seen = window("w", replace(made, good=good), one.filters.settled, one.filters).used
    assert bool(seen.all()) is used and bool(seen.any()) is used


@pytest.mark.parametrize(("every", "tell"), [(20, True), (4, False)])
def test_samples_beside_what_is_lost_do_not_tell_the_numbers(every: int, tell: bool) -> None:
    one = FrontEnd(2)
    made = one.push(stream())
    assert one.filters is not None
    good = np.repeat((np.arange(len(made)) % every != 0)[:, None], 2, axis=1).astype(float)
    seen = window("w", replace(made, good=good), one.filters.settled, one.filters)
    assert seen.used.all() and bool(seen.steady.all()) is tell


@pytest.mark.parametrize(("power", "looked_at"), [(0.015, False), (0.03, True)])
def test_rest_is_not_taken_for_change(power: float, looked_at: bool) -> None:
    """A block that shows next to nothing of a column wants something wild of it."""
    usual = [Scores(np.ones(1), np.ones(1)) for _ in range(20)]
    detector = Detector(np.full(1, 1e-3), 5.0, deque(usual))
    assert detector.take(Scores(np.full(1, 9.0 * power), np.full(1, power))).alarms is looked_at


@pytest.mark.parametrize(("blocks", "known"), [(3, False), (4, True)])
def test_the_scatter_of_three_blocks_is_no_interval(blocks: int, known: bool) -> None:
    one = estimated(np.random.default_rng(0))
    one.blocks[:] = blocks
    assert bool(np.isfinite(one.estimates()[0].high)) is known


@pytest.mark.parametrize(("apart", "separable"), [(2.5, False), (3.5, True)])
def test_one_run_chooses_between_rivals_that_are_far_enough_apart(apart: float, separable: bool) -> None:
    pair = {("a", "b"): apart}
    one = Separation(None, (), (), None, pair, None, 0.0, pair, None, 10.0, 5.0, (), 0)
    assert one.separable is separable
    assert (one.needed <= one.duration) is separable
    assert ("it would take" in one.sentence) is not separable
