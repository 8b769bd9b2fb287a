"""Samples that no sensor can have measured: named, passed over, and watching goes on."""

from __future__ import annotations

import numpy as np
import pytest

from exoid.apps.watch.bad_samples import ASTRAY, CONFIRMED, Gate
from exoid.apps.watch.front import LEAST_RATE, Filters, FrontEnd
from exoid.apps.watch.settings import Settings
from exoid.apps.watch.watcher import Watcher
from exoid.ground.errors import ExoidError
from exoid.measurement.bench.hidden import true_model
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.reading.columns import required
from exoid.measurement.trajectories.trajectory import random_trajectory
from exoid.symbolic.model import Model


def stream(seconds: float = 10.0, rate: float = 100.0) -> np.ndarray:
    t = np.arange(round(seconds * rate)) / rate
    q = np.column_stack([0.6 + 0.4 * np.sin(1.7 * t), -0.9 + 0.4 * np.cos(2.3 * t)])
    return np.column_stack([t, q, 3.0 * q])


def passed(rows: np.ndarray, size: int) -> tuple[np.ndarray, list, Gate]:
    gate, events = Gate(required(), 2), []
    out = []
    for k in range(0, len(rows), size):
        out.append(gate.take(rows[k : k + size]))
        events += gate.told()
    return np.concatenate(out), events + gate.finish(), gate


@pytest.mark.parametrize("size", [1, 7, 1000])
@pytest.mark.parametrize("value", [1e308, -1e13, np.inf, np.nan, 1e6, 40.0])
@pytest.mark.parametrize("column", [1, 4])
def test_half_a_second_of_a_broken_sensor_is_named_once(size: int, value: float, column: int) -> None:
    rows = stream()
    rows[300:350, column] = value
    if column == 4 and abs(value) <= 1e12:  # torques may be anything below: what stands out is weighed less
        assert len(passed(rows, size)[0]) == len(rows)
        return
    kept, events, gate = passed(rows, size)
    np.testing.assert_array_equal(kept, np.delete(rows, slice(300, 350), axis=0))
    assert [(e.event, e.more["state"], e.more["count"]) for e in events] == [
        ("bad_samples", "first", 1), ("bad_samples", "over", 50)
    ]  # fmt: skip
    assert events[1].more["channels"] == [required()[column]]
    assert gate.not_finite + gate.not_credible == 50


@pytest.mark.parametrize("size", [1, 1000])
def test_a_wrong_stamp_is_no_jump_of_the_clock(size: int) -> None:
    rows = stream()
    rows[300, 0], rows[500, 0], rows[501, 0] = 1e18, -5.0, 77.0
    kept, events, _ = passed(rows, size)
    np.testing.assert_array_equal(kept, np.delete(rows, [300, 500, 501], axis=0))
    assert {c for e in events for c in e.more["channels"]} == {"t"}


@pytest.mark.parametrize("jump", [3600.0, -8.0, -0.5])
def test_a_clock_that_goes_on_from_elsewhere_is_believed(jump: float) -> None:
    rows = stream()
    rows[600:, 0] += jump
    kept, events, _ = passed(rows, 11)
    np.testing.assert_array_equal(kept, rows)
    assert not events
    few = rows[: 600 + int(CONFIRMED) - 1]
    assert len(passed(few, 11)[0]) == 600


def test_a_clock_that_only_jumps_is_refused_in_words() -> None:
    rows = stream()
    rows[:, 0] *= 1000.0
    with pytest.raises(ExoidError, match="from one sample to the next"):
        passed(rows, 7)
    assert len(rows) > ASTRAY


def test_a_rate_too_low_for_the_cutoff_is_refused_in_words() -> None:
    for rate in (1.0, LEAST_RATE * 4.0 - 1.0, 1e9):
        with pytest.raises(ExoidError, match=r"too low|too high"):
            Filters(rate, 4.0)
    Filters(LEAST_RATE * 4.0, 4.0)
    front = FrontEnd(2)
    with pytest.raises(ExoidError, match="20 Hz at least"):
        front.push(stream(100.0, 1.0))


def test_nothing_is_learnt_while_the_filter_rings_from_a_hole() -> None:
    rows = stream()
    front = FrontEnd(2)
    whole = front.push(rows)
    holed = FrontEnd(2).push(np.delete(rows, slice(300, 350), axis=0))
    used = holed.good.any(axis=1)
    for name in ("q", "dq", "ddq"):
        off = np.abs(getattr(holed, name) - getattr(whole, name)).max(axis=1)
        assert off[used].max() < 0.02 * np.abs(getattr(whole, name)).max()
    assert np.abs(holed.ddq - whole.ddq).max() > 2.0 * np.abs(whole.ddq)[100:].max()


@pytest.mark.slow
@pytest.mark.parametrize("value", [1e308, np.nan, 1e6])
def test_a_change_after_a_glitching_encoder_is_seen(value: float) -> None:
    model = Model.standard()
    motion = random_trajectory(np.random.default_rng(5), period=47.0, harmonics=24).at(np.arange(0.0, 140.0, 0.01))
    torque = true_model(model, standard_leg().base, ()).torque(motion)
    torque[:, 1] += np.where(motion.t >= 100.0, 1.0, 0.0) * np.tanh(motion.dq[:, 1] / 0.02)
    noise = 0.5 * np.random.default_rng(8).standard_normal(torque.shape)
    rows = np.column_stack([motion.t, motion.q, torque + noise])
    rows[(motion.t >= 80.0) & (motion.t < 80.5), 2] = value
    watcher = Watcher(model, Settings(learn=12, draws=199))
    events = [e for k in range(0, len(rows), 200) for e in watcher.push(rows[k : k + 200])] + watcher.finish()
    assert [e.more["state"] for e in events if e.event == "bad_samples"] == ["first", "over"]
    change = next(e for e in events if e.alarm)
    assert change.names == ("coulomb:knee",)
    assert change.t > 100.0
    assert watcher.numbers is not None
    friction = watcher.numbers.estimates()[6]
    assert np.isfinite(friction.value)
