"""What belongs to a recording (a zero, a load, a gain, its friction) is named as that, and no effect instead."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exoid.diagnosis import discover
from exoid.diagnosis.evidence.candidates import candidate_columns
from exoid.diagnosis.evidence.fitted import beside_offsets, fitted_model
from exoid.diagnosis.evidence.library import build_library
from exoid.diagnosis.hypotheses.recordings import Seen, claims_of
from exoid.diagnosis.own_numbers.fits import Fits, seen_before_filter
from exoid.diagnosis.own_numbers.found import belonging_to
from exoid.diagnosis.own_numbers.numbers import with_numbers
from exoid.diagnosis.own_numbers.state import Claimed
from exoid.diagnosis.report.sections.verdict import numbers
from exoid.diagnosis.rules import RULES
from exoid.measurement.bench.leg import standard_leg
from exoid.measurement.bench.machine import standard_machine
from exoid.measurement.bench.simulation import simulate_runs
from exoid.measurement.logged import Logged
from exoid.measurement.recording import Recording
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.effect_catalogue import find_effect
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model, model_of
from exoid.symbolic.motion import Motion
from exoid.symbolic.robot_file import parse_robot
from exoid.symbolic.spatial_machine import spatial_machine
from tests.symbolic.arms import arm_text

AXIS = Model("drive", joints=(Joint("axis"),))
NUMBERS = np.array([0.3, 3.0, 1.2, 0.5])


def drive(k, numbers=NUMBERS, zero=0.0, gain=1.0, model=AXIS):
    """Return 15 s of one joint that swings by two sines, each recording by others."""
    t = np.arange(0.0, 15.0, 0.01)
    parts = swing(k, t)
    tau = gain * model.torque(Motion(t, *parts), np.asarray(numbers), None) + zero
    rng = np.random.default_rng(k)
    seen = tau + 0.05 * rng.standard_normal(tau.shape)
    return Recording(f"run_{k}", t, parts[0] + 1e-5 * rng.standard_normal(tau.shape), seen, joints=AXIS.joints)


def swing(k, t):
    """Return angle, velocity and acceleration (3, N, 1) of two sines."""
    parts = np.zeros((3, len(t), 1))
    for size, pace, phase in ((0.8, 2.0 + 0.2 * k, 0.0), (0.4, 5.1 - 0.3 * k, float(k))):
        sine, cosine = np.sin(pace * t + phase), np.cos(pace * t + phase)
        parts[:, :, 0] += size * np.array([sine, pace * cosine, -(pace**2) * sine])
    return parts


def late(one, seconds):
    """Return a recording whose torques come so many seconds late."""
    return replace(one, tau=np.interp(one.t - seconds, one.t, one.tau[:, 0])[:, None])


def told(found):
    """Return {what: {recording: value}}, after every interval was found to be one."""
    for one in found.of_recordings:
        assert all(e.low < e.value < e.high for e in one.values.values())
    return {one.what: {name: e.value for name, e in one.values.items()} for one in found.of_recordings}


@pytest.mark.slow
def test_where_nothing_differs_nothing_is_said():
    found = discover(AXIS, [drive(k) for k in range(3)], drive(3))
    assert found.verdict == "adequate" and found.of_recordings == () and len(found.steps) == 1
    assert found.to_json()["of_recordings"] == []


@pytest.mark.slow
def test_a_zero_that_differs_in_one_recording_is_told_of_that_and_the_others_together():
    found = discover(AXIS, [drive(0), drive(1, zero=0.8), drive(2)], drive(3))
    assert found.verdict == "adequate" and told(found)["sensor_zero"]["run_1"] == pytest.approx(0.8, abs=0.05)
    assert "another zero than in the other recordings: run_1 0.79" in found.sentence
    assert ", the others " in found.sentence and "run_2" not in found.sentence
    assert len(found.of_recordings[0].values) == 4


@pytest.mark.slow
def test_what_is_drawn_after_is_what_the_answer_says():
    runs = [drive(k, zero=zero) for k, zero in enumerate((0.9, -0.6, 0.2, -1.1))]
    found = discover(AXIS, runs[:3], runs[3])
    (picture,) = [picture for picture in found.material().pictures if picture.section == "verdict"]
    before, after, *_ = picture.figure.axes[1].lines
    errors = [float(np.sqrt(np.nanmean(np.square(line.get_ydata())))) for line in (before, after)]
    told = [float(found.steps[k].verify_rms[0]) for k in (0, -1)]
    assert told[1] < 0.1 * told[0]
    np.testing.assert_allclose(errors, told, rtol=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("held", [0, 3])
def test_zeros_set_anew_are_told_and_the_rest_is_adequate(held):
    zeros = (0.9, -0.6, 0.2, -1.1)
    runs = [drive(k, zero=zero) for k, zero in enumerate(zeros)]
    found = discover(AXIS, [*runs[:held], *runs[held + 1 :]], runs[held])
    assert found.verdict == "adequate" and not found.left_out
    assert told(found)["sensor_zero"] == pytest.approx({f"run_{k}": z for k, z in enumerate(zeros)}, abs=0.05)
    assert [step.label for step in found.steps] == ["base", "+ sensor_zero"]
    assert found.steps[1].verify_rms < 0.2 * found.steps[0].verify_rms
    (one,) = found.to_json()["of_recordings"]
    assert one["sentence"] in found.sentence and one["joint"] == "axis" and one["unit"] == "N·m"


@pytest.mark.slow
def test_long_recordings_are_searched_in_stretches_and_answered_whole():
    rules = replace(RULES, whole_seconds=20.0, searched_seconds=30.0, stretch_seconds=5.0)
    runs = [drive(k, model=AXIS) for k in range(4)]
    rates = [np.gradient(run.q, run.t, axis=0) for run in runs]
    runs = [replace(run, tau=run.tau + 0.4 * np.abs(rate) * rate) for run, rate in zip(runs, rates, strict=True)]
    found = discover(AXIS, runs[:3], runs[3], rules=rules)
    assert [effect.effect for effect in found.accepted] == ["viscous_quadratic"]
    assert len(found.fit.recordings) == 3


def slowly(speed):
    return 0.25 / (1.0 + speed / 0.12)


def rubbing(k, speed, more=slowly):
    """Return a recording back and forth at one speed, of friction that is larger at creeping speed."""
    t = np.arange(0.0, 24.0, 0.01)
    dq = speed * np.clip(8.0 * np.sin(2.0 * np.pi * t / 12.0), -1.0, 1.0)
    ddq = np.gradient(dq, t)
    tau = (0.5 + more(np.abs(dq))) * np.sign(dq) + 0.1 * dq + 0.05 * ddq
    rng = np.random.default_rng(k)
    q = 0.01 * np.cumsum(dq)[:, None] + 1e-5 * rng.standard_normal((len(t), 1))
    return Recording(f"v_{speed}", t, q, tau[:, None] + 0.01 * rng.standard_normal((len(t), 1)), joints=AXIS.joints)


SPEEDS = (0.05, 0.1, 0.2, 0.4, 0.8, 1.6)


@pytest.mark.slow
@pytest.mark.parametrize("held", [0, 1, 3, 5])
def test_friction_at_creeping_speed_is_named_whichever_speed_is_held_out(held):
    runs = [rubbing(k, speed, lambda v: 0.25 * np.exp(-v / 0.12)) for k, speed in enumerate(SPEEDS)]
    found = discover(replace(AXIS, gravity=0.0), [*runs[:held], *runs[held + 1 :]], runs[held])
    assert [one.name for one in found.accepted] == ["stribeck:axis"]


@pytest.mark.slow
@pytest.mark.parametrize("held", [0, 4])
def test_friction_that_depends_on_speed_belongs_to_no_recording_though_each_has_a_speed_of_its_own(held):
    runs = [rubbing(k, speed) for k, speed in enumerate(SPEEDS)]
    found = discover(replace(AXIS, gravity=0.0), [*runs[:held], *runs[held + 1 :]], runs[held])
    assert found.of_recordings == ()


@pytest.mark.slow
def test_an_effect_is_found_beside_them():
    model = AXIS.with_effect("viscous_quadratic:axis")
    runs = [drive(k, [*NUMBERS, 0.4], z, model=model) for k, z in enumerate((0.9, -0.6, 0.2, -1.1))]
    found = discover(AXIS, runs[:3], runs[3])
    assert [one.name for one in found.accepted] == ["viscous_quadratic:axis"] and set(told(found)) == {"sensor_zero"}
    assert found.accepted[0].parameters["c"].value == pytest.approx(0.4, abs=0.05)


@pytest.mark.slow
def test_zeros_are_told_beside_an_effect_that_has_a_constant_of_its_own():
    model, zeros = AXIS.with_effect("joint_spring:axis"), (0.9, -0.6, 0.2, -1.1)
    runs = [drive(k, [*NUMBERS, 3.0, -0.5], z, model=model) for k, z in enumerate(zeros)]
    found = discover(AXIS, runs[:3], runs[3])
    assert [one.effect for one in found.accepted] == ["joint_spring"]
    own = told(found)["sensor_zero"]
    assert [own[f"run_{k}"] - own["run_0"] for k in (1, 2, 3)] == pytest.approx([-1.5, -0.7, -2.0], abs=0.05)
    # Of the spring's constant and the zeros only the sum is known.
    (spring,), (zero,) = found.accepted, found.of_recordings
    assert spring.parameters["c"].is_unknown and all(value.is_unknown for value in zero.values.values())
    assert "torque at angle zero not known by itself" in spring.sentence and "only how they differ" in zero.sentence
    assert "torque at angle zero" not in spring.stability
    (shown,) = [entry for entry in numbers(found.to_json()["accepted"][0]["parameters"], find_effect("joint_spring"))
                if entry["name"] == "c"]  # fmt: skip
    assert shown["words"] == "torque at angle zero not known by itself"
    assert found.to_json()["of_recordings"][0]["values"]["run_0"]["low"] is None


def stopped(one, stiffness, at):
    """Return a recording of a joint that meets a stop."""
    return replace(one, tau=one.tau + stiffness * np.maximum(0.0, one.q - at))


@pytest.mark.slow
def test_zeros_that_hide_a_stop_are_found_with_it_at_one_place():
    """Places that differ would stand in for the zeros, and these for the stop."""
    zeros = (0.9, -0.6, 0.2, -1.1)
    runs = [stopped(drive(k, zero=zero), 8.0, 0.3) for k, zero in enumerate(zeros)]
    found = discover(AXIS, runs[:3], runs[3])
    assert [effect.name for effect in found.accepted] == ["end_stop:axis"] and not found.more_missing
    assert found.accepted[0].parameters["theta_s"].value == pytest.approx(0.3, abs=0.002)
    assert told(found)["sensor_zero"] == pytest.approx({f"run_{k}": z for k, z in enumerate(zeros)}, abs=0.01)


def test_of_zeros_found_beside_another_model_only_how_they_differ_is_taken_as_known():
    runs = [drive(k) for k in range(3)]
    first = prepare(AXIS, runs[:2], runs[2:])
    away = first.with_recordings([one.beside_own(np.full(one.wide_tau.shape, 0.3)) for one in first.all])
    here, there = (fitted_model(identify(AXIS, some.train, optimisers=()), some) for some in (first, away))
    assert there.evaluation_rms > 1.5 * here.evaluation_rms and beside_offsets(there) is there
    anew = beside_offsets(replace(there, prepared=replace(away, zeroed=(0,))))
    np.testing.assert_allclose(anew.evaluation_rms, here.evaluation_rms, rtol=0.01)
    np.testing.assert_allclose(anew.linear, here.linear, atol=0.02)


@pytest.mark.slow
def test_no_second_effect_makes_up_for_an_offset_of_zeros_that_were_found_without_the_first():
    zeros, runs = (0.6, -1.0, -0.3, -0.6), [drive(k) for k in range(4)]
    runs = [replace(one, tau=one.tau + zeros[k] + 6.0 * swing(k, one.t)[0] ** 3) for k, one in enumerate(runs)]
    found = discover(AXIS, runs[1:], runs[0])
    assert [one.name for one in found.accepted] == ["hardening_spring:axis"] and not found.more_missing


@pytest.mark.slow
@pytest.mark.parametrize("effect", ["torque_offset", "joint_spring"])
def test_a_zero_that_jumps_is_told_beside_an_effect_with_a_constant(effect):
    """Blocks of a part are as long as each other: short ones made any loss look as if it scattered."""
    numbers = {"torque_offset": [0.8], "joint_spring": [3.0, -0.5]}[effect]
    model = AXIS.with_effect(f"{effect}:axis")
    runs = [drive(k, [*NUMBERS, *numbers], model=model) for k in range(4)]
    runs[1] = replace(runs[1], tau=runs[1].tau + 0.8 * (runs[1].t >= 8.3)[:, None])
    found = discover(AXIS, runs[:3], runs[3])
    assert [one.effect for one in found.accepted] == [effect]
    (zero,) = found.of_recordings
    assert zero.values["run_1"].value == pytest.approx(0.8, abs=0.01)
    assert zero.spans["run_1"] == (pytest.approx(8.3, abs=0.05), None)


def test_blocks_of_a_part_are_as_long_as_each_other():
    (one,) = prepare(AXIS, [drive(0)]).train
    starts = one.starts_within(2.0, 100, 770)
    assert starts[0] == 0 and np.ptp(np.diff([*starts, 670])) <= 1
    assert np.array_equal(one.starts(2.0), one.starts_within(2.0, 0, len(one.kept)))


@pytest.mark.slow
def test_a_late_torque_is_told_beside_an_effect_and_not_as_another_friction():
    model = AXIS.with_effect("viscous_quadratic:axis")
    runs = [drive(k, [*NUMBERS, 0.4], model=model) for k in range(5)]
    behind = np.interp(runs[1].t - 0.02, runs[1].t, runs[1].tau[:, 0])[:, None]
    found = discover(AXIS, [runs[0], replace(runs[1], tau=behind), *runs[2:4]], runs[4])
    assert [one.name for one in found.accepted] == ["viscous_quadratic:axis"]
    assert told(found) == {"clock_offset": pytest.approx({"run_1": 0.02}, abs=0.003)}


@pytest.mark.slow
def test_the_same_zero_in_all_recordings_is_an_effect_of_the_machine():
    found = discover(AXIS, [drive(k, zero=0.8) for k in range(3)], drive(3, zero=0.8))
    assert found.of_recordings == () and found.verdict != "adequate"


@pytest.mark.slow
@pytest.mark.parametrize("heavy", [(3,), (0, 3), (0, 1, 2)])
def test_a_load_is_weighed_and_placed_whoever_carries_it(heavy):
    runs = [drive(k, NUMBERS + (k in heavy) * added(1.5, 0.3)) for k in range(4)]
    found = discover(AXIS, runs[:3], runs[3])
    assert found.verdict == "adequate"
    assert told(found)["carried_load"] == pytest.approx({f"run_{k}": 1.5 for k in heavy}, abs=0.1)
    (one,) = found.of_recordings
    assert one.place.value == pytest.approx(0.3, abs=0.02) and "axis" in one.sentence


@pytest.mark.slow
def test_friction_that_grows_with_the_load_feels_what_is_carried():
    """The load's own part of it was another level of friction, and 7.3 times the noise was left."""
    model = AXIS.with_effect("load_friction", "axis")
    runs = [drive(k, np.append(NUMBERS + (k in (1, 3)) * added(1.5, 0.3), 0.15), model=model) for k in range(4)]
    found = discover(model, runs[:3], runs[3])
    assert found.verdict == "adequate"
    assert told(found) == {"carried_load": pytest.approx({"run_1": 1.5, "run_3": 1.5}, abs=0.02)}


def test_an_effect_that_is_suspected_feels_what_is_carried_as_one_that_the_model_has():
    runs = [drive(k) for k in range(2)]
    fitted = fitted_model(identify(AXIS, prepare(AXIS, runs).train, optimisers=()), prepare(AXIS, runs))
    one = fitted.prepared.all[0].carrying(3.0 * np.sin(fitted.prepared.all[0].motion.t)[:, None])
    (suspect,) = [item for item in build_library(AXIS, [one]).candidates if item.name == "load_friction:axis"]
    columns = candidate_columns(suspect, np.zeros((1, 0)), one, fitted).values[0, 0, :, 0]
    with_it = AXIS.with_effect("load_friction", "axis")
    known = with_it.columns(one.motion, None, np.append(fitted.linear, 0.0))[:, :, -1:]
    np.testing.assert_allclose(columns, one.smooth_columns(known)[0, :, 0], atol=1e-9)


@pytest.mark.slow
def test_a_level_of_dry_and_viscous_friction_need_not_be_that_of_an_effect():
    """Where an effect's friction stayed, two levels were told, one of each part."""
    model = AXIS.with_effect("viscous_quadratic", "axis")
    stiff = NUMBERS * [1.0, 1.0, 1.6, 1.6]
    runs = [drive(k, np.append(stiff if k == 1 else NUMBERS, 0.4), model=model) for k in range(4)]
    found = discover(AXIS, runs[:3], runs[3])
    assert [item.name for item in found.accepted] == ["viscous_quadratic:axis"]
    assert told(found) == {"friction_level": pytest.approx({"run_1": 1.6}, abs=0.05)} and len(found.of_recordings) == 1
    assert "The dry and viscous friction of the axis is another" in found.sentence


@pytest.mark.slow
@pytest.mark.parametrize("heavy", [{1: 0.8, 3: 1.6}, {0: 0.8, 1: 1.6, 3: 0.8}])
def test_loads_of_two_sizes_are_weighed_each(heavy):
    """One number for all was 1.74 kg, with a gain and zeros for what was left."""
    runs = [drive(k, NUMBERS + added(heavy.get(k, 0.0), 0.3)) for k in range(5)]
    found = discover(AXIS, runs[:4], runs[4])
    assert found.verdict == "adequate"
    assert told(found) == {"carried_load": pytest.approx({f"run_{k}": mass for k, mass in heavy.items()}, abs=0.1)}


def added(mass, place):
    out = np.zeros(4)
    out[:2] = AXIS.mixture[:, 0] @ (mass * np.array([place**2, place, 1.0]))
    return out


@pytest.mark.slow
def test_another_gain_and_another_level_of_friction():
    usual = [drive(k) for k in range(3)]
    gained = discover(AXIS, [*usual, drive(4)], drive(3, gain=1.2))
    assert gained.verdict == "adequate" and told(gained) == {"torque_gain": pytest.approx({"run_3": 1.2}, abs=0.02)}
    stiff = discover(AXIS, [*usual, drive(4, NUMBERS * [1.0, 1.0, 1.5, 1.5])], drive(3))
    assert stiff.verdict == "adequate" and told(stiff) == {"friction_level": pytest.approx({"run_4": 1.5}, abs=0.04)}


@pytest.mark.slow
@pytest.mark.parametrize("gain", [0.1, 0.5, 10.0])
def test_a_range_that_was_switched_is_a_gain_beside_an_effect_too(gain):
    """Nothing that takes more numbers is told, though it leaves as little."""
    model = AXIS.with_effect("viscous_quadratic:axis")
    runs = [drive(k, [*NUMBERS, 0.4], gain=gain if k == 1 else 1.0, model=model) for k in range(5)]
    found = discover(AXIS, runs[:4], runs[4])
    assert [one.name for one in found.accepted] == ["viscous_quadratic:axis"]
    assert told(found) == {"torque_gain": pytest.approx({"run_1": gain}, rel=0.05)}


def test_the_numbers_of_the_machine_come_to_rest_beside_a_large_gain():
    runs = [drive(k, gain=10.0 if k == 1 else 1.0) for k in range(4)]
    prepared = prepare(AXIS, runs[:3], runs[3:])
    own = belonging_to(fitted_model(identify(AXIS, prepared.train, optimisers=()), prepared))
    ((gain,),) = (statement.values.values() for statement in own.told)
    assert gain.value == pytest.approx(10.0, abs=0.02)
    assert own.linear == pytest.approx(NUMBERS, rel=0.005)


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [0.3, -0.7])
def test_torques_of_a_logger_started_by_hand_are_told_to_the_millisecond(seconds):
    model = AXIS.with_effect("viscous_quadratic:axis")
    runs = [drive(k, [*NUMBERS, 0.4], model=model) for k in range(5)]
    found = discover(AXIS, [runs[0], late(runs[1], seconds), *runs[2:4]], runs[4])
    assert [one.name for one in found.accepted] == ["viscous_quadratic:axis"] and not found.left_out
    assert told(found) == {"clock_offset": pytest.approx({"run_1": seconds}, abs=0.003)}


def test_of_torques_before_and_after_the_motion_nothing_is_known():
    (one,) = prepare(AXIS, [drive(0)]).train
    early, moved = one.motion.t < one.motion.t[0] + 1.0, one.at_times(one.motion.t - 1.0)
    assert moved.hidden[early].all() and not moved.hidden[~early].all()


def with_offset(runs):
    """Return a model with an offset fitted to recordings."""
    prepared = prepare(AXIS, runs)
    return fitted_model(identify(AXIS.with_effect("torque_offset:axis"), prepared.train, optimisers=()), prepared)


@pytest.mark.slow
def test_what_is_found_beside_two_fits_of_the_same_effects_agrees():
    runs = [drive(k, gain=1.3 if k == 2 else 1.0, zero=0.4) for k in range(3)]
    own = belonging_to(with_offset(runs))
    assert [held.claim.what for held in own.ways] == ["torque_gain"]
    assert own.agrees(replace(own, now=with_offset(runs)))


def test_a_weighing_depends_on_nothing_that_was_asked_before():
    now = with_offset([drive(k, gain=1.3 if k == 2 else 1.0) for k in range(3)])
    grams = []
    for asked in (("torque_gain",), ("clock_offset", "torque_gain"), ("torque_gain", "friction_level", "torque_gain")):
        fits = Fits(now, RULES, {})
        for what in asked:
            claim = next(claim for claim in fits.claims if claim.what == what and not claim.everyone)
            fits.weigh((Claimed(claim, claim.nodes[0], ((2,),)),))
        grams.append(fits.grams)
    np.testing.assert_array_equal(grams[0], grams[1])
    np.testing.assert_array_equal(grams[0], grams[2])


def test_nothing_is_told_of_a_recording_that_is_left_out():
    prepared = prepare(AXIS, [drive(k, zero=zero) for k, zero in enumerate((0.9, -0.6, 0.2))])
    own = belonging_to(fitted_model(identify(AXIS, prepared.train, optimisers=()), prepared))
    (every,), (some,) = own.told, own.without(["run_1"])
    assert "run_1" in every.sentence and "run_1" not in some.sentence and set(some.values) == {"run_0", "run_2"}
    assert own.without(["run_0", "run_1", "run_2"]) == ()


@pytest.mark.slow
@pytest.mark.parametrize(("which", "word"), [(2, "dry friction"), (3, "viscous friction")])
def test_a_part_of_friction_that_differs_alone_is_called_so(which, word):
    dragging = drive(4, NUMBERS + 0.8 * np.eye(4)[which])
    found = discover(AXIS, [*(drive(k) for k in range(3)), dragging], drive(3))
    size = 1.0 + 0.8 / NUMBERS[which]
    assert found.verdict == "adequate" and told(found) == {"friction_level": pytest.approx({"run_4": size}, abs=0.05)}
    assert f"{word} of the axis is another" in found.sentence


@pytest.mark.slow
def test_a_late_torque_of_one_fitted_recording_is_told_though_the_one_held_out_is_explained():
    runs = [drive(k) for k in range(5)]
    behind = np.interp(runs[1].t - 0.03, runs[1].t, runs[1].tau[:, 0])[:, None]
    found = discover(AXIS, [runs[0], replace(runs[1], tau=behind), *runs[2:4]], runs[4])
    assert found.verdict == "adequate"
    assert told(found) == {"clock_offset": pytest.approx({"run_1": 0.03}, abs=0.003)}


def warm(k, start, goes):
    """Return a recording, and one whose torque goes with the temperature of its motor, which warms up from `start`."""
    cold, free = drive(k), drive(k, NUMBERS * [1.0, 1.0, 0.0, 0.0])
    degrees = start + 6.0 * (1.0 - np.exp(-cold.t / 10.0))
    logged = {"motor": Logged(cold.t[::100], degrees[::100], "°C", 0.01)}
    tau = goes(cold.tau, cold.tau - free.tau, (degrees - 30.0)[:, None])
    return replace(cold, tau=tau, logged=logged)


STARTS = (21.0, 35.0, 28.0, 40.0)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("goes", "unit", "number"),
    [
        (lambda tau, friction, above: tau - 0.012 * above * friction, "1/°C", -0.0121),  # of what it is at 33.5 °C
        (lambda tau, friction, above: tau * (1.0 + 0.005 * above), "1/°C", 0.0049),
        (lambda tau, friction, above: tau + 0.05 * above, "N·m/°C", 0.05),
    ],
    ids=["friction", "gain", "zero"],
)
def test_what_goes_with_the_temperature_of_a_motor_is_said_of_it(goes, unit, number):
    runs = [warm(k, start, goes) for k, start in enumerate(STARTS)]
    found = discover(AXIS, runs[:3], runs[3])
    one = next(one for one in found.of_recordings if one.what == "logged:motor")
    assert found.verdict == "adequate" and one.unit == unit and one.joint == "axis"
    (value,) = {e.value for e in one.values.values()}
    assert value == pytest.approx(number, rel=0.06) and set(one.values) == {run.name for run in runs}
    assert "goes with motor" in one.sentence


@pytest.mark.slow
def test_a_temperature_that_nothing_goes_with_is_not_told_of():
    runs = [warm(k, start, lambda tau, friction, above: tau) for k, start in enumerate(STARTS)]
    found = discover(AXIS, runs[:3], runs[3])
    assert found.verdict == "adequate" and found.of_recordings == ()


@pytest.mark.slow
def test_friction_of_one_recording_is_not_laid_upon_its_temperature():
    usual = [warm(k, start, lambda tau, friction, above: tau) for k, start in enumerate(STARTS)]
    stiff = warm(4, 30.0, lambda tau, friction, above: tau + 0.5 * friction)
    assert set(told(discover(AXIS, [*usual[:3], stiff], usual[3]))) == {"friction_level"}


@pytest.mark.slow
@pytest.mark.parametrize(("gained", "gain"), [((0, 1, 2), 0.85), ((0, 2), 1.25), ((1, 2, 3), 1.25)])
def test_a_gain_that_most_recordings_have_is_told_of_them_though_it_spoils_the_numbers_of_the_machine(gained, gain):
    """Both joints' torques share numbers: which of the recordings have it is known."""
    runs = [run.recording for run in simulate_runs(5, None, standard_leg(), seed=5)]
    for k in gained:
        runs[k] = replace(runs[k], tau=runs[k].tau * [gain, 1.0])
    found = discover(Model.standard(), runs[:4], runs[4])
    own = {runs[k].name: gain for k in gained}
    assert found.verdict == "adequate" and told(found) == {"torque_gain": pytest.approx(own, abs=0.02)}


@pytest.mark.slow
@pytest.mark.parametrize("level", [0.6, 1.8])
def test_intervals_of_a_level_of_friction_hold_it(level):
    """What is known of the others' friction belongs to the interval of a ratio to it."""
    inside = 0
    levels = [NUMBERS * ([1.0, 1.0, level, level] if k == 2 else 1.0) for k in range(3)]
    for seed in range(20):
        rng = np.random.default_rng(seed)
        clean = [drive(k, numbers) for k, numbers in enumerate(levels)]
        runs = [replace(run, tau=run.tau + 0.2 * rng.standard_normal(run.tau.shape)) for run in clean]
        prepared = prepare(AXIS, runs[:2], runs[2:])
        (one,) = belonging_to(fitted_model(identify(AXIS, prepared.train, optimisers=()), prepared)).told
        (value,) = one.values.values()
        inside += value.low <= (level if len(one.values) == 1 else 1.0 / level) <= value.high
    assert inside >= 17


def test_a_single_recording_has_no_others_and_of_many_one_does_not_matter():
    def asked(runs, **rules):
        prepared = prepare(AXIS, runs)
        now = fitted_model(identify(AXIS, prepared.train, optimisers=()), prepared)
        return belonging_to(now, replace(RULES, **rules))

    runs = [drive(k, zero=z) for k, z in enumerate((0.9, -0.6, 0.2))]
    assert asked(runs[:1]) is None and asked(runs, own_recordings=2) is None
    assert [one.what for one in asked(runs).told] == ["sensor_zero"]


def test_which_of_the_halves_is_held_out_has_no_say_in_its_own_numbers():
    runs = [drive(k, zero=z) for k, z in enumerate((0.9, -0.6, 0.2))]
    prepared = prepare(AXIS, runs[:2], runs[2:])
    now = fitted_model(identify(AXIS, prepared.train, optimisers=()), prepared)
    first = belonging_to(now)
    late = runs[2].tau.copy()
    late[: len(late) // 2] += 0.3  # the first half alone: what judges it must not know
    spoilt = fitted_model(now.fit, prepare(AXIS, runs[:2], [replace(runs[2], tau=late)]))
    fits = Fits(spoilt, RULES, {})
    zeros = tuple(Claimed(claim, 0.0, fits.everyone) for claim in fits.claims if claim.everyone)
    second = with_numbers(fits, zeros)
    assert second.judged[2, 0] == pytest.approx(first.judged[2, 0], abs=0.02)
    assert second.judged[2, 1, 2] > first.judged[2, 1, 2] + 0.2


def loaded_from(k, moment):
    """Return a recording in which 1.5 kg are taken up at a moment, s."""
    bare, heavy = (drive(k, NUMBERS + more) for more in (0.0, added(1.5, 0.3)))
    return replace(bare, tau=np.where((bare.t >= moment)[:, None], heavy.tau, bare.tau))


@pytest.mark.slow
@pytest.mark.parametrize("moments", [(7.0, 7.0, 7.0, 7.0), (5.0, 99.0, 9.0, 99.0), (99.0, 99.0, 99.0, 6.0)])
def test_a_load_taken_up_midway_is_told_with_its_moment(moments):
    runs = [loaded_from(k, moment) for k, moment in enumerate(moments)]
    found = discover(AXIS, runs[:3], runs[3])
    own = {f"run_{k}": moment for k, moment in enumerate(moments) if moment < 15.0}
    assert found.verdict == "adequate" and told(found) == {
        "carried_load": pytest.approx(dict.fromkeys(own, 1.5), abs=0.1)
    }
    (one,) = found.of_recordings
    assert {name: start for name, (start, _) in one.spans.items()} == pytest.approx(own, abs=0.03)
    assert f"From {min(own.values()):.1f}"[:6] in one.sentence and "spans" in one.to_json()


@pytest.mark.slow
def test_what_changes_within_the_only_recording_is_told():
    found = discover(AXIS, [loaded_from(0, 8.0)])
    assert told(found) == {"carried_load": pytest.approx({"run_0": 1.5}, abs=0.1)}


@pytest.mark.slow
def test_a_zero_that_jumps_midway_is_told():
    runs = [drive(k) for k in range(4)]
    late = runs[2].t > 6.0
    runs[2] = replace(runs[2], tau=runs[2].tau + 0.8 * late[:, None])
    (one,) = discover(AXIS, runs[:3], runs[3]).of_recordings
    assert one.what == "sensor_zero" and one.values["run_2"].value == pytest.approx(0.8, abs=0.05)
    assert one.spans["run_2"] == (pytest.approx(6.0, abs=0.03), None) and "than before" in one.sentence


@pytest.mark.slow
def test_torques_that_come_late_from_a_moment_on_are_told_with_it():
    runs = [drive(k) for k in range(4)]
    before = runs[1].t < 7.0
    runs[1] = replace(runs[1], tau=np.where(before[:, None], runs[1].tau, late(runs[1], 0.03).tau))
    (one,) = discover(AXIS, runs[:3], runs[3]).of_recordings
    assert one.what == "clock_offset" and one.values["run_1"].value == pytest.approx(0.03, abs=0.003)
    assert one.spans["run_1"] == (pytest.approx(7.0, abs=0.5), None)
    assert one.sentence.startswith("From ") and "than before" in one.sentence


def test_a_number_that_may_be_the_usual_one_is_not_told():
    runs = [drive(k) for k in range(5)]
    runs = [replace(one, tau=one.tau * (1.2 if k == 1 else 1.0)) for k, one in enumerate(runs)]
    prepared = prepare(AXIS, runs[:4], runs[4:])
    now = fitted_model(identify(AXIS, prepared.train, optimisers=()), prepared)
    fits = Fits(now, RULES, {})
    gain = next(claim for claim in fits.claims if claim.what == "torque_gain")
    (held,) = with_numbers(fits, (Claimed(gain, gain.nodes[0], ((1,), (2,))),)).clear
    assert held.groups == ((1,),)


@pytest.mark.slow
def test_a_gain_of_the_last_third_of_one_fitted_recording_is_told_though_the_rest_is_explained():
    runs = [drive(k) for k in range(4)]
    late = runs[1].t > 11.0
    runs[1] = replace(runs[1], tau=runs[1].tau * np.where(late, 1.25, 1.0)[:, None])
    found = discover(AXIS, runs[:3], runs[3])
    assert found.verdict == "adequate" and not found.left_out
    assert told(found) == {"torque_gain": pytest.approx({"run_1": 1.25}, abs=0.02)}


@pytest.mark.slow
@pytest.mark.parametrize("ripple", [0.0, 3.0])
def test_where_a_fitted_recording_is_far_from_the_noise_that_is_said(ripple):
    """A push has no number that belongs to a recording, and the recording held out does not show it."""
    runs = [drive(k) for k in range(5)]
    runs = [replace(run, tau=run.tau + ripple * np.sin(12.0 * swing(k, run.t)[0])) for k, run in enumerate(runs)]
    t = runs[1].t
    push = np.where(t > 10.0, 1.5 * np.sin(2.3 * t + 0.04 * t**2) + np.sin(5.6 * t), 0.0)
    runs[1] = replace(runs[1], tau=runs[1].tau + push[:, None])
    found = discover(AXIS, runs[:4], runs[4])
    assert found.verdict == ("missing" if ripple else "unexplained") or found.left_out
    assert "run_1" in found.sentence


@pytest.mark.slow
def test_a_place_is_found_between_the_nodes_it_is_first_looked_for_at():
    runs = [drive(k, NUMBERS + (k == 3) * added(1.5, 0.2871)) for k in range(4)]
    runs = [replace(run, tau=np.round(run.tau, 3)) for run in runs]
    (one,) = discover(AXIS, runs[:3], runs[3]).of_recordings
    assert one.place.low < 0.2871 < one.place.high and one.values["run_3"].low < 1.5 < one.values["run_3"].high


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_zeros_of_a_leg_are_none_that_pushes(seed):
    zeros = np.random.default_rng(seed).uniform(-1.5, 1.5, (4, 2))
    runs = [run.recording for run in simulate_runs(4, None, standard_leg(), seed=seed)]
    runs = [replace(run, tau=run.tau + zero) for run, zero in zip(runs, zeros, strict=True)]
    found = discover(Model.standard(), runs[:3], runs[3])
    assert found.verdict == "adequate" and not found.outside and set(told(found)) == {"sensor_zero"}


@pytest.mark.slow
def test_a_leg_with_a_box_on_its_shank():
    leg = standard_leg()
    bare, heavy = (simulate_runs(4, None, one, seed=3) for one in (leg, leg.with_payload(2.0, 0.3)))
    runs = [(heavy if k in (1, 3) else bare)[k].recording for k in range(4)]
    found = discover(Model.standard(), runs[:3], runs[3])
    assert found.verdict == "adequate" and told(found) == {
        "carried_load": pytest.approx({"run_1": 2.0, "run_3": 2.0}, abs=0.1)
    }


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 2, 3])
def test_zeros_are_no_drift_that_began_at_another_time_in_each(seed):
    rng = np.random.default_rng(seed)
    runs = [drive(k, zero=zero) for k, zero in enumerate([*-0.4 + 0.08 * rng.standard_normal(3), 0.27])]
    runs = [replace(run, tau=run.tau + 0.2 * rng.standard_normal(run.tau.shape)) for run in runs]
    found = discover(AXIS, runs[:3], runs[3])
    assert found.verdict == "adequate" and set(told(found)) == {"sensor_zero"}


CART = Model("cart", joints=(Joint("cart", "prismatic", axis=(1, 0, 0)), Joint("pole", axis=(0, -1, 0))))


def cart(k, bodies):
    """Return 15 s of a cart of 4 kg with a pole, and `bodies` {distance from the pivot: kg} on it, by Lagrange."""
    t, rng = np.arange(0.0, 15.0, 0.01), np.random.default_rng(k)
    parts = np.zeros((3, 2, 1500))
    for joint, sizes in enumerate(((0.2, 0.1), (0.9, 0.4))):
        for size, pace in zip(sizes, (2.0 + 0.2 * k + 0.3 * joint, 5.1 - 0.3 * k), strict=True):
            sine, cosine = np.sin(pace * t + k), np.cos(pace * t + k)
            parts[:, joint] += size * np.array([sine, pace * cosine, -(pace**2) * sine])
    q, dq, ddq = parts
    tau = np.array([4.0 * ddq[0], 0.05 * ddq[1]]) + 0.8 * np.tanh(dq / 0.01)
    for away, kg in {0.3: 2.0, **bodies}.items():
        tau[0] += kg * (ddq[0] + away * (np.cos(q[1]) * ddq[1] - np.sin(q[1]) * dq[1] ** 2))
        tau[1] += kg * away * (away * ddq[1] + np.cos(q[1]) * ddq[0] + 9.80665 * np.sin(q[1]))
    noise = 0.05 * rng.standard_normal(tau.shape)
    return Recording(f"run_{k}", t, q.T + 1e-5 * rng.standard_normal(q.T.shape), (tau + noise).T, joints=CART.joints)


@pytest.mark.slow
@pytest.mark.parametrize(("away", "link"), [(0.2, "pole"), (0.0, "cart")])
def test_a_load_in_space_is_weighed_and_placed_where_its_place_shows(away, link):
    runs = [cart(k, {away: 0.7} if k in (1, 3) else {}) for k in range(4)]
    found = discover(CART, runs[:3], runs[3])
    assert found.verdict == "adequate"
    assert told(found) == {"carried_load": pytest.approx({"run_1": 0.7, "run_3": 0.7}, abs=0.01)}
    (load,) = found.of_recordings
    assert load.joint == link and (load.place is None) == (away == 0.0)
    if load.place is not None:
        assert load.place.low < away < load.place.high
        assert "from its joint (" in load.sentence and "no motion shows its y" in load.sentence
        assert "another machine" not in found.sentence


def test_of_an_arm_the_load_is_asked_at_its_end():
    links = [Joint(f"j{k}", axis=(0, k % 2, 1 - k % 2), origin=(0.1, 0.0, 0.3)) for k in range(4)]
    asked = [claim.place for claim in claims_of(Model("arm", joints=tuple(links))) if claim.what == "carried_load"]
    assert asked == ["j3"]


@pytest.mark.slow
def test_a_load_is_told_beside_a_spring_that_explains_as_much():
    def pulled(k):
        swung = drive(k, NUMBERS + (1.2 * np.array([0.09, 0.3, 0.0, 0.0]) if k in (0, 3) else 0.0))
        return replace(swung, tau=swung.tau + 2.5 * (swung.q - 0.2))

    runs = [pulled(k) for k in range(5)]
    found = discover(AXIS, runs[:4], runs[4])
    assert [one.effect for one in found.accepted] == ["joint_spring"]
    assert told(found)["carried_load"] == pytest.approx({"run_0": 1.2, "run_3": 1.2}, abs=0.05)


@pytest.mark.slow
@pytest.mark.parametrize("inertia", [0.1, 0.3])
def test_of_a_load_that_no_gravity_weighs_its_inertia_is_told(inertia):
    level = Model("drive", joints=AXIS.joints, gravity=0.0)
    runs = [drive(k, [0.3 + inertia * (k in (1, 3)), 1.2, 0.5], model=level) for k in range(4)]
    found = discover(level, runs[:3], runs[3])
    assert found.verdict == "adequate"
    assert told(found) == {"carried_load": pytest.approx({"run_1": inertia, "run_3": inertia}, abs=0.001)}
    (load,) = found.of_recordings
    assert load.unit == "kg·m²" and load.place is None


@pytest.mark.slow
@pytest.mark.parametrize("held", [0, 2])
def test_one_torque_that_comes_late_is_its_clock_and_no_delay(held):
    runs = [late(drive(k), 0.015 if k == 2 else 0.0) for k in range(5)]
    found = discover(AXIS, [*runs[:held], *runs[held + 1 :]], runs[held])
    assert found.verdict == "adequate" and not found.accepted
    assert told(found) == {"clock_offset": pytest.approx({"run_2": 0.015}, abs=0.002)}


@pytest.mark.parametrize(
    ("what", "number", "when", "slope"),
    [
        ("clock_offset", 0.06, lambda t: t - 0.06, lambda t: -np.ones(len(t))),
        ("clock_rate", -0.004, lambda t: 0.996 * t, lambda t: t),
    ],
)
def test_torques_at_other_times_are_those_and_change_so_with_the_number(what, number, when, slope):
    t = np.linspace(0.0, 10.0, 1001)
    claim = next(item for item in claims_of(AXIS) if item.what == what)
    seen = Seen(
        AXIS, np.zeros(4), np.zeros((1, 1001, 4)), np.sin(3.0 * t)[None], t, {}, 0.0, number,
        elsewhere=lambda at: np.sin(3.0 * at)[None],
    )  # fmt: skip
    at = when(t)
    change, rest = claim.pieces(seen)[0].T
    assert number * change + rest == pytest.approx(np.sin(3.0 * at) - np.sin(3.0 * t), abs=1e-6)
    assert change == pytest.approx(3.0 * np.cos(3.0 * at) * slope(t), abs=1e-3 * 30.0)


def timed(k, fast, numbers, stop=0.0):
    """Return 20 s of a joint whose torques are logged by a clock that runs so much faster, with a stop at 0.6 rad."""
    t, rng = np.arange(0.0, 20.0, 0.01), np.random.default_rng([1, k])
    then, seen = swing(k, t * (1.0 + fast)), swing(k, t)[0]
    tau = AXIS.torque(Motion(t, *then), np.array(numbers), None) + stop * np.maximum(then[0] - 0.6, 0.0)
    noise = rng.standard_normal((2, *tau.shape))
    return Recording(f"run_{k}", t, seen + 1e-5 * noise[0], tau + 0.03 * noise[1], joints=AXIS.joints)


@pytest.mark.slow
def test_which_recordings_are_usual_is_asked_again_beside_what_was_found_later():
    """A gain of the four others and a load of 1.75 kg were told: a load looks like a gain at first."""
    runs = [drive(k, NUMBERS + (k in (0, 3)) * added(1.5, 0.3), gain=1.2 if k == 1 else 1.0) for k in range(5)]
    found = discover(AXIS, runs[:4], runs[4])
    assert found.verdict == "adequate"
    values = {item.what: {name: e.value for name, e in item.values.items()} for item in found.of_recordings}
    assert values["torque_gain"] == pytest.approx({"run_1": 1.2}, abs=0.002)
    assert values["carried_load"] == pytest.approx({"run_0": 1.5, "run_3": 1.5}, abs=0.02)


@pytest.mark.slow
def test_one_clock_of_several_that_are_all_fast_runs_faster_still():
    """It was told as a drift of friction; with its clock put right a recording has other strides to be compared in."""
    runs = [timed(k, 0.005 if k == 2 else 0.002, NUMBERS) for k in range(5)]
    found = discover(AXIS, runs[:4], runs[4])
    assert found.verdict == "adequate" and not found.accepted
    values = {name: e.value for item in found.of_recordings for name, e in item.values.items()}
    assert values == pytest.approx({f"run_{k}": 0.005 if k == 2 else 0.002 for k in range(5)}, abs=5e-6)
    assert sum(len(item.values) for item in found.of_recordings) == 5


@pytest.mark.slow
def test_channels_that_a_search_leaves_in_doubt_have_to_beat_what_belongs_to_recordings():
    """A stop is most of the torque, and the numbers are none of a machine as long as the clock is not known."""
    runs = [timed(k, 0.004, [0.05, 0.1, 0.3, 0.1], stop=150.0) for k in range(4)]
    found = discover(AXIS, runs[:3], runs[3])
    assert [effect.name for effect in found.accepted] == ["end_stop:axis"]
    assert told(found)["clock_rate"] == pytest.approx({f"run_{k}": 0.004 for k in range(4)}, abs=1e-5)


@pytest.mark.slow
def test_torques_that_are_all_far_too_late_are_no_clock_of_most_recordings():
    runs = [late(drive(k), 0.15) for k in range(4)]
    found = discover(AXIS, runs[:3], runs[3])
    assert found.verdict == "check_channels" and not found.of_recordings


@pytest.mark.slow
@pytest.mark.parametrize("fast", [-0.004, 0.003])
def test_what_a_clock_leaves_is_noise_although_friction_reverses_in_a_moment(fast):
    runs = [timed(k, fast, NUMBERS) for k in range(4)]
    found = discover(AXIS, runs[:3], runs[3])
    (clock,) = found.of_recordings
    assert clock.what == "clock_rate"
    assert [e.value for e in clock.values.values()] == pytest.approx([fast] * 4, abs=1e-5)
    assert found.verdict == "adequate" and found.steps[-1].verify_rms < 1.2 * found.noise_floor


@pytest.mark.slow
def test_a_delay_that_all_recordings_have_is_the_machines():
    runs = [late(drive(k), 0.02) for k in range(4)]
    found = discover(AXIS, runs[:3], runs[3])
    assert [one.effect for one in found.accepted] == ["time_delay"] and not found.of_recordings


@pytest.mark.slow
@pytest.mark.parametrize("held", [0, 3])
def test_an_encoder_that_was_zeroed_elsewhere_is_told_beside_an_effect_of_its_angle(held):
    runs = [drive(k) for k in range(4)]
    runs = [replace(one, tau=one.tau + 0.6 * np.sin(12.0 * swing(k, one.t)[0])) for k, one in enumerate(runs)]
    runs[0] = replace(runs[0], q=runs[0].q - 0.15)
    found = discover(AXIS, [*runs[:held], *runs[held + 1 :]], runs[held])
    assert [effect.name for effect in found.accepted] == ["torque_ripple:axis"]
    assert told(found) == {"encoder_zero": pytest.approx({"run_0": 0.15}, abs=0.01)}


@pytest.mark.slow
@pytest.mark.parametrize("held", [1, 3])
def test_an_encoder_that_slips_within_a_recording_leaves_no_error_of_the_model(held):
    """The jump that filters pass on is no motion of the machine."""
    runs = [one.recording for one in simulate_runs(4, None, standard_leg(), seed=4)]
    slips = [runs[3].t >= 9.0, np.zeros_like(runs[3].t)]
    runs[3] = replace(runs[3], q=runs[3].q - 0.08 * np.column_stack(slips))
    found = discover(Model.standard(), [*runs[:held], *runs[held + 1 :]], runs[held])
    (own,) = found.of_recordings
    assert found.verdict == "adequate" and own.what == "encoder_zero" and own.joint == "hip"
    assert own.values[runs[3].name].value == pytest.approx(0.08, abs=0.01)
    assert own.spans[runs[3].name][0] == pytest.approx(9.0, abs=0.5)


@pytest.mark.slow
def test_an_encoder_of_a_leg_is_no_zero_of_two_torque_sensors():
    """The shank weighs on both joints."""
    runs = [one.recording for one in simulate_runs(4, None, standard_leg(), seed=3)]
    runs[2] = replace(runs[2], q=runs[2].q - np.array([0.0, 0.1]))
    found = discover(Model.standard(), runs[:3], runs[3])
    assert found.verdict == "adequate"
    assert told(found) == {"encoder_zero": pytest.approx({"run_2": 0.1}, abs=0.01)}


@pytest.mark.slow
def test_an_encoder_of_an_arm_in_space_is_no_load():
    arm = model_of(spatial_machine(parse_robot(arm_text(7, 3, ("revolute",) * 3).encode())).model)
    runs = [one.recording for one in simulate_runs(4, arm, standard_machine(arm), seed=3)]
    runs[2] = replace(runs[2], q=runs[2].q - np.array([0.0, 0.1, 0.0]))
    found = discover(arm, runs[:3], runs[3])
    (own,) = found.of_recordings
    assert (own.what, own.joint, list(own.values)) == ("encoder_zero", arm.joint_names[1], [runs[2].name])
    assert own.values[runs[2].name].value == pytest.approx(0.1, abs=0.01)


def test_a_torque_of_another_angle_changes_so_with_that():
    one = prepare(AXIS, [drive(0)]).train[0]
    now = fitted_model(identify(AXIS, (one,), optimisers=()), prepare(AXIS, [drive(0)]))
    seen = seen_before_filter(now, one, now.linear, now.shape)
    (claim,) = (item for item in claims_of(AXIS) if item.what == "encoder_zero")
    expected = AXIS.gravity * now.linear[1] * np.cos(one.motion.q[:, 0])
    assert claim.pieces(seen)[0, :, 0] == pytest.approx(expected, abs=1e-5)
