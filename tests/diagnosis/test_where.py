"""Where the error sits: shares of one whole, the largest first."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exoid.diagnosis.evidence.remainder import Remainder
from exoid.diagnosis.where import samples_of, where_it_sits
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion

RNG = np.random.default_rng(3)


def model_that_left(residual):
    """Return a fitted model that left `residual(motion)` (N,) at the knee of two recordings, and noise at the hip."""
    leg, recordings, left = Model.standard(), [], []
    for start in (0.0, 40.0):
        t = start + np.arange(0.0, 20.0, 0.02)
        q = np.column_stack([0.5 + 0.4 * np.sin(1.3 * t), -0.8 + 0.5 * np.sin(2.1 * t)])
        dq = np.column_stack([0.52 * np.cos(1.3 * t), 1.05 * np.cos(2.1 * t)])
        motion = Motion(t, q, dq, np.gradient(dq, 0.02, axis=0), np.sign(dq))
        one = SimpleNamespace(t=t, motion=motion, used=np.ones(q.T.shape, bool), kept=slice(None), kept_rate=50.0)
        recordings.append(one)
        left.append(np.stack([0.1 * RNG.standard_normal(len(t)), residual(motion) + 0.1 * RNG.standard_normal(len(t))]))
    prepared = SimpleNamespace(train=tuple(recordings), all=tuple(recordings), verify=())
    return SimpleNamespace(model=leg, prepared=prepared, residuals=left)


def curve(variable, share, factor=""):
    flat = np.zeros(3)
    return Remainder("knee", variable, factor, share, share, None, flat, flat, flat, joint_share=share)


def test_two_names_of_one_cause_count_once():
    # Knee angle and knee acceleration are one thing on a sine: what one explains the other cannot explain again.
    now = model_that_left(lambda motion: np.sin(3.0 * motion.q[:, 1]))
    found = where_it_sits(now, [curve("q2", 0.9), curve("ddq2", 0.85)])
    assert [one.variable for one in found] == ["q2"]
    assert found[0].share == pytest.approx(0.9)


def test_two_causes_share_the_error_between_them():
    now = model_that_left(lambda motion: np.sin(6.0 * motion.q[:, 1]) + 0.6 * np.sign(motion.dq[:, 0]) * motion.q[:, 0])
    first = curve("q2", 0.7)
    found = where_it_sits(now, [first, curve("dq1", 0.65)])
    assert {one.variable for one in found} == {"q2", "dq1"}
    assert sum(one.share for one in found) <= 1.0
    assert "a further" in found[1].sentence and "a further" not in found[0].sentence


def test_what_turns_with_the_motion_is_split_by_direction():
    now = model_that_left(lambda motion: np.sign(motion.dq[:, 1]) * (1.0 + motion.q[:, 1] ** 2))
    (found,) = where_it_sits(now, [curve("q2", 0.95, "sign")])
    assert found.split == "direction" and found.share > 0.9


def test_what_sits_elsewhere_in_each_recording_is_split_by_recording():
    now = model_that_left(lambda motion: np.sin(3.0 * motion.q[:, 1]) * (1.0 if motion.t[0] else -1.0))
    (found,) = where_it_sits(now, [curve("q2", 0.9), replace(curve("q2", 0.8), own=True)])
    assert found.split == "recording" and found.share == pytest.approx(0.8)


def test_samples_know_recording_and_block():
    now = model_that_left(lambda motion: 0.0 * motion.t)
    at = samples_of(now, "knee", "t")
    assert set(at.recording) == {0, 1} and len(set(at.block)) == 20
    assert at.x.max() == pytest.approx(19.98)


@pytest.mark.parametrize(("share", "lines"), [(0.015, 1), (0.008, 0)])
def test_a_curve_is_worth_a_line_from_a_hundredth_of_the_error(share, lines):
    now = model_that_left(lambda motion: np.sin(3.0 * motion.q[:, 1]))
    assert len([one for one in where_it_sits(now, [curve("q2", share)]) if "follows" in one.sentence]) == lines
