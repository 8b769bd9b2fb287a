"""Thresholds of preparation and of what is said of a fit: on one side one statement, on the other the other one."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exoid.diagnosis import extend
from exoid.ground.errors import RecordingError
from exoid.measurement.recording import Recording
from exoid.measurement.signals.conditioning import UniformSignals
from exoid.measurement.signals.masks import widen
from exoid.optimisation.fitting.by_recording import _row
from exoid.optimisation.fitting.neighbours import Neighbours
from exoid.optimisation.fitting.thigh_length import ThighLength
from exoid.optimisation.preparation import cutoff
from exoid.optimisation.preparation.cutoff import _Noise
from exoid.optimisation.preparation.filtering import _reads_nothing, prepare_one
from exoid.optimisation.preparation.prepare import _check_base, _refuse_driven, prepare
from exoid.optimisation.preparation.sticking import STICK, sticking
from exoid.symbolic.model import Model


def swinging(seconds=10.0, knee=1.0):
    t = np.arange(0.0, seconds, 0.01)
    q = np.column_stack([0.5 * np.sin(2.0 * t), 0.5 * np.sin(3.1 * t)])
    return Recording("run", t, q, np.column_stack([10.0 * np.sin(2.0 * t), 10.0 * knee * np.sin(3.1 * t)]))


@pytest.mark.shows("thigh_length.FAR", "thigh_length.HELPS", "thigh_length.VAGUE")
@pytest.mark.parametrize(
    ("value", "high", "gain", "told", "wrong"),
    [
        (0.50, 0.52, 0.3, True, True),
        (0.45, 0.46, 0.3, True, False),
        (0.50, 0.52, 0.06, True, False),
        (0.50, 1.10, 0.3, False, False),
    ],
)
def test_another_thigh_length_is_wanted_where_it_is_far_known_and_helps(value, high, gain, told, wrong):
    found = ThighLength(0.40, value, 0.44 if value < 0.5 else 0.48, high, (gain, 0.0))
    assert (found.told, found.wrong) == (told, wrong)


@pytest.mark.shows("neighbours.BEYOND")
@pytest.mark.parametrize(("value", "moved"), [(1.007, False), (1.015, True)])
def test_a_value_has_moved_that_leaves_its_interval_by_more_than_rounding(value, moved):
    fit = SimpleNamespace(estimates=[SimpleNamespace(name="c", low=0.8, high=1.0)])
    assert Neighbours(fit, 5.0, (6.0,), (np.array([value]),)).agree is not moved


@pytest.mark.shows("by_recording.STRICT", "by_recording.USEFUL")
@pytest.mark.parametrize(
    ("other", "half", "said"),
    [
        (1.35, 0.2, "agree"),
        (1.45, 0.2, "contradict"),
        (4.0, 0.9, "contradict"),
        (4.0, 1.3, "one recording determines it"),
    ],
)
def test_recordings_contradict_each_other_where_chance_does_not_explain_it(other, half, said):
    row = _row("viscous", "N·m·s/rad", (1.0, 0.1), [(1.0, 0.2), (other, half)], 0.01)
    assert row.verdict == said


@pytest.mark.shows("cutoff.BIAS_LIMIT", "cutoff.NOISE_LIMIT")
@pytest.mark.parametrize(
    ("share", "carried", "clean"), [(0.004, 0.04, True), (0.006, 0.04, False), (0.004, 0.06, False)]
)
def test_a_cut_off_is_clean_where_little_noise_reaches_the_model(share, carried, clean):
    assert _Noise(share, carried).clean is clean


@pytest.mark.shows("prepare.UNDRIVEN")
@pytest.mark.parametrize(("knee", "refused"), [(0.45, False), (0.55, True)])
def test_a_joint_that_is_driven_is_not_passive(knee, refused):
    recording = swinging(knee=knee).with_passive("knee")
    if not refused:
        _refuse_driven(recording)
        return
    with pytest.raises(RecordingError, match="it was driven"):
        _refuse_driven(recording)


@pytest.mark.shows("prepare.LEAST_CYCLES")
def test_a_cut_off_so_slow_that_it_leaves_nothing_is_refused():
    with pytest.raises(RecordingError, match="leaves nothing of a recording of"):
        prepare(Model.standard(), [swinging(3.0)], cutoff=0.6)
    assert prepare(Model.standard(), [swinging(4.0)], cutoff=0.6).train


@pytest.mark.shows("prepare.SWAYS")
@pytest.mark.parametrize(("turn", "said"), [(0.018, 0), (0.022, 1)])
def test_a_base_that_turns_is_told_where_the_model_has_none(turn, said):
    run = swinging()
    base = np.column_stack([0.5 * turn * np.sin(run.t), np.zeros((len(run.t), 2))])
    assert len(_check_base(Model.standard(), [replace(run, base=base)])) == said


class Cutoffs:
    """What trials of cut-offs say: all clean, this share of noise at the fastest, and how much worse it predicts."""

    def __init__(self, share: float, worse: float, filter_decides: bool = False):
        self.tried, self.share, self.worse = cutoff.CUTOFFS, share, worse
        self.filter_decides = lambda fastest: filter_decides

    def __call__(self, *given):
        return self

    def noise(self, k, of=None):
        return _Noise(self.share if k + 1 == len(self.tried) else 0.0, 0.0)

    def relative(self, weighed):
        return {k: self.worse if k + 1 == len(self.tried) else 1.0 for k in weighed}


@pytest.mark.shows("cutoff.TOLERANCE", "cutoff.NOISE_SEEN", "cutoff.LOOSE_TOLERANCE")
@pytest.mark.parametrize(
    ("share", "worse", "decides", "chosen"),
    [
        (0.0, 1.02, False, 12.0),
        (0.0, 1.045, False, 10.0),
        (0.7e-4, 1.1, False, 10.0),
        (1.5e-4, 1.1, False, 12.0),
        (1e-3, 1.2, False, 12.0),
        (1e-3, 1.3, False, 10.0),
        (0.0, 1.2, True, 12.0),
    ],
)
def test_the_fastest_cut_off_is_chosen_that_predicts_as_well_as_any(share, worse, decides, chosen, monkeypatch):
    monkeypatch.setattr(cutoff, "_Trials", Cutoffs(share, worse, decides))
    found = cutoff.choose_cutoff(Model.standard(), [("run", SimpleNamespace(rate=100.0))], np.zeros(8), "butterworth")
    assert found.cutoff == chosen


@pytest.mark.shows("cutoff.FILTER")
@pytest.mark.parametrize(("wrong", "decides"), [(0.25, False), (0.4, True)])
def test_the_filter_decides_where_it_makes_a_third_of_the_error(wrong, decides, monkeypatch):
    """The error at the slowest cut-off is 1 N·m."""
    data = SimpleNamespace(groups=np.zeros(9), use=np.ones((1, 9)), residual=lambda x: np.ones((1, 9)))
    said = {"mean_square": np.array([wrong**2]), "assemble": data, "_folds": [np.ones(9, bool)], "_part": data}
    said |= dict.fromkeys(("prepare_one", "torque_of_filter", "_torque_of_slower", "_fit"))
    for name, answer in said.items():
        monkeypatch.setattr(cutoff, name, lambda *given, answer=answer: answer)
    trials = cutoff._Trials(SimpleNamespace(joints=(None,)), [("run", None)], np.zeros(8), "", (3.0,))
    assert trials.filter_decides(0) is decides


def signals(*angles: np.ndarray, tau: np.ndarray | None = None) -> UniformSignals:
    """Angles at 100 Hz, and their torques (N, J)."""
    q = np.column_stack(angles)
    none = np.zeros(q.shape[1], bool)
    torque = q.copy() if tau is None else tau
    gap = np.zeros(q.shape, bool)
    return UniformSignals(np.arange(len(q)) / 100.0, q, torque, gap[:, 0], gap, 100.0, none)


T = np.arange(0.0, 30.0, 0.01)
SWING = 0.5 * np.sin(2.0 * T)


@pytest.mark.shows("sticking.STICK")
@pytest.mark.parametrize(("speed", "used"), [(0.022, False), (0.042, True)])
def test_a_joint_that_creeps_may_stick_and_is_not_fitted(speed, used):
    one = prepare_one(Model.standard(), "run", signals(SWING, speed * T), 5.0, None)
    assert bool(one.used[1].any()) is used


def stopping(stay):
    """A swing (N,) at 100 Hz that stays `stay` s where it turns back."""
    going = np.arange(0.0, 30.0, 1e-4)
    stops = np.floor(2.0 * going / np.pi + 0.5)
    return np.interp(T, going + stay * stops, 0.5 * np.sin(2.0 * going))


@pytest.mark.shows("sticking.STICK_REACH")
def test_samples_near_standstill_are_left_out_as_far_as_the_filter_smears_it():
    """Half a period of 10 Hz on either side of each standstill: angles are filtered at twice the cut-off."""
    q = stopping(0.1)
    one = prepare_one(Model.standard(), "run", signals(q, q), 5.0, None)
    slow = np.abs(one.direction.velocity[:, 0]) < STICK
    inside, near = slice(100, -100), widen(slow, 5)
    assert slow[inside].mean() < 0.1 and near[inside].mean() > 0.1
    assert np.mean(one.stuck[inside, 0] != near[inside]) < 0.01


def test_a_joint_that_turns_back_at_once_is_left_out_only_where_it_is_slow():
    one = prepare_one(Model.standard(), "run", signals(SWING, SWING), 5.0, None)
    slow = np.abs(one.direction.velocity[100:-100, 0]) < STICK
    assert np.array_equal(one.stuck[100:-100, 0], slow)


@pytest.mark.shows("sticking.DWELL")
@pytest.mark.parametrize(("change", "sticks"), [(0.08, True), (0.1, False)])
def test_a_joint_that_stays_between_two_samples_sticks_there(change, sticks):
    speed = 0.05 + 0.1 * np.arange(-40.0, 40.0)
    speed[40:] += change - 0.1
    found = sticking(np.column_stack([speed, 5.0 + 0.0 * speed]), np.ones(2), 4)
    assert found[36:44, 0].all() if sticks else not found[:, 0].any()
    assert not found[:, 1].any()


@pytest.mark.shows("filtering.LOADED")
@pytest.mark.parametrize(("wave", "bears"), [(0.6, False), (1.3, True)])
def test_a_joint_has_a_drive_where_its_torque_varies_more_than_noise(wave, bears):
    noise = np.random.default_rng(1).standard_normal(T.size)
    little = noise + wave * np.sqrt(2.0) * np.sin(2.0 * np.pi * 0.3 * T)
    tau = np.column_stack([1e4 * np.sin(2.0 * np.pi * 0.3 * T), little])
    even = SimpleNamespace(reach=np.ones(2), tau=tau, span=np.ptp(tau, axis=0), despiked=tau, rate=100.0)
    assert _reads_nothing(even, 5.0).tolist() == [False, not bears]


@pytest.mark.parametrize(("fall", "helped"), [(0.0015, False), (0.003, True)])
def test_an_effect_added_by_hand_helps_where_the_error_falls(fall, helped, monkeypatch):
    term = SimpleNamespace(name="stribeck:hip", may_move=False)
    model = SimpleNamespace(with_effect=lambda effect, joint: SimpleNamespace(terms=[term]), forces=())
    said = {
        "compiled": SimpleNamespace(backend="vm"), "identify": SimpleNamespace(estimates=[]), "_fall": fall,
        "_waterfall": SimpleNamespace(steps=[]), "_admissible": "", "sentence_of": "It", "biased_parameters": (),
        "prepare": SimpleNamespace(train=[]),
        "fitted_model": SimpleNamespace(judged_anew=lambda: SimpleNamespace(train=[])),
        "model_of": None, "machine_of": None, "question_of": (model, [], []),
    }  # fmt: skip
    for name, answer in said.items():
        monkeypatch.setattr(extend, name, lambda *given, answer=answer, **more: answer)
    found = extend.add(model, "stribeck:hip", [])
    assert found.helped is helped
    assert ("does not lower" in found.sentence) is not helped


class Uneven(Cutoffs):
    """Trials in which another cut-off predicts each joint best, and of which none is clean."""

    def noise(self, k, of=None):
        return _Noise(1.0, 1.0)

    def relative(self, weighed):
        return {k: 1.8 - 0.1 * k for k in weighed}


def test_where_every_joint_wants_another_cut_off_one_is_chosen(monkeypatch):
    monkeypatch.setattr(cutoff, "_Trials", Uneven(1.0, 1.0))
    found = cutoff.choose_cutoff(Model.standard(), [("run", SimpleNamespace(rate=100.0))], np.zeros(8), "butterworth")
    assert found.cutoff == 6.0


def test_of_cut_offs_that_tie_and_are_not_clean_the_lowest_is_chosen(monkeypatch):
    class Alike(Uneven):
        def relative(self, weighed):
            return {k: 1.0 + 1e-3 * (k % 2) for k in weighed}

    monkeypatch.setattr(cutoff, "_Trials", Alike(1.0, 1.0))
    found = cutoff.choose_cutoff(Model.standard(), [("run", SimpleNamespace(rate=100.0))], np.zeros(8), "butterworth")
    assert found.cutoff == cutoff.CUTOFFS[0]
