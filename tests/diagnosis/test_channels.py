"""Channels that cannot be what they say are named before any effect is; an error that is not noise is not adequate."""

from __future__ import annotations

import re
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.signal import lfilter

from exoid.diagnosis.cautions import cautions
from exoid.diagnosis.comparison import compare
from exoid.diagnosis.discovery import discover
from exoid.diagnosis.evidence.channel_doubt import Doubt, left_share
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model
from exoid.diagnosis.evidence.model_error import model_error, repeats
from exoid.diagnosis.hypotheses.channels import Asked, doubts_after, doubts_before, unexplained_torque
from exoid.diagnosis.results import Diagnosis
from exoid.diagnosis.rules import RULES
from exoid.measurement.bench.simulation import Bench, run_bench
from exoid.measurement.reading.read import read_recording
from exoid.measurement.recording import Recording
from exoid.measurement.signals.conditioning import low_pass
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion
from tests.made_recordings import BETA, motion, recording

MODEL = Model.standard()


@pytest.fixture(scope="module")
def good() -> list[Recording]:
    return [recording(k) for k in range(3)]


def base(recordings, verify=()) -> FittedModel:
    prepared = prepare(MODEL, recordings, verify, cutoff=5.0)
    return fitted_model(identify(MODEL, prepared.train, optimisers=()), prepared)


def doubt(recordings, verify=()) -> Doubt | None:
    fitted = base(recordings, verify)
    return doubts_before(fitted) or doubts_after(fitted, fitted)


def unseen_by(fitted: FittedModel, **rules: float) -> bool:
    """Whether nothing is doubted where thresholds have other values."""
    other = replace(RULES, **rules)
    return doubts_before(fitted, other) is None and doubts_after(fitted, fitted, other) is None


def with_torque(one: Recording, tau) -> Recording:
    return replace(one, tau=tau)


def test_a_good_recording_raises_no_doubt(good):
    fitted = base(good[:2], good[2:])
    assert model_error(fitted, replace(RULES, near_noise=0.5)) is not None
    assert doubts_before(fitted) is None and doubts_after(fitted, fitted) is None
    assert np.all(left_share(fitted) < 0.01)
    assert model_error(fitted) is None


@pytest.mark.slow
@pytest.mark.parametrize("cutoff", [None, 0.5])
def test_noise_for_torque(good, cutoff):
    rng = np.random.default_rng(0)

    def noise(one):
        raw = rng.normal(size=one.tau.shape)
        raw = raw if cutoff is None else low_pass(raw, cutoff, one.rate)
        return with_torque(one, raw / raw.std(axis=0) * one.tau.std(axis=0))

    found = doubt([noise(one) for one in good])
    assert found is not None and "variance unexplained" in found.sentence and "--map" in found.remedy


@pytest.mark.slow
def test_torque_of_another_motion(good):
    fitted = base([with_torque(one, good[(k + 1) % 3].tau) for k, one in enumerate(good)])
    assert doubts_after(fitted, fitted) is not None
    assert "do not fit a leg" in doubts_after(fitted, fitted, replace(RULES, unexplained_share=2.0)).sentence
    assert unseen_by(fitted, unexplained_share=2.0, half=2.0)


def test_a_torque_of_which_nothing_is_explained_may_be_that_of_a_joint_without_a_drive(good):
    rng = np.random.default_rng(0)
    noise = [with_torque(one, np.column_stack([one.tau[:, 0], rng.normal(size=len(one.tau))])) for one in good]
    said = doubt(noise)
    assert said is not None and said.remedy.endswith("had no drive in these recordings, say so: --passive knee")


def test_what_a_curve_explains_of_a_torque_is_of_this_motion(good):
    begun = base([with_torque(one, one.tau + 15.0 * np.cos(6.0 * one.q) * [0.0, 1.0]) for one in good])
    rule = doubts_after(begun, begun).rule
    for share, doubted in ((0.98, False), (0.5, True)):
        found = unexplained_torque.doubt(Asked(begun, begun, RULES, SimpleNamespace(index=1, joint_share=share)))
        assert rule.startswith("the best model leaves") and (found is not None) is doubted


def test_a_spring_that_outweighs_the_machine_is_no_wrong_channel(good):
    spring = MODEL.with_effect("joint_spring:knee")
    sprung = [with_torque(one, one.tau + 60.0 * one.q * [0.0, 1.0]) for one in good]
    begun = base(sprung)
    found = fitted_model(identify(spring, begun.prepared.train, optimisers=()), begun.prepared)
    left = doubts_after(begun, begun, replace(RULES, unexplained_share=20.0))
    assert left is not None and "with numbers that no leg has" in left.sentence
    assert doubts_after(begun, found) is None


def found_in(recordings) -> Diagnosis:
    return discover(MODEL, recordings[:2], recordings[2:], seed=1)


@pytest.mark.slow
@pytest.mark.parametrize("late", [0.3, -0.2])
def test_torque_logged_late_or_early(good, late):
    found = found_in([with_torque(one, np.roll(one.tau, round(late * one.rate), axis=0)) for one in good])
    assert found.verdict == "check_channels" and not found.accepted
    assert f"comes {abs(late):g} s {'after' if late > 0 else 'before'} the motion" in found.sentence
    assert "shift the torque of the " in found.next_experiment and f" by {abs(late):g} s" in found.next_experiment


@pytest.mark.slow
@pytest.mark.parametrize("late", [(0.12, 0.35, 0.2), (0.0, 0.3, -0.2)])
def test_files_of_two_loggers_started_by_hand_are_each_told_their_time(good, late):
    moved = [with_torque(one, np.roll(one.tau, round(x * one.rate), axis=0)) for one, x in zip(good, late, strict=True)]
    found = found_in(moved)
    assert found.verdict == "check_channels" and not found.accepted and "the motion it belongs to" in found.sentence
    told = re.findall(r"run 0 (\S+) s, run 1 (\S+) s", found.next_experiment)
    assert told
    for pair in told:
        assert [float(x) for x in pair] == pytest.approx(late[:2], abs=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("hertz", [1.0, 2.0, 8.0])
def test_torque_behind_a_filter(good, hertz):
    pole = np.exp(-2.0 * np.pi * hertz / 100.0)
    filter_ = [1.0 - pole], [1.0, -pole]
    found = found_in([with_torque(one, lfilter(*filter_, one.tau, axis=0, zi=pole * one.tau[:1])[0]) for one in good])
    assert found.verdict == "check_channels" and "filter of first order" in found.sentence
    assert float(found.sentence.split(" Hz")[0].rsplit(" ", 1)[1]) == pytest.approx(hertz, rel=0.15)


@pytest.mark.slow
@pytest.mark.xfail(strict=True, reason="spikes before the filter are smeared: what is left follows nothing")
@pytest.mark.parametrize("hertz", [1.0, 2.0])
def test_torque_with_spikes_behind_a_slow_filter(good, hertz):
    rng = np.random.default_rng(4)
    pole = np.exp(-2.0 * np.pi * hertz / 100.0)

    def slow(one):
        spikes = 30.0 * rng.normal(size=one.tau.shape) * (rng.random(one.tau.shape) < 0.01)  # smeared by the filter
        tau = one.tau + spikes
        filtered, _ = lfilter([1.0 - pole], [1.0, -pole], tau, axis=0, zi=pole * tau[:1])
        return with_torque(one, filtered)

    found = found_in([slow(one) for one in good])
    assert found.verdict == "check_channels" and "filter of first order" in found.sentence


@pytest.mark.slow
def test_one_late_channel_is_told_from_a_late_logger(good):
    def late(one):
        return with_torque(one, np.column_stack([one.tau[:, 0], np.roll(one.tau[:, 1], round(0.3 * one.rate))]))

    spoilt = [late(one) for one in good]
    assert "The torque of the knee does not belong" in found_in(spoilt).sentence
    warned = [item.what for item in compare(MODEL, spoilt).audit if item.check == "channels"]  # without a search
    assert len(warned) == 1 and "The torque of the knee" in warned[0] and "0.3 s after" in warned[0]


@pytest.mark.slow
@pytest.mark.parametrize("late", [0.02, 0.05])
def test_a_little_delay_is_an_effect_and_no_wrong_channel(good, late):
    found = found_in([with_torque(one, delayed(late)(one.t, one.tau)) for one in good])
    assert {effect.effect for effect in found.accepted} == {"time_delay"}


def delayed(seconds):
    return lambda t, tau: np.column_stack([np.interp(t - seconds, t, column) for column in tau.T])


@pytest.mark.slow
def test_angles_too_noisy_for_accelerations(good):
    rng = np.random.default_rng(1)
    noisy = [replace(one, q=one.q + 0.05 * rng.normal(size=one.q.shape)) for one in good]
    prepared = prepare(MODEL, noisy)
    fitted = fitted_model(identify(MODEL, prepared.train, optimisers=()), prepared)
    found = doubts_before(fitted)
    assert found is not None and "rad at hip and " in found.sentence and "rad at knee" in found.sentence
    assert unseen_by(fitted, angle_noise=1.0)


@pytest.mark.slow
def test_held_out_recordings_of_another_leg(good):
    other = BETA * np.array([1.4, 1.6, 1.5, 0.5, 1.3, 0.7, 1.4, 1.2])
    found = discover(MODEL, good[:2], [recording(9, beta=other)])
    assert not found.accepted and "another machine" in found.sentence


@pytest.mark.slow
def test_a_fit_without_a_search_tells_its_doubts_too(good):
    assert not cautions(base(good))
    rng = np.random.default_rng(3)
    noise = [replace(one, tau=10.0 * rng.standard_normal(one.tau.shape)) for one in good]
    (finding,) = cautions(base(noise))
    assert finding.severity == "warning" and finding.check == "channels"
    assert "channels are wrong, or something large is missing" in finding.what and "--map" in finding.remedy
    found = compare(MODEL, noise, cutoff=5.0)
    assert finding.what in [one.what for one in found.audit]


@pytest.mark.slow
def test_nothing_is_accepted_and_the_verdict_says_what_to_check(good):
    found = discover(MODEL, [with_torque(one, np.roll(one.tau, 30, axis=0)) for one in good], cutoff=5.0)
    assert found.verdict == "check_channels" and not found.accepted and not found.suspects
    told = found.to_json()
    assert told["verdict"] == "check_channels" and "logger" in told["next_experiment"]


@pytest.mark.slow
@pytest.mark.parametrize("gear", [[50.0, 1.0], [1.0, 30.0]])
def test_a_torque_on_the_motors_side_of_a_gear_is_told_with_the_ratio(good, gear):
    fitted = [with_torque(one, one.tau / gear) for one in good]
    found = discover(MODEL, fitted, cutoff=5.0)
    assert found.verdict == "check_channels" and not found.accepted
    (doubt,) = prepare(MODEL, fitted, cutoff=5.0).misread
    assert doubt.check == "scale" and doubt.value == pytest.approx(gear[1] / gear[0], rel=0.15)
    assert doubt.remedy in found.next_experiment


@pytest.mark.slow
def test_noise_free_recordings_with_nothing_hidden_are_adequate():
    clean = [recording(k, noise=0.0, angle_noise=0.0) for k in range(3)]
    found = discover(MODEL, clean[:2], clean[2:])
    assert found.verdict == "adequate" and not found.accepted
    assert np.all(found.noise_floor > 0.0)


def hidden_error(seed: int, smooth_noise: bool) -> np.ndarray:
    """Return a torque (N, 2) that no effect describes: the same for the same motion, or other in every run."""
    path = motion(0)
    if smooth_noise:
        raw = low_pass(np.random.default_rng(seed).normal(size=path.q.shape), 2.0, 100.0)
        return 1.5 * raw / raw.std(axis=0)
    return 1.5 * np.sin(9.0 * path.q) * np.cos(4.0 * path.dq)


@pytest.mark.parametrize(("other", "share"), [(False, 0.9), (True, 0.2)])
def test_what_repeats_with_the_motion_is_told_from_what_does_not(other, share):
    runs = [recording(0, extra=hidden_error(k, other), name=f"run {k}") for k in range(3)]
    noisy = [
        replace(one, tau=one.tau + 0.1 * np.random.default_rng(k).normal(size=one.tau.shape))
        for k, one in enumerate(runs)
    ]
    fitted = base(noisy)
    again = repeats(fitted)
    assert again is not None and again.what == "from run to run"
    assert np.all(again.share > share) if not other else np.all(again.share < share + 0.05)
    error = model_error(fitted)
    if not other:
        assert error is not None and "comes again" in error.sentence and error.times > 3.0
    else:  # what differs from run to run of one motion is noise to a model of the motion
        assert error is not None and "no function of the motion" in error.sentence


@pytest.mark.parametrize("everywhere", [False, True])
def test_what_only_the_motion_held_out_meets_wants_that_motion_fitted(good, everywhere):
    met = [with_torque(one, one.tau + 2.0 * np.sin(40.0 * one.q)) for one in good]
    error = model_error(base(met[:2] if everywhere else good[:2], met[2:]))
    assert error is not None and ("no fitted recording shows" in error.sentence) is not everywhere
    assert error.advice.startswith("fit a recording of the motion that is held out") is not everywhere


@pytest.mark.slow
@pytest.mark.parametrize(("folder", "thigh"), [("two_link_rig", 0.30), ("two_link_rig_c0", 0.20)])
def test_real_rigs_raise_no_doubt_and_their_error_is_no_noise(shared_data, folder, thigh):
    runs = [read_recording(path) for path in sorted((shared_data / folder).glob("*.csv"))]
    model = Model.standard(thigh_length=thigh)
    for aside in (slice(0, 2), slice(2, 4)):
        verify = runs[aside]
        prepared = prepare(model, [one for one in runs if one not in verify], verify, cutoff=5.0)
        fitted = fitted_model(identify(model, prepared.train, optimisers=()), prepared)
        assert doubts_before(fitted) is None and doubts_after(fitted, fitted) is None
        error = model_error(fitted)
        assert error is not None and error.times > 5.0


def test_a_leg_that_is_moved_by_hand_while_its_drives_carry_it_shows_nothing_but_its_weight(good):
    rng = np.random.default_rng(5)

    def carried(one: Recording) -> Recording:
        zero = np.zeros(one.q.shape)
        weight = MODEL.torque(Motion(one.t, one.q, zero, zero), np.array([0.0, 0.0, 0.35, -0.6, 0.0, 0.0, 0.0, 0.0]))
        return with_torque(one, weight + 0.002 * rng.standard_normal(weight.shape))

    hand = base([carried(one) for one in good])
    found = doubts_before(hand)
    assert found is not None and "follows from the angles alone" in found.sentence
    assert doubts_before(hand, replace(RULES, negligible=1e-9)) is None


def test_slow_motion_without_friction_is_not_taken_for_motion_by_hand(good):
    slow = [replace(one, t=4.0 * one.t) for one in good]

    def driven(one: Recording) -> Recording:
        dq, ddq = (np.gradient(one.q, one.t, axis=0), np.gradient(np.gradient(one.q, one.t, axis=0), one.t, axis=0))
        numbers = np.array([0.05, 0.02, 0.35, -0.6, 0.0, 0.0, 0.0, 0.0])
        return with_torque(one, MODEL.torque(Motion(one.t, one.q, dq, ddq), numbers))

    assert doubts_before(base([driven(one) for one in slow])) is None


@pytest.mark.parametrize(("joint", "kind"), [("axis", "revolute"), ("stage", "prismatic")])
def test_a_torque_counted_the_other_way_is_said_on_any_machine(joint, kind):
    machine = Model("bench", gravity=9.81 if kind == "revolute" else 0.0, joints=(Joint(joint, kind),))
    runs = [run_bench(machine, seed=6, index=k, bench=Bench(duration=12.0)).recording for k in range(2)]
    for sign in (1.0, -1.0):
        prepared = prepare(machine, [replace(one, tau=sign * one.tau) for one in runs], cutoff=6.0)
        found = doubts_before(fitted_model(identify(machine, prepared.train, optimisers=()), prepared))
        if sign > 0.0:
            assert found is None
        else:
            assert found is not None and f"drive the {joint}" in found.sentence
            assert ("tau1=-Nm" if kind == "revolute" else "tau1=-N ") in found.remedy
