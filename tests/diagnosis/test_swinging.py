"""A line that every recording has in what is left is found, and what follows the motion is not taken for one."""

from __future__ import annotations

import numpy as np
import pytest

from exoid.diagnosis.evidence.swinging import Swing, common_line

RATES, LASTS = (50.0, 40.0, 50.0), (25.0, 30.0, 20.0)


def signals(hertz: float, size: float, noise: float = 0.2):
    """Return what is left and torques of recordings that swing with phases of their own."""
    rng = np.random.default_rng(4)
    left, torque = [], []
    for rate, lasts in zip(RATES, LASTS, strict=True):
        t = np.arange(0.0, lasts, 1.0 / rate)
        left.append(size * np.sin(2 * np.pi * hertz * t + rng.uniform(0, 6)) + noise * rng.standard_normal(t.size))
        torque.append(5.0 * np.sin(2 * np.pi * 0.2 * t + 1.0) + 3.0 * np.cos(2 * np.pi * 0.5 * t))
    return left, torque


def test_a_sway_of_another_phase_in_every_recording_is_found():
    left, torque = signals(0.93, 1.0)
    hertz, share = common_line(left, torque, RATES)
    assert hertz == pytest.approx(0.93, abs=0.02) and share > 0.5
    told = Swing("hip", hertz, share)
    assert "0.93 Hz" in told.sentence and "base_motion" in told.advice


def test_noise_a_line_of_the_motion_and_a_line_in_one_recording_are_none():
    left, torque = signals(0.93, 0.0)
    assert common_line(left, torque, RATES) is None
    assert common_line(*signals(0.5, 1.0), RATES) is None
    one, _ = signals(0.93, 1.0)
    assert common_line([one[0], *left[1:]], torque, RATES) is None
    assert common_line(one[:1], torque[:1], RATES[:1]) is None
