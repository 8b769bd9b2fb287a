"""A person and the ground while a machine is watched: measured forces enter the model, stance is left out, and what
comes and goes unmeasured is no change of the machine.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from exoid.apps.watch import pushes, wording
from exoid.apps.watch.following import follow
from exoid.apps.watch.front import FrontEnd
from exoid.apps.watch.live import Lines
from exoid.apps.watch.outside import ASSUMED, UNSEEN, Outside, stream_of
from exoid.apps.watch.replaying import replay
from exoid.apps.watch.settings import Settings
from exoid.apps.watch.state import WatchState
from exoid.apps.watch.watcher import Watcher
from exoid.ground.errors import ExoidError, RecordingError
from exoid.measurement.bench.hidden import true_model
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.simulation import Bench, simulate
from exoid.measurement.bench.wearer import Wearer
from exoid.measurement.recording import Recording
from exoid.measurement.trajectories.trajectory import random_trajectory
from exoid.symbolic.force import TORQUE, Force
from exoid.symbolic.joints import LEG
from exoid.symbolic.mechanics.pushed import placed_joints, pushed_torques
from exoid.symbolic.model import Model

MODEL = Model.standard()
QUICK = Settings(learn=8, most_learn=16, draws=199)
CUFF = Force("shank cuff", "knee", ("f2",), 0.3)


def rows(seconds: float = 60.0, rate: float = 100.0, seed: int = 0) -> np.ndarray:
    """Return samples (N, 5) of a leg that follows a motion exactly, with noise of 0.3 N·m."""
    rng = np.random.default_rng(seed)
    t = np.arange(round(seconds * rate)) / rate
    path = random_trajectory(rng, period=23.0, harmonics=12).at(t)
    tau = true_model(MODEL, standard_leg().base, ()).torque(path)
    return np.column_stack([t, path.q, tau + 0.3 * rng.standard_normal(tau.shape)])


def pushed(own: np.ndarray, force: np.ndarray, cuff: Force = CUFF) -> np.ndarray:
    """Return the samples with the torques that a `force` (N,) asks for, and it behind them."""
    added = pushed_torques(placed_joints(MODEL), own[:, 1:3], cuff, cuff.at, force[:, None])
    return np.column_stack([own[:, :3], own[:, 3:] + added, force])


def waving(t: np.ndarray) -> np.ndarray:
    return 12.0 * np.sin(1.3 * t) + 8.0 * np.sin(3.1 * t + 1.0)


def watched(watcher: Watcher, samples: np.ndarray) -> list:
    return [event for k in range(0, len(samples), 500) for event in watcher.push(samples[k : k + 500])]


@cache
def worn() -> Recording:
    return simulate(MODEL, seed=4, bench=Bench(duration=60.0, wearer=Wearer()))


@pytest.mark.slow
def test_the_places_of_cuffs_are_learnt_with_the_leg() -> None:
    found = replay(MODEL, worn(), QUICK)
    known = {e.name: e for e in next(e for e in found.events if e.event == "reference").estimates}
    for name in ("thigh cuff.at", "shank cuff.at"):
        assert known[name].low - 0.01 < 0.25 < known[name].high + 0.01
        assert known[name].high - known[name].low < 0.05
    assert not any(e.alarm for e in found.events)
    assert {"thigh cuff.at", "shank cuff.at"} <= set(found.names)


@pytest.mark.slow
def test_a_force_of_the_model_is_taken_out_of_what_the_numbers_are_told_by() -> None:
    own = rows()
    force = waving(own[:, 0])
    watcher = Watcher(MODEL.with_forces(CUFF), QUICK)
    assert not any(e.alarm for e in watched(watcher, pushed(own, force)))
    plain = Watcher(MODEL, QUICK)
    watched(plain, own)
    for one, other in zip(watcher.numbers.estimates(), plain.numbers.estimates(), strict=True):
        assert one.name == other.name and one.value == pytest.approx(other.value, rel=0.02, abs=0.02)


@pytest.mark.slow
def test_what_was_learnt_beside_a_force_survives_a_restart() -> None:
    own = rows()
    samples, model = pushed(own, waving(own[:, 0])), MODEL.with_forces(CUFF)
    first = Watcher(model, QUICK)
    watched(first, samples)
    again = Watcher(model, QUICK, restored=WatchState.from_bytes(first.state().to_bytes()))
    told = watched(again, samples + np.array([100.0, 0, 0, 0, 0, 0]))
    assert [e.event for e in told][:2] == ["start", "reference"] and told[1].more["restored"]
    assert not any(e.alarm for e in told)


@pytest.mark.slow
def test_a_force_that_never_acted_is_learnt_when_it_does() -> None:
    own = rows(150.0)
    force = np.where(own[:, 0] > 60.0, waving(own[:, 0]), 0.0)
    watcher = Watcher(MODEL, QUICK)
    watcher.measures(("f2",))
    told = watched(watcher, pushed(own, force))
    learnt = [e for e in told if e.event == "reference"]
    assert len(learnt) == 2 and not any(e.alarm for e in told)
    assert "shank cuff.at" not in {e.name for e in learnt[0].estimates}
    place = next(e for e in learnt[1].estimates if e.name == "shank cuff.at")
    assert abs(place.value - 0.3) < 0.02 and CUFF.at != ASSUMED


def test_forces_are_filtered_as_the_torques_are() -> None:
    own = rows(5.0)
    own[:, 3] = waving(own[:, 0])  # smooth, so that nothing of it is taken for a spike
    made = FrontEnd(2, outside=2).push(np.column_stack([own, own[:, 3], 0.0 * own[:, 0]]))
    assert np.allclose(made.force[50:, 0], made.tau[50:, 0], atol=1e-9)
    assert FrontEnd(2).push(own).force.shape == (len(made), 0)


def test_torques_of_stance_count_for_nothing_and_angles_go_on() -> None:
    own = rows(5.0)
    spoilt, stance = own.copy(), (own[:, 0] > 2.0) & (own[:, 0] < 2.8)
    spoilt[stance, 3:] += 40.0
    front = FrontEnd(2, outside=1)
    made, clean = front.push(np.column_stack([spoilt, stance])), FrontEnd(2).push(own)
    assert np.array_equal(made.ddq, clean.ddq)
    use = made.good[:, 0] > 0.0
    assert not use[(made.t > 1.96) & (made.t < 2.9)].any() and use[made.t > 3.2].any()
    assert np.allclose(made.tau[use], clean.tau[use], atol=0.01)


def test_columns_are_put_in_the_model_s_order_and_a_load_is_stance_from_a_twentieth_of_its_largest() -> None:
    model = MODEL.with_forces(CUFF, Force("push", "hip", ("interaction_torque_hip",), frame=TORQUE))
    own = Outside.of(model, ("interaction_torque_hip", "f2", "contact"))
    sample = np.array([[0.0, 1, 2, 3, 4, 7.0, 8.0, 0.0], [0.01, 1, 2, 3, 4, 7.0, 8.0, 200.0]])
    assert own.arranged(sample)[:, 5:].tolist() == [[8.0, 7.0, 0.0], [8.0, 7.0, 1.0]]
    faint = np.array([[0.02, 1, 2, 3, 4, 7.0, 8.0, 9.0]])
    assert own.arranged(faint)[0, 7] == 0.0
    switch = Outside.of(MODEL, ("contact",))
    assert switch.arranged(np.array([[0.0, 1, 2, 3, 4, 1.0], [0.0, 1, 2, 3, 4, 0.0]]))[:, 5].tolist() == [1.0, 0.0]
    measured = Outside.of(MODEL, ("grf_z", "contact"))
    assert measured.arranged(np.array([[0.0, 1, 2, 3, 4, 90.0, 1.0]]))[0, 5:].tolist() == [90.0, 0.0]


def test_what_is_not_measured_or_comes_late_is_refused_in_words() -> None:
    model = MODEL.with_forces(CUFF)
    with pytest.raises(ExoidError, match="no column f2"):
        Outside.of(model, ("f1",))
    with pytest.raises(ExoidError, match="watch the recording afterwards"):
        Outside.of(MODEL.with_forces(replace(CUFF, delay=0.02)), ("f2",))
    with pytest.raises(ExoidError, match="this machine has 6: t, q1, q2, tau1, tau2, f2"):
        Watcher(model).push(np.zeros((3, 5)))
    with pytest.raises(RecordingError, match="no f2"):
        stream_of(model, Recording("bare", *bare()))


def bare() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    own = rows(5.0)
    return own[:, 0], own[:, 1:3], own[:, 3:]


def test_a_recording_gives_its_forces_and_where_its_torques_say_nothing() -> None:
    t, q, tau = bare()
    unseen = (t > 1.0) & (t < 1.5)
    one = Recording("run", t, q, tau, forces={"f1": waving(t)}, torque_valid=np.repeat(~unseen[:, None], 2, axis=1))
    samples, names = stream_of(MODEL, one)
    assert names == ("f1", UNSEEN) and samples.shape == (len(t), 7)
    assert np.array_equal(samples[:, 6] > 0.0, unseen) and np.array_equal(samples[:, 5], waving(t))


def test_mappings_with_forces_are_followed() -> None:
    own = rows(6.0)
    samples = [{"t": r[0], "q1": r[1], "q2": r[2], "tau1": r[3], "tau2": r[4], "f1": 1.0} for r in own]
    assert [e.event for e in follow(MODEL, samples)] == ["start", "summary"]
    cuffs = MODEL.with_forces(CUFF)
    assert [e.event for e in follow(cuffs, np.column_stack([own, own[:, 0]]))] == ["start", "summary"]


def test_lines_bring_the_forces_they_name_and_keep_to_them() -> None:
    lines = Lines(LEG)
    text = "t,q1,q2,tau1,tau2,f1 [N],contact\n0,.5,-.8,1,2,3,0\n0.01,.5,-.8,1,2,4,1\n"
    assert lines.feed(text)[:, 5:].tolist() == [[3.0, 0.0], [4.0, 1.0]] and lines.outside == ("f1", "contact")
    assert lines.feed("t,q1,q2,tau1,tau2\n0.02,.5,-.8,1,2\n").shape == (0, 7) and "force f1" in lines.lost
    with pytest.raises(RecordingError, match="force f2"):
        Lines(LEG, forces=("f2",)).feed("t,q1,q2,tau1,tau2,f1\n0,.5,-.8,1,2,3\n")
    assert Lines(LEG, forces=("f2",)).feed("0,.5,-.8,1,2,3\n0.01,.5,-.8,1,2,4\n").shape == (2, 6)


@pytest.mark.slow
def test_a_change_that_ends_is_said_to_be_over() -> None:
    own = rows(125.0)
    t, speed = own[:, 0], np.gradient(own[:, 2], own[:, 0])
    own[:, 4] += np.where((t > 60.0) & (t < 88.0), 1.5 * np.tanh(speed / 0.05), 0.0)
    watcher = Watcher(MODEL, QUICK)
    told = [e for e in watched(watcher, own) if e.alarm]
    assert told[0].event == "change" and "coulomb:knee" in {told[0].names[0], *told[0].differences.found[0].look_alikes}
    assert told[-1].kind == "over" and 88.0 < told[-1].t < 115.0 and watcher.changed == ()


def several(count: int, t: float = 0.0) -> list[pushes.Push]:
    return [pushes.Push(1, t + k, t + k + 0.4, 3.0 + k) for k in range(count)]


def test_pushes_without_number_are_told_as_one_and_taken_back_where_they_do_not_explain() -> None:
    detector = SimpleNamespace(deviation=lambda: SimpleNamespace(alarms=True))
    own = pushes.Pushes(LEG, seen=several(300))
    own.told.extend(several(2, t=-100.0))
    assert own.explain(SimpleNamespace(detector=detector), 400.0, lambda: None) == [] and len(own.told) == 2
    detector.deviation = lambda: SimpleNamespace(alarms=False)
    (event,) = own.explain(SimpleNamespace(detector=detector), 400.0, lambda: None)
    assert event.more["count"] == 300 and "nothing has changed" in event.sentence and not event.alarm
    assert own.since(100.0) == 200


def test_an_error_that_comes_and_goes_is_suspected_to_be_a_person_or_the_ground(monkeypatch) -> None:
    answer = SimpleNamespace(found=(), rms_after=(1.0, 2.0))
    monkeypatch.setattr(wording, "replace", lambda one, **changes: one)
    for count, asked in ((2, False), (3, True)):
        said = wording.nameless_event(10.0, ("hip", "knee"), answer, np.array([1.0, 9.0]), 1.5, count)
        assert ("a person, or the ground?" in said.sentence) is asked and said.more["pushes"] == count
