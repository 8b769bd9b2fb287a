"""A push is told as such: a torque that nothing explains, for a second or two, and no change."""

from __future__ import annotations

from types import SimpleNamespace

import numpy as np
import pytest

from exoid.apps.watch import pushes
from exoid.apps.watch.pushes import Pushes
from exoid.apps.watch.settings import Settings
from exoid.apps.watch.usual import Usual
from exoid.apps.watch.watcher import Watcher
from exoid.measurement.bench.simulation import Bench, run_bench
from exoid.symbolic.joints import LEG
from exoid.symbolic.model import Model

RATE, BLOCK = 20.0, 5.0


def usual(alarms=False, largest=1.0) -> Usual:
    """Return what is usual of a machine whose error is 0.2 N·m, and a detector that alarms or not."""
    detector = SimpleNamespace(deviation=lambda: SimpleNamespace(alarms=alarms))
    return Usual(None, None, detector, np.full(2, 0.2), np.full(2, 0.2), np.full(2, largest))


def seen(torque, began=0.0, largest=1.0) -> Pushes:
    """Return what is made of a residual of the knee, `torque` (N,) N·m at 20 Hz, in windows of 5 s."""
    found, size = Pushes(LEG), int(RATE * BLOCK)
    for k in range(0, len(torque), size):
        part = np.asarray(torque[k : k + size], dtype=float)
        t = began + (k + np.arange(len(part))) / RATE
        block = SimpleNamespace(residual=np.array([0.0 * part, part]), use=np.ones((2, len(part)), dtype=bool))
        found.take(SimpleNamespace(t=t), block, usual(largest=largest))
    return found


def bump(size, seconds, at=7.0, long=30.0):
    t = np.arange(0.0, long, 1.0 / RATE)
    return np.where((t >= at) & (t < at + seconds), size, 0.1)


def test_a_short_torque_is_told_with_joint_time_and_size():
    told = seen(bump(-6.0, 0.8)).events(30.0)
    assert [(one.event, one.more["joint"], one.more["size"]) for one in told] == [("push", "knee", 6.0)]
    assert told[0].more["since"]["t"] == pytest.approx(7.0) and told[0].more["until"]["t"] == pytest.approx(7.75)
    assert not told[0].alarm


def test_one_across_two_windows_is_one_and_is_told_once():
    found = seen(bump(6.0, 1.0, at=9.6))
    assert len(found.events(30.0)) == 1 and found.events(35.0) == []


def test_it_is_told_when_no_alarm_will_come_of_it_any_more():
    found = seen(bump(6.0, 0.8))
    assert found.events(12.0) == [] and len(found.events(18.5)) == 1


@pytest.mark.parametrize(("size", "largest", "told"), [(2.8, 1.0, 0), (3.2, 1.0, 1), (3.2, 1.7, 0), (3.6, 1.7, 1)])
def test_what_usually_is_missed_and_bursts_are_none(size, largest, told):
    assert len(seen(bump(size, 0.8), largest=largest).events(30.0)) == told


@pytest.mark.parametrize(("seconds", "told"), [(0.1, 0), (0.2, 1)])
def test_a_burst_of_the_sensor_is_none(seconds, told):
    assert len(seen(bump(6.0, seconds)).events(30.0)) == told


@pytest.mark.parametrize(("seconds", "told"), [(2.9, 1), (3.4, 0)])
def test_what_lasts_is_a_change(seconds, told):
    assert len(seen(bump(6.0, seconds)).events(30.0)) == told


def test_an_alarm_that_goes_without_it_was_a_push():
    found, scored = seen(bump(6.0, 0.8)), []
    assert [one.event for one in found.explain(usual(), 20.0, lambda: scored.append(1))] == ["push"]
    assert scored and found.told
    still = seen(bump(6.0, 0.8))
    assert still.explain(usual(alarms=True), 20.0, lambda: None) == [] and not still.told


def test_what_comes_again_soon_is_looked_at_whole():
    found = seen(np.concatenate([bump(6.0, 0.8), bump(6.0, 0.8)]))
    first = [one for one in found.seen if one.since < 30.0]
    found.told.extend(first)
    found.seen = [one for one in found.seen if one not in first]
    assert found.explain(usual(), 50.0, lambda: None) == []
    assert not found.told and pushes.APART > 30.0


@pytest.mark.slow
def test_pushes_of_a_stream_are_named_and_nothing_else_is():
    made = run_bench(seed=6, bench=Bench(duration=170.0))
    one = made.recording
    rows = np.column_stack([one.t, one.q, one.tau])
    for at, size in ((125.0, 6.0), (150.0, 8.0)):
        rows[:, 4] += size * np.exp(-(((rows[:, 0] - at) / 0.4) ** 2))
    watcher = Watcher(Model.standard(), Settings(learn=18))
    events = [event for k in range(0, len(rows), 500) for event in watcher.push(rows[k : k + 500])]
    told = [one for one in events if one.event == "push"]
    assert [one.more["joint"] for one in told] == ["knee", "knee"] and not any(one.alarm for one in events)
    assert [one.more["since"]["t"] for one in told] == pytest.approx([125.0, 150.0], abs=1.5)
