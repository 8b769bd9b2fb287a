"""Thresholds of preparation and of what is said of a fit: on one side one statement, on the other the other one."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from ground.errors import RecordingError
from measurement.recording import Recording
from optimisation.fitting.by_recording import _row
from optimisation.fitting.neighbours import Neighbours
from optimisation.fitting.thigh_length import ThighLength
from optimisation.preparation.cutoff import _Noise
from optimisation.preparation.prepare import _check_base, _refuse_driven, prepare
from symbolic.model import Model


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
