"""What thresholds of watching prevent: the answer with them, and the wrong one without."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from diagnosis.watching import course, estimator, front
from diagnosis.watching.course import onset
from diagnosis.watching.estimator import Estimator, Pace
from diagnosis.watching.front import FrontEnd, Samples
from diagnosis.watching.result import Course
from diagnosis.watching.window import window

SEEDS = range(60)


def jump(seed: int) -> Course:
    t = np.arange(0.0, 120.0, 2.0)
    noise = 0.8 * np.random.default_rng(seed).standard_normal(t.size)
    return Course(t, (t >= 61.0) + noise, np.ones(t.size))


@pytest.mark.shows("course.SURE")
def test_the_interval_of_a_beginning_contains_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def contained() -> int:
        return sum(one.low <= 61.0 <= one.high for one in (onset(jump(seed)) for seed in SEEDS))

    assert contained() >= 0.9 * len(SEEDS)
    monkeypatch.setattr(course, "SURE", 0.5)
    assert contained() < 0.8 * len(SEEDS)


@pytest.mark.shows("course.SLOW")
def test_a_jump_in_noise_is_not_called_slow(monkeypatch: pytest.MonkeyPatch) -> None:
    def slow() -> int:
        return sum(onset(jump(seed)).slow for seed in SEEDS)

    assert slow() == 0
    monkeypatch.setattr(course, "SLOW", 0.0)
    assert slow() > 0.1 * len(SEEDS)


def estimated(rng: np.random.Generator, burst: float = 0.0) -> Estimator:
    """An estimator of two parameters after 60 s, of which the last half second may be a burst."""
    one = Estimator.start(
        ("a", "b"), ("", ""), np.zeros(2), np.full(2, 1e3), np.array([0.1]), 10.0, 0, Pace(rest=20.0, block=1.0)
    )
    for k in range(600):
        row = rng.standard_normal((1, 2))
        one.step(row, row @ [2.0, -1.0] + 0.1 * rng.standard_normal(1) + burst * (k >= 595), [True])
    return one


@pytest.mark.shows("estimator.ROBUST")
def test_a_burst_hardly_moves_the_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    def moved() -> float:
        return float(np.abs(estimated(np.random.default_rng(0), 5.0).linear - [2.0, -1.0]).max())

    robust = moved()
    monkeypatch.setattr(estimator, "ROBUST", 1e9)
    assert moved() > 3.0 * robust


@pytest.mark.shows("estimator.CREDIT")
def test_what_was_learnt_long_ago_is_not_forgotten_at_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    def vaguer() -> float:
        """How much larger the variance of a parameter is after 10 s in which nothing was learnt of it."""
        one = estimated(np.random.default_rng(1))
        before = one.variance[1]
        for _ in range(100):
            one.step(np.array([[1.0, 0.0]]), np.array([2.0]), [True])
        return float(one.variance[1] / before)

    assert vaguer() < 1.3
    monkeypatch.setattr(estimator, "CREDIT", 1e9)
    assert vaguer() > 1.5


def stream(seconds: float = 6.0, rate: float = 100.0) -> np.ndarray:
    t = np.arange(0.0, seconds, 1.0 / rate)
    q = np.column_stack([0.6 + 0.4 * np.sin(1.7 * t), -0.9 + 0.4 * np.cos(2.3 * t)])
    return np.column_stack([t, q, 3.0 * q])


@pytest.mark.shows("front.SPIKE")
@pytest.mark.parametrize(("most", "passes"), [(front.SPIKE, False), (1e9, True)])
def test_a_spike_does_not_ring_in_the_filter(most: float, passes: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(front, "SPIKE", most)
    rows = stream()
    spoilt = rows.copy()
    spoilt[400, 3] += 50.0
    clean, made = FrontEnd(2).push(rows), FrontEnd(2).push(spoilt)
    assert bool(np.abs(made.tau - clean.tau).max() > 1.0) is passes


@pytest.mark.shows("front.HOLE")
@pytest.mark.parametrize(("steps", "unused"), [(2, False), (3, True)])
def test_samples_are_missing_where_the_clock_leaps(steps: int, unused: bool) -> None:
    def without(rows: np.ndarray) -> int:
        return int((FrontEnd(2).push(rows).good == 0.0).sum())

    rows = stream()
    more = without(np.delete(rows, slice(400, 400 + steps - 1), axis=0)) - without(rows)
    assert bool(more > 0) is unused


@pytest.mark.shows("front.LONGEST_HOLE")
@pytest.mark.parametrize(("seconds", "restarts"), [(0.9, 0), (1.1, 1)])
def test_no_motion_is_made_up_across_a_long_hole(seconds: float, restarts: int) -> None:
    rows = stream()
    rows[400:, 0] += seconds
    one = FrontEnd(2)
    Samples.joined([one.push(rows[k : k + 50]) for k in range(0, len(rows), 50)])
    assert one.restarts == restarts


@pytest.mark.shows("window.LEAST_WEIGHT")
@pytest.mark.parametrize(("every", "used"), [(2, True), (5, False)])
def test_samples_made_of_holes_are_not_fitted(every: int, used: bool) -> None:
    one = FrontEnd(2)
    made = one.push(stream())
    assert one.filters is not None
    good = np.repeat((np.arange(len(made)) % every == 0)[:, None], 2, axis=1).astype(float)
    use = window("w", replace(made, good=good), one.filters.settled, one.filters).use
    assert bool(use.all()) is used and bool(use.any()) is used
