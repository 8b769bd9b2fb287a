"""Torques that were logged late, angles in coarse steps: what sensors do passes for no effect of the machine.

Every effect is late with the torque, and so are the moments in which a joint sticks.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exoid.diagnosis.discovery import discover
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.symbolic.model import Model


def runs_of(effects=(), seed=0):
    return [run.recording for run in simulate_runs(4, effects=effects, seed=seed, bench=Bench(duration=25.0))]


def late_runs(seconds: float, effects=(), seed=0):
    runs = runs_of(effects, seed)
    moved = (np.stack([np.interp(r.t - seconds, r.t, tau) for tau in r.tau.T], axis=1) for r in runs)
    return [replace(r, tau=tau) for r, tau in zip(runs, moved, strict=True)]


@pytest.mark.slow
def test_a_delay_beside_another_effect_leaves_that_as_it_is():
    """Of columns that came too early false entries made up: elasticity, a rotor and a spring beside the ripple."""
    runs = late_runs(0.02, "torque_ripple:knee")
    found = {item.name: item.parameters for item in discover(Model.standard(), runs[:3], runs[3:]).accepted}
    assert found.keys() == {"torque_ripple:knee", "time_delay:hip", "time_delay:knee"}
    assert found["torque_ripple:knee"]["n"].value == pytest.approx(60.0, abs=0.1)
    assert all(found[f"time_delay:{joint}"]["d"].value == pytest.approx(0.02, abs=5e-4) for joint in ("hip", "knee"))


@pytest.mark.slow
def test_late_torques_show_later_that_a_joint_sticks():
    """Those samples were hidden when the joint stuck, and counted when the torque showed it: friction by position."""
    runs = late_runs(0.1, seed=1)
    found = {item.name: item.parameters for item in discover(Model.standard(), runs[:3], runs[3:]).accepted}
    assert found.keys() == {"time_delay:hip", "time_delay:knee"}
    assert all(item["d"].value == pytest.approx(0.1, abs=2e-3) for item in found.values())


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 2])
def test_an_encoder_with_coarse_steps_makes_no_drive_soft(seed):
    """The error began at the noise floor and ended a quarter below it, with an elasticity at the hip, "very sure"."""
    runs = [replace(run, q=0.01 * np.round(run.q / 0.01)) for run in runs_of(seed=seed)]
    assert discover(Model.standard(), runs[:3], runs[3:]).verdict == "adequate"


@pytest.mark.slow
def test_zeros_of_two_encoders_are_no_mass_off_the_thighs_axis():
    """That and a tilt came nearest at first, and stayed: -0.57 kg·m and -4 degrees, where both explained 98 %."""
    hip, knee = np.deg2rad([12.0, -8.0])
    runs = [replace(run, q=run.q + np.array([hip, knee])) for run in runs_of()]
    found = {item.name: item for item in discover(Model.standard(), runs[:3], runs[3:]).accepted}
    assert found.keys() == {"gravity_tilt", "com_offset_shank"}
    assert found["gravity_tilt"].parameters["tilt"].value == pytest.approx(-hip, abs=2e-3)
    assert "encoder_offset_knee" in found["com_offset_shank"].look_alikes
