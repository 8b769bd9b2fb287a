"""A drive too soft for its encoder is found from the measured torque, and nothing else is taken for it."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from exoid.diagnosis.discovery import discover
from exoid.diagnosis.evidence import soft_drive as soft_drives
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model
from exoid.diagnosis.evidence.soft_drive import soft_drive, twist
from exoid.diagnosis.rules import RULES
from exoid.diagnosis.verdict import behind as behind_drive
from exoid.measurement.recording import Recording
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float, Motion
from tests.made_recordings import BETA, motion

MODEL = Model.standard()
NOISE = np.array([0.02, 0.02])


def behind(joint: int, compliance: float, seed: int, seconds: float = 12.0) -> Recording:
    """Return a recording of links that move as given, with the encoder of `joint` before a drive that gives way."""
    link = motion(seed, seconds)
    rigid = np.where(np.arange(8) < 4, BETA, 0.0)
    turned = np.zeros_like(link.q)
    turned[:, joint] = compliance * MODEL.torque(link, rigid)[:, joint]
    speed = np.gradient(turned, link.t, axis=0)
    seen = Motion(link.t, link.q + turned, link.dq + speed, link.ddq)
    tau = MODEL.torque(link, rigid) + MODEL.torque(seen, BETA - rigid)
    rng = np.random.default_rng(seed)
    return Recording(
        f"run {seed}", link.t, seen.q + 1e-5 * rng.normal(size=tau.shape), tau + 0.02 * rng.normal(size=tau.shape)
    )


def fitted(model: Model, runs: list[Recording]) -> FittedModel:
    prepared = prepare(model, runs[:2], runs[2:], cutoff=5.0)
    return fitted_model(identify(model, prepared.train, optimisers=()), prepared)


@pytest.mark.parametrize(("joint", "compliance"), [("hip", 0.005), ("knee", 0.015)])
def test_a_drive_whose_resonance_lies_in_the_motion_is_found_with_its_stiffness(joint, compliance):
    base = fitted(MODEL, [behind(("hip", "knee").index(joint), compliance, k) for k in range(3)])
    found = soft_drive(base, base, NOISE)
    assert found is not None and found.joint == joint
    assert found.compliance == pytest.approx(compliance, rel=0.25)
    assert found.sure and found.share < 0.3 and np.all(found.after < found.before)
    assert soft_drive(base, base, base.evaluation_rms) is None  # it is not asked about noise


def test_a_soft_drive_is_asked_about_where_an_error_near_the_noise_follows_a_variable():
    base = fitted(MODEL, [behind(0, 0.005, k) for k in range(3)])
    noise = 0.5 * base.evaluation_rms
    assert soft_drive(base, base, noise) is None
    found = soft_drive(base, base, noise, follows="hip")
    assert found is not None and found.joint == "hip"


def test_how_much_better_a_soft_drive_must_be():
    base = fitted(MODEL, [behind(0, 0.005, k) for k in range(3)])
    assert soft_drive(base, base, 0.1 * NOISE, replace(RULES, half=1e-4)) is None


def test_a_soft_drive_explains_the_motion_it_was_fitted_to_as_well(monkeypatch):
    base = fitted(MODEL, [behind(0, 0.005, k) for k in range(3)])
    found = soft_drive(base, base, NOISE)
    assert found is not None and np.all(found.fitted < base.train_rms)
    monkeypatch.setattr(soft_drives, "swinging", lambda fitted: None)
    for left, kept in ((0.45, True), (0.55, False)):
        rest = found.fitted / np.sqrt(left)
        last = SimpleNamespace(model=base.model, evaluation_rms=base.evaluation_rms, train_rms=rest)
        monkeypatch.setattr(soft_drives, "_best", lambda fitted, joint: found)
        assert (soft_drive(base, last, 0.01 * NOISE) is not None) is kept


def test_what_a_soft_drive_leaves_is_counted_beyond_the_noise_and_at_all_joints_together(monkeypatch):
    """At the knee it leaves two thirds of the squared error: nearly all of that is noise."""
    base = fitted(MODEL, [behind(0, 0.005, k) for k in range(3)])
    found = soft_drive(base, base, NOISE)
    assert found is not None
    monkeypatch.setattr(soft_drives, "swinging", lambda fitted: None)
    left = replace(found, after=np.array([1.05, 1.2]), fitted=np.array([1.05, 1.2]))
    monkeypatch.setattr(soft_drives, "_best", lambda fitted, joint: left)
    for hip, kept in ((2.0, True), (1.1, False)):
        error = np.array([hip, np.sqrt(1.5) * 1.2])
        last = SimpleNamespace(model=base.model, evaluation_rms=error, train_rms=error)
        asked = soft_drive(base, last, np.full(2, 0.99), replace(RULES, near_noise=1.05, half=0.4))
        assert (asked is not None) is kept


def test_the_entry_of_the_catalogue_cannot_express_it():
    runs = [behind(0, 0.008, k) for k in range(3)]
    base, entry = fitted(MODEL, runs), fitted(MODEL.with_effect("motor_elasticity:hip"), runs)
    found = soft_drive(base, entry, NOISE)
    assert found is not None and found.name == "motor_elasticity:hip"
    assert np.all(found.after < 0.6 * entry.evaluation_rms)


def test_a_few_seconds_show_no_soft_drive():
    runs = [behind(0, 0.005, k, seconds=7.0) for k in range(3)]
    assert soft_drive(fitted(MODEL, runs), fitted(MODEL, runs), NOISE) is None


def extras(one: Motion, seed: int) -> dict[str, Float]:
    """Return torques (N, 2) that no elastic drive makes."""
    rng = np.random.default_rng(seed)
    stop = np.column_stack([0.0 * one.t, -60.0 * np.maximum(-1.1 - one.q[:, 1], 0.0)])
    sway = np.outer(np.sin(2.0 * np.pi * 0.9 * one.t + rng.uniform(0.0, 6.0)), [3.0, 1.0])
    stuck = 2.0 * np.tanh(np.cumsum(rng.normal(size=one.q.shape), axis=0) / 20.0)
    return {"stop": stop, "sway": sway, "stuck": stuck, "rotor": one.ddq * [0.0, 0.3]}


@pytest.mark.slow
@pytest.mark.parametrize("what", ["stop", "sway", "stuck", "rotor"])
def test_what_is_no_elastic_drive_is_not_taken_for_one(what):
    runs = []
    for k in range(3):
        path, rng = motion(k), np.random.default_rng(k)
        tau = MODEL.torque(path, BETA) + extras(path, k)[what] + 0.1 * rng.normal(size=path.q.shape)
        runs.append(Recording(f"run {k}", path.t, path.q + 1e-5 * rng.normal(size=path.q.shape), tau))
    base = fitted(MODEL, runs)
    assert soft_drive(base, base, 0.1 * NOISE) is None


def test_the_twist_is_that_of_load_and_link():
    """Where both agree it is theirs; the load alone decides at the ends."""
    t = np.arange(0.0, 4.0, 0.005)
    delta = 0.05 * np.sin(5.0 * t)
    slopes = (np.full(t.size, 8.0), np.full(t.size, 0.5), np.full(t.size, 1.5))
    own = 8.0 * delta + 0.5 * 0.25 * np.cos(5.0 * t) - 1.5 * 25.0 * delta
    load = delta / 0.004
    np.testing.assert_allclose(twist(load, load + own, slopes, 0.004, 200.0), delta, atol=2e-5)
    noisy = load + np.random.default_rng(0).normal(size=t.size)
    found = twist(noisy, load + own, slopes, 0.004, 200.0)
    assert np.std(np.diff(found, 2)) < 0.02 * np.std(np.diff(0.004 * noisy, 2))


def test_which_drive_gives_way_is_not_sure_where_the_other_joints_show_nothing_of_it():
    base = fitted(MODEL, [behind(0, 0.005, k) for k in range(3)])
    sure = soft_drive(base, base, NOISE)
    assert "not sure" not in behind_drive(sure, MODEL.joints).sentence
    unsure = behind_drive(replace(sure, sure=False), MODEL.joints)
    assert "not sure" in unsure.sentence and unsure.next_experiment.endswith("then the other drives")


@pytest.mark.slow
def test_nothing_is_accepted_in_place_of_a_soft_drive():
    runs = [behind(0, 0.005, k) for k in range(4)]
    found = discover(MODEL, runs[:3], runs[3:])
    assert found.verdict == "unexplained" and not found.accepted
    assert "motor_elasticity:hip" in found.sentence and "hip" in found.next_experiment
    assert all(one.reason for one in found.possible)
