"""What thresholds of watching prevent: the answer with them, and the wrong one without."""

from __future__ import annotations

from collections import deque
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exoid.apps.watch import course, front
from exoid.apps.watch.alarm import Detector, Deviation, Pending
from exoid.apps.watch.course import onset
from exoid.apps.watch.front import FrontEnd, Samples
from exoid.apps.watch.memory import Memory
from exoid.apps.watch.pushes import Pushes
from exoid.apps.watch.recursive import estimator
from exoid.apps.watch.recursive.estimator import Estimator, Pace
from exoid.apps.watch.scores import Scores
from exoid.apps.watch.settings import Settings
from exoid.apps.watch.usual import Usual
from exoid.apps.watch.watcher import Watcher
from exoid.apps.watch.window import window
from exoid.diagnosis.against import differences
from exoid.diagnosis.against.differences import BeforeAfter
from exoid.diagnosis.against.result import Course, Differences
from exoid.diagnosis.rules import RULES
from exoid.diagnosis.separation.result import Separation
from exoid.symbolic.joints import LEG

SEEDS = range(60)
TWO = SimpleNamespace(parameters=[SimpleNamespace(name=name, unit="") for name in "ab"], inertial=())
"""What an estimator of two numbers asks of a model."""


def jump(seed: int) -> Course:
    t = np.arange(0.0, 120.0, 2.0)
    noise = 0.8 * np.random.default_rng(seed).standard_normal(t.size)
    return Course(t, (t >= 61.0) + noise, np.ones(t.size))


def test_the_interval_of_a_beginning_contains_it(monkeypatch: pytest.MonkeyPatch) -> None:
    def contained() -> int:
        return sum(one.low <= 61.0 <= one.high for one in (onset(jump(seed)) for seed in SEEDS))

    assert contained() >= 0.9 * len(SEEDS)
    monkeypatch.setattr(course, "SURE", 0.5)
    assert contained() < 0.8 * len(SEEDS)


def test_a_jump_in_noise_is_not_called_slow(monkeypatch: pytest.MonkeyPatch) -> None:
    def slow() -> int:
        return sum(onset(jump(seed)).slow for seed in SEEDS)

    assert slow() == 0
    monkeypatch.setattr(course, "SLOW", 0.0)
    assert slow() > 0.1 * len(SEEDS)


def estimated(rng: np.random.Generator, burst: float = 0.0) -> Estimator:
    """An estimator of two parameters after 60 s, of which the last half second may be a burst."""
    one = Estimator.start(
        TWO, np.zeros(2), np.full(2, 1e3), np.array([0.1]), 10.0, Pace(rest=20.0, block=1.0)
    )
    for k in range(600):
        row = rng.standard_normal((1, 2))
        one.step(row, row @ [2.0, -1.0] + 0.1 * rng.standard_normal(1) + burst * (k >= 595), [True])
    return one


def test_a_burst_hardly_moves_the_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    def moved() -> float:
        return float(np.abs(estimated(np.random.default_rng(0), 5.0).linear - [2.0, -1.0]).max())

    robust = moved()
    monkeypatch.setattr(estimator, "ROBUST", 1e9)
    assert moved() > 3.0 * robust


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


@pytest.mark.parametrize(("most", "passes"), [(front.SPIKE, False), (1e9, True)])
def test_a_spike_does_not_ring_in_the_filter(most: float, passes: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(front, "SPIKE", most)
    rows = stream()
    spoilt = rows.copy()
    spoilt[400, 3] += 50.0
    clean, made = FrontEnd(2).push(rows), FrontEnd(2).push(spoilt)
    assert bool(np.abs(made.tau - clean.tau).max() > 1.0) is passes


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


@pytest.mark.parametrize(("share", "said"), [(0.035, ()), (0.07, ("stribeck:hip",))])
def test_an_error_that_was_there_all_along_is_said_where_it_matters(share, said, monkeypatch) -> None:
    asked = SimpleNamespace(always=True, label="stribeck:hip")
    old = SimpleNamespace(eligible=True, share=share, candidate=asked)
    monkeypatch.setattr(differences, "_asked", lambda score: score.candidate)
    one = SimpleNamespace(
        rules=RULES, old=(), _changes=lambda evidence, taken: [], _old=lambda evidence, changes: [old]
    )
    BeforeAfter._next(one, None, (), set())
    assert one.old == said


@pytest.mark.parametrize(("scatter", "change"), [(0.2, True), (0.5, False)])
def test_what_differs_between_recordings_made_before_is_no_change(scatter, change, monkeypatch) -> None:
    """Four recordings before scatter by this part of what differs in the one after; all show as much of it."""
    weights = [np.ones((1, 1))] * 5
    system = SimpleNamespace(
        weights=weights, solve=lambda: np.ones(1), left=lambda k, step: np.full((1, 1), scatter * (-1.0) ** k)
    )
    monkeypatch.setattr(differences, "CommonFit", lambda evidence, columns: system)
    one = SimpleNamespace(rules=RULES, before=4, _in_every_recording=lambda found: [np.ones((1, 1, 1))] * 5)
    found = SimpleNamespace(columns=[np.ones((1, 1, 1))])
    assert bool(BeforeAfter._exceeds_scatter(one, None, found)) is change


def told(after: float, named: float = 1.0, **more) -> Differences:
    """What a watch is told of one joint whose error is so many times the usual one, and with a name so many times."""
    return SimpleNamespace(rms_after=(after,), rms_named=(named,), found=(), old=(), **more)


def watching(answer: Differences, alarms: bool = True) -> SimpleNamespace:
    """A watch in which something lasts and still `alarms`, about which it is told `answer`."""
    deviation = SimpleNamespace(alarms=alarms)
    detector = SimpleNamespace(onset=lambda column: 9, calm=lambda: None, deviation=lambda: deviation)
    one = SimpleNamespace(
        reference=Usual(None, None, detector, np.ones(1), np.ones(1)), settings=Settings(), pending=None,
        memory=Memory(np.random.default_rng(0)), pushes=Pushes(LEG),
        _ask=lambda last: answer, applied=[], last=0.0, numbers=0.0, _as_usual=lambda window: window,
    )  # fmt: skip
    one._rescore = lambda: None
    one._resized = lambda lasted: Watcher._resized(one, lasted)
    one._ended = lambda: Watcher._ended(one)
    return one


@pytest.mark.parametrize(
    ("after", "left", "explained"),
    [(3.0, 1.4, True), (2.0, 1.6, False), (6.0, 1.6, True), (5.0, 1.6, True), (4.0, 1.65, False)],
)
def test_a_name_explains_what_has_grown(after: float, left: float, explained: bool) -> None:
    assert watching(None).reference.explains(told(after, left)) is explained


@pytest.mark.parametrize(("after", "goes_on"), [(1.05, False), (1.15, True)])
def test_an_error_that_hardly_grew_is_not_followed(after: float, goes_on: bool) -> None:
    one = watching(told(after))
    one.pending = Pending(Deviation(9.0, 0, 1, 5.0), 0, age=5)
    assert [event.more["state"] for event in Watcher._alarm(one, one.pending)] == ([] if goes_on else ["over"])
    assert (one.pending is not None) is goes_on


@pytest.mark.parametrize("alarms", [True, False])
def test_what_no_longer_stands_out_when_it_is_asked_about_again_was_a_burst(alarms: bool) -> None:
    one = watching(told(1.6), alarms)
    one.pending = Pending(Deviation(9.0, 0, 1, 5.0), 0, age=5)
    assert Watcher._alarm(one, one.pending) == []  # asked for the first time
    events = Watcher._alarm(one, one.pending) if one.pending else []
    assert (one.pending is not None) is alarms
    assert [event.more["state"] for event in events] == ([] if alarms else ["over"])


@pytest.mark.parametrize(("apart", "separable"), [(2.5, False), (3.5, True)])
def test_one_run_chooses_between_rivals_that_are_far_enough_apart(apart: float, separable: bool) -> None:
    pair = {("a", "b"): apart}
    one = Separation(None, (), (), None, pair, None, 0.0, pair, None, 10.0, 5.0, (), 0)
    assert one.separable is separable
    assert (one.needed <= one.duration) is separable
    assert ("it would take" in one.sentence) is not separable
