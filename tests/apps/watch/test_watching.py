"""Watching a machine: front end, estimator, detector, course, and the lines of a stream."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from exoid.apps.watch.alarm import SPANS
from exoid.apps.watch.course import onset
from exoid.apps.watch.front import HALF, SPIKE, FrontEnd, Samples, despiked
from exoid.apps.watch.io.growing import grown
from exoid.apps.watch.recursive.encoder_noise import RING, EncoderNoise, following
from exoid.apps.watch.recursive.estimator import FORGOTTEN, FORGOTTEN_LEAST, Estimator, Pace
from exoid.apps.watch.settings import Settings
from exoid.apps.watch.watched import Watched
from exoid.apps.watch.watcher import Watcher
from exoid.apps.watch.window import joined_windows, prepared, weighted, window
from exoid.diagnosis.against.differences import compare_against
from exoid.diagnosis.against.questions import questions
from exoid.diagnosis.against.result import Course
from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.measurement.bench.hidden import true_model
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.recording import Recording
from exoid.measurement.trajectories.trajectory import random_trajectory
from exoid.optimisation.fitting.identify import identify
from exoid.symbolic.effect import Coefficient, Effect
from exoid.symbolic.mechanics.payload import Payload
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion

TWO = SimpleNamespace(parameters=[SimpleNamespace(name=name, unit="") for name in "ab"], inertial=())
"""What an estimator of two numbers asks of a model."""


def _stream(seconds: float = 12.0, rate: float = 100.0) -> np.ndarray:
    t = np.arange(0.0, seconds, 1.0 / rate)
    q = np.column_stack([0.6 + 0.4 * np.sin(1.7 * t), -0.9 + 0.4 * np.cos(2.3 * t)])
    return np.column_stack([t, q, 3.0 * q])


def _all(front: FrontEnd, rows: np.ndarray, size: int) -> Samples:
    return Samples.joined([front.push(rows[k : k + size]) for k in range(0, len(rows), size)])


@pytest.mark.parametrize("rate", [100.0, 1000.0])
def test_the_front_end_gives_the_same_however_samples_are_portioned(rate: float) -> None:
    rows = _stream(4.0, rate)
    whole, parts = _all(FrontEnd(2), rows, len(rows)), _all(FrontEnd(2), rows, 7)
    assert len(whole) == len(parts)
    for name in ("t", "q", "dq", "ddq", "tau", "good"):
        np.testing.assert_allclose(getattr(whole, name), getattr(parts, name), rtol=0, atol=1e-9)


def test_angles_and_torque_are_late_by_what_is_stated() -> None:
    front = FrontEnd(2)
    made = _all(front, _stream(), 100)
    assert front.filters is not None
    first = front.filters.keep / (1.0 - front.filters.keep) * 4 / front.filters.rate
    late = made.t - first  # the median's neighbours are in the stamps already
    wanted = 0.6 + 0.4 * np.sin(1.7 * late)
    np.testing.assert_allclose(made.q[100:, 0], wanted[100:], atol=2e-3)
    np.testing.assert_allclose(made.tau[:, 0], 3.0 * made.q[:, 0], atol=1e-9)
    np.testing.assert_allclose(made.dq[100:, 0], (0.4 * 1.7 * np.cos(1.7 * late))[100:], atol=6e-3)


def test_a_spike_of_the_torque_is_replaced_and_a_hole_is_not_used() -> None:
    rows = _stream()
    spoilt = rows.copy()
    spoilt[600, 3] += 50.0
    clean, made = _all(FrontEnd(2), rows, 100), _all(FrontEnd(2), spoilt, 100)
    assert np.abs(made.tau - clean.tau).max() < 0.05
    holed = np.delete(rows, slice(600, 640), axis=0)
    made = _all(FrontEnd(2), holed, 100)
    assert len(made) == len(clean)
    assert not made.good[600:630].any()


def test_a_clock_that_jumps_starts_the_filters_anew() -> None:
    rows = _stream()
    later = rows.copy()
    later[600:, 0] += 3600.0
    front = FrontEnd(2)
    made = _all(front, later, 50)
    assert front.restarts == 1
    assert len(made) < 2000


def test_what_holds_between_torque_and_columns_holds_after_the_weighted_filter() -> None:
    front = FrontEnd(2)
    made = _all(front, _stream(), 100)
    assert front.filters is not None
    one = window("w", made, front.filters.settled, front.filters)
    column = np.stack([made.dq, made.q], axis=2)
    smooth = one.smooth_columns(np.moveaxis(column, 0, 1))
    direct = one.smooth(column @ np.array([2.0, -1.5]))
    np.testing.assert_allclose(smooth @ np.array([2.0, -1.5]), direct, atol=1e-12)
    assert one.used.any()
    assert not weighted(made.q, np.zeros_like(made.q), 0.5).any()


def _regressor(rng: np.random.Generator, count: int) -> np.ndarray:
    return rng.standard_normal((count, 1, 2)) * np.array([1.0, 3.0])


def _estimator(scale: float = 0.1) -> Estimator:
    return Estimator.start(
        TWO, np.zeros(2), np.full(2, 1e3), np.array([scale]), 10.0, Pace(rest=20.0, block=1.0)
    )


def test_the_estimator_is_weighted_least_squares_as_long_as_nothing_is_forgotten() -> None:
    rng = np.random.default_rng(0)
    rows, truth = _regressor(rng, 300), np.array([2.0, -1.0])
    one = _estimator(1e6)  # so that no residual is large
    one.pace = np.zeros(2)
    one.follow = 0.0
    tau = (rows @ truth)[:, 0] + 0.1 * rng.standard_normal(300)
    for row, value in zip(rows, tau, strict=True):
        one.step(row, np.array([value]), [True])
    wanted = np.linalg.lstsq(
        np.vstack([rows[:, 0] / 1e6, np.eye(2) / 1e3]), np.append(tau / 1e6, [0.0, 0.0]), rcond=None
    )[0]
    np.testing.assert_allclose(one.linear, wanted, rtol=1e-8)


@pytest.mark.slow
def test_a_parameter_without_excitation_keeps_value_and_certainty() -> None:
    rng = np.random.default_rng(1)
    one = _estimator()
    for row in _regressor(rng, 600):
        one.step(row, row @ np.array([2.0, -1.0]) + 0.1 * rng.standard_normal(1), [True])
    before, sure = one.linear.copy(), one.variance.copy()
    for _ in range(3000):
        one.step(np.array([[1.0, 0.0]]), np.array([5.0]) + 0.1 * rng.standard_normal(1), [True])
    assert abs(one.linear[0] - 5.0) < 0.1  # follows what is excited
    assert abs(one.linear[1] - before[1]) < 0.05
    assert one.variance[1] < 4.0 * sure[1]


def test_numbers_of_which_the_sum_is_well_known_are_not_made_certain_by_forgetting_at_their_own_pace() -> None:
    """Each forgets by a step of its own: shares of what is known would turn the sum into another one at each sample,
    and two sums tell both numbers.
    """
    truth, held = np.array([1.0, 2.0]), []
    for seed in range(10):
        rng = np.random.default_rng(seed)
        one = Estimator.start(TWO, np.zeros(2), np.full(2, 10.0), np.array([1.0]), 25.0, Pace())
        one.pace = one.pace * np.array([0.2, 1.0])
        apart = 0.1 * rng.standard_normal(10_000)
        columns = np.column_stack([10.0 + apart, 10.0 - apart])[:, None, :]
        one.steps(columns, columns @ truth + rng.standard_normal((10_000, 1)), np.ones((10_000, 1)))
        held += [e.low <= x <= e.high for e, x in zip(one.estimates(), truth, strict=True)]
    assert np.mean(held) >= 0.85


def test_intervals_of_collinear_numbers_hold_while_old_samples_are_forgotten() -> None:
    """Their columns differ by a twentieth, as those of inertia and gravity do in a slow motion."""
    rng, missed = np.random.default_rng(6), []
    columns = np.column_stack([np.ones(12_000), 1.0 + 0.05 * np.sin(2.0 * np.pi * np.arange(12_000) / 500.0)])[:, None]
    for _ in range(30):
        one = Estimator.start(TWO, np.array([2.0, -1.0]), np.full(2, 3.0), np.array([0.1]), 25.0, Pace())
        tau = columns @ np.array([2.0, -1.0]) + 0.1 * rng.standard_normal((12_000, 1))
        one.steps(columns, tau, np.ones((12_000, 1)))
        missed += [not e.low <= x <= e.high for e, x in zip(one.estimates(), (2.0, -1.0), strict=True)]
    assert np.mean(missed) < 0.15  # with steps of their own for each, 0.39


def test_noise_in_the_columns_does_not_pull_numbers_towards_zero() -> None:
    rng, count = np.random.default_rng(7), 20_000
    true = rng.standard_normal((count, 1, 2)) * [1.0, 2.0]
    noise = np.zeros((1, 1, 2))
    noise[0, 0, 0] = 0.6  # a quarter of what is seen of the first number
    seen = true + noise[0] * rng.standard_normal((count, 1, 1))
    tau = true @ np.array([2.0, -1.0]) + 0.1 * rng.standard_normal((count, 1))
    plain, aware = (Estimator.start(TWO, np.zeros(2), np.full(2, 10.0), np.ones(1), 25.0, Pace()) for _ in range(2))
    plain.steps(seen, tau, np.ones((count, 1)))
    aware.steps(seen, tau, np.ones((count, 1)), np.broadcast_to(noise, (count, 1, 1, 2)))
    assert plain.estimates()[0].high < 1.7
    assert aware.estimates()[0].low < 2.0 < aware.estimates()[0].high
    assert abs(aware.estimates()[0].value - 2.0) < 0.1


def test_the_noise_of_an_encoder_is_told_while_it_moves() -> None:
    rng, t = np.random.default_rng(8), np.arange(6000) / 100.0
    q = 0.4 * np.sin(2.0 * np.pi * t)[:, None] + 6e-5 * rng.standard_normal((6000, 1))
    q[3000] += 0.3
    whole = EncoderNoise(np.zeros(1), following(100.0)).take(q)
    parts = EncoderNoise(np.zeros(1), following(100.0))
    again = np.concatenate([parts.take(q[max(0, k - RING + 1) : k + 500]) for k in range(0, 6000, 500)])
    np.testing.assert_array_equal(whole, again)
    assert np.sqrt(whole[-1, 0]) == pytest.approx(6e-5, rel=0.1)


def test_what_is_forgotten_follows_at_once_and_the_rest_stays() -> None:
    """Forgetting a number is the time update of the filter: the covariance of the others is as it was."""
    rng = np.random.default_rng(3)
    one = _estimator()
    for row in _regressor(rng, 900):
        one.step(row, row @ np.array([2.0, -1.0]) + 0.1 * rng.standard_normal(1), [True])
    before, white, robust = one.linear.copy(), one.variance.copy(), one.covariance()
    one.forget([0])
    np.testing.assert_allclose(one.linear, before)
    np.testing.assert_allclose(one.root @ one.linear, one.right, rtol=1e-9)
    assert not np.tril(one.root, -1).any()
    step = FORGOTTEN * abs(before[0]) + FORGOTTEN_LEAST
    np.testing.assert_allclose(one.variance, white + np.array([step**2, 0.0]), rtol=0.02)
    np.testing.assert_allclose(one.covariance(), robust + np.diag([step**2, 0.0]), rtol=1e-6, atol=1e-9)
    assert np.isinf(one.estimates()[0].high)
    assert np.isfinite(one.estimates()[1].high)
    for row in _regressor(rng, 60):  # six seconds
        one.step(row, row @ np.array([5.0, -1.0]) + 0.1 * rng.standard_normal(1), [True])
    low, high = one.estimates()[0].low, one.estimates()[0].high
    assert low <= 5.0 <= high < 5.5
    assert abs(one.linear[1] + 1.0) < 0.02


@pytest.mark.parametrize("slow", [False, True])
def test_the_course_tells_a_jump_from_a_drift(slow: bool) -> None:
    rng = np.random.default_rng(2)
    t = np.arange(0.0, 300.0, 2.0)
    shape = np.clip((t - 150.0) / 120.0, 0.0, 1.0) if slow else (t >= 150.0).astype(float)
    found = onset(Course(t, shape + 0.1 * rng.standard_normal(t.size), np.ones(t.size)))
    assert found.slow == slow
    if not slow:
        assert found.low <= 150.0 <= found.high
        assert abs(found.t - 150.0) < 5.0


def test_a_file_that_is_rotated_is_read_on(tmp_path) -> None:  # type: ignore[no-untyped-def]
    path = tmp_path / "log.csv"
    path.write_text("t,q1,q2,tau1,tau2\n0,0,0,0,0\n")
    texts = grown(path, True)
    assert (next(texts) or "").startswith("t,q1")
    path.rename(tmp_path / "log.1")
    path.write_text("t,q1,q2,tau1,tau2\n1,0,0,0,0\n")
    fresh = next(text for text in texts if text is None)
    assert fresh is None
    assert "1,0,0,0,0" in (next(texts) or "")


def test_compiled_estimation_is_that_of_python(monkeypatch: pytest.MonkeyPatch) -> None:
    rng = np.random.default_rng(4)
    rows = _regressor(rng, 120)
    tau = rows @ np.array([2.0, -1.0]) + rng.standard_normal((120, 1))
    use = rng.random((120, 1)) < 0.8
    compiled, plain = _estimator(), _estimator()
    compiled.steps(rows, tau, use)
    monkeypatch.setattr("exoid.apps.watch.recursive.estimator.kernel", lambda values: None)
    plain.steps(rows, tau, use)
    for name in ("linear", "variance", "root", "right", "credit", "score", "meat", "scale", "blocks", "inside"):
        np.testing.assert_allclose(getattr(compiled, name), getattr(plain, name), rtol=1e-9, atol=1e-12)


def test_windows_that_follow_each_other_join_to_what_was_one() -> None:
    front = FrontEnd(2)
    made = _all(front, _stream(20.0), 100)
    filters = front.filters
    assert filters is not None
    lead, size = filters.settled, 100 * filters.stride
    parts = [window("w", made.part(k * size, lead + (k + 1) * size), lead, filters) for k in range(3)]
    whole = window("w", made.part(0, lead + 3 * size), lead, filters)
    (one,) = joined_windows(parts, 3)
    np.testing.assert_array_equal(one.t, whole.t)
    np.testing.assert_array_equal(one.used, whole.used)
    np.testing.assert_allclose(one.torque, whole.torque, atol=1e-9)
    np.testing.assert_allclose(one.smooth(one.motion.dq), whole.smooth(whole.motion.dq), atol=1e-9)
    assert [len(p.t) for p in joined_windows(parts, 2)] == [len(parts[0].t) + len(parts[1].t), len(parts[2].t)]
    assert len(joined_windows([parts[0], parts[2]], 2)) == 2  # a gap


@pytest.fixture(scope="module")
def usual_run() -> tuple[Model, Motion, np.ndarray]:
    """A leg that follows a motion exactly, and its torque."""
    model = Model.standard()
    motion = random_trajectory(np.random.default_rng(5), period=47.0, harmonics=24).at(np.arange(0.0, 112.0, 0.01))
    return model, motion, true_model(model, standard_leg().base, ()).torque(motion)


@pytest.mark.slow
@pytest.mark.parametrize(("name", "kind"), [("payload:shank", "payload"), ("coulomb:knee", "abrupt")])
def test_what_changed_is_named_and_what_is_kept_does_not_grow(usual_run, name: str, kind: str) -> None:  # type: ignore[no-untyped-def]
    model, motion, torque = usual_run
    after = motion.t >= 82.0
    number = np.zeros(len(model.parameters))
    if kind == "payload":
        number[:4] = Payload(1.5, 0.2, "shank").numbers(model.thigh_length)
    else:
        number[[p.name for p in model.parameters].index(name)] = 1.0
    added = (model.columns(motion) @ number).T
    noise = 0.5 * np.random.default_rng(8).standard_normal(torque.shape)
    rows = np.column_stack([motion.t, motion.q, torque + noise + after[:, None] * added])
    watcher = Watcher(model, Settings(learn=12, draws=199))
    events = []
    for k in range(0, len(rows), 200):
        events += watcher.push(rows[k : k + 200])
        assert len(watcher.memory.recent) <= SPANS[-1]
        assert len(watcher.memory.usual) <= 12
        assert len(watcher.stream.waiting) < 800
    first = next(e for e in events if e.event == "change")
    assert first.names == (name,)
    assert first.kind == kind
    assert first.since is not None
    assert first.since.low <= 82.0 <= first.since.high
    assert first.t - 82.0 < 26.0
    assert not [e for e in events if e.alarm and e.t < 82.0]


@pytest.mark.slow
def test_a_second_change_soon_after_the_first_is_seen_and_the_numbers_stay_right() -> None:
    """A load is taken up, and forty seconds later the friction of the hip rises; then all is followed."""
    model, base = Model.standard(), np.array(standard_leg().base)
    motion = random_trajectory(np.random.default_rng(5), period=47.0, harmonics=24).at(np.arange(0.0, 220.0, 0.01))
    load, friction = np.zeros(len(base)), np.zeros(len(base))
    load[:4] = Payload(1.5, 0.25, "shank").numbers(model.thigh_length)
    friction[[p.name for p in model.parameters].index("coulomb:hip")] = 1.5
    torque = true_model(model, standard_leg().base, ()).torque(motion)
    for moment, step in ((82.0, load), (122.0, friction)):
        torque = torque + (motion.t >= moment)[:, None] * (model.columns(motion) @ step).T
    noise = 0.5 * np.random.default_rng(8).standard_normal(torque.shape)
    rows = np.column_stack([motion.t, motion.q, torque + noise])
    watcher = Watcher(model, Settings(learn=12, draws=199))
    events = [e for k in range(0, len(rows), 200) for e in watcher.push(rows[k : k + 200])] + watcher.finish()
    first = [e for e in events if e.event == "change" and e.more["state"] == "first"]
    assert [e.names for e in first] == [("payload:shank",), ("coulomb:hip",)]
    assert [e.t < moment + 30.0 for e, moment in zip(first, (82.0, 122.0), strict=True)] == [True, True]
    suspected = next(e for e in events if e.event == "suspected")
    assert 82.0 < suspected.t < 94.0
    assert watcher.numbers is not None
    estimates = watcher.numbers.estimates()
    assert sum(e.low <= x <= e.high for e, x in zip(estimates, base + load + friction, strict=True)) >= 6
    for e, x in zip(estimates, base + load + friction, strict=True):
        assert abs(e.value - x) < 0.03 * (1.0 + abs(x))
    assert len(watcher.numbers.past) <= SPANS[-1]


def test_what_is_passed_over_is_said_in_the_end() -> None:
    rows = _stream(20.0)
    rows[300, 2] = np.nan
    rows[400, 0] = rows[398, 0]  # the clock steps back, and goes on
    rows[1200:, 0] += 3600.0
    watcher = Watcher(Model.standard())
    events = [e for k in range(0, len(rows), 70) for e in watcher.push(rows[k : k + 70])] + watcher.finish()
    assert [e.event for e in events] == ["start", "bad_samples", "bad_samples", "start", "summary"]
    assert "jumped" in events[3].sentence
    more = events[-1].more
    assert (more["not_finite"], more["not_later"], more["restarts"]) == (1, 1, 1)
    assert "jumps of the clock: 1" in events[-1].sentence


@pytest.mark.parametrize("seed", range(3))
def test_the_beginning_of_a_slow_change_has_an_interval(seed: int) -> None:
    t = np.arange(0.0, 300.0, 2.0)
    shape = np.clip((t - 150.0) / 120.0, 0.0, 1.0)
    found = onset(Course(t, shape + 0.05 * np.random.default_rng(seed).standard_normal(t.size), np.ones(t.size)))
    assert found.slow
    assert found.low < found.t < found.high
    assert found.low <= 150.0 <= found.high


@pytest.mark.slow
@pytest.mark.parametrize("place", [0.15, 0.2, 0.25, 0.37])
def test_one_recording_before_and_one_after_are_enough(usual_run, place: float) -> None:  # type: ignore[no-untyped-def]
    model, motion, torque = usual_run
    number = np.zeros(len(model.parameters))
    number[:4] = Payload(1.5, place, "shank").numbers(model.thigh_length)
    tau = torque + 0.5 * np.random.default_rng(8).standard_normal(torque.shape)
    loaded = tau + (model.columns(motion) @ number).T

    def part(name: str, of: np.ndarray, begin: float, end: float) -> Recording:
        own = (motion.t >= begin) & (motion.t < end)
        return Recording(name, motion.t[own] - begin, motion.q[own], of[own])

    before = part("before", tau, 0.0, 40.0)
    found = compare_against(model, [before], [part("after", loaded, 60.0, 90.0)])
    assert [d.name for d in found.found] == ["payload:shank"]
    change = found.found[0].change[0]
    assert change.low <= 1.5 <= change.high
    at = found.found[0].place
    assert at is not None
    assert at.low <= place <= at.high
    assert at.high - at.low < 0.06
    assert "down the shank" in found.found[0].sentence
    if place != 0.2:
        return
    assert not compare_against(model, [before], [part("after", tau, 60.0, 90.0)]).differs


NOWHERE = Effect(
    id="nowhere", explains="it has no value", torque="c * log(0 - theta * theta) * 0.1", custom=True,
    coefficients={"c": Coefficient("N·m")}, joints=("hip",),
)  # fmt: skip


@pytest.mark.parametrize("terms", [(), ("stribeck:knee",)])
def test_columns_that_are_watched_are_those_that_are_asked_about(terms: tuple[str, ...]) -> None:
    model = Model.standard()
    for name in terms:
        model = model.with_effect(name)
    motion = random_trajectory(np.random.default_rng(5), period=21.0, harmonics=12).at(np.arange(0.0, 21.0, 0.01))
    tau = true_model(Model.standard(), standard_leg().base, ()).torque(motion)
    front = FrontEnd(2)
    made = front.push(np.column_stack([motion.t, motion.q, tau]))
    assert front.filters is not None
    one = window("w", made, front.filters.settled, front.filters)
    now = fitted_model(identify(model, [one], optimisers=()), prepared(model.joints, [one]))
    block = now.block_of(one)
    asked = questions(now, (NOWHERE,))
    columns = iter(Watched(asked, now).columns(one, block.columns))
    names = []
    for candidate in asked:
        middle = round(0.5 * (len(candidate.nodes) - 1))
        values = candidate.columns(candidate.nodes[[middle]], one, block.columns, now)
        for m in range(values.values.shape[3]):
            wanted = values.full(0)[:, :, m]
            np.testing.assert_allclose(next(columns), wanted, rtol=0, atol=1e-9 * (1.0 + np.abs(wanted).max()))
        names.append(candidate.name)
        if candidate.name == "nowhere:hip":
            assert not values.values.any()
    assert next(columns, None) is None
    assert {"hysteresis:hip", "motor_elasticity:knee", "time_delay:hip", "nowhere:hip", "payload:shank"} <= {*names}


def test_spikes_are_what_is_far_from_the_median_of_its_neighbours() -> None:
    rng = np.random.default_rng(3)
    tau = rng.standard_normal((300, 2)).round(1)  # equal neighbours too
    tau[rng.integers(0, 300, 20)] += 9.0
    made = despiked(tau)
    for k, row in enumerate(made):
        near = tau[k : k + 2 * HALF + 1]
        middle = np.median(near, axis=0)
        scale = np.median(np.abs(near - middle), axis=0) / 0.6745
        np.testing.assert_array_equal(row, np.where(np.abs(near[HALF] - middle) > SPIKE * scale, middle, near[HALF]))
