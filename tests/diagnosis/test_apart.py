"""A bad file among several is named and left out, and the others are answered."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exoid.diagnosis import discover
from exoid.diagnosis.evidence.apart import left_out, odd_ones
from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.diagnosis.rules import RULES
from exoid.measurement.auditing.audit import audit
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.measurement.recording import Recording, Source
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Motion
from tests.made_recordings import recording

AXIS = Model("drive", joints=(Joint("axis"),))
WITH = AXIS.with_effect("viscous_quadratic:axis")
NUMBERS = np.array([0.3, 3.0, 1.2, 0.5])


def drive(k, *, quadratic=0.0, numbers=NUMBERS, noise=0.05):
    """Return 15 s of one joint that swings by two sines, the same machine in every recording."""
    t, parts = np.arange(0.0, 15.0, 0.01), np.zeros((3, 1500, 1))
    for size, pace, phase in ((0.8, 2.0 + 0.2 * k, 0.0), (0.4, 5.1 - 0.3 * k, float(k))):
        sine, cosine = np.sin(pace * t + phase), np.cos(pace * t + phase)
        parts[:, :, 0] += size * np.array([sine, pace * cosine, -(pace**2) * sine])
    tau = WITH.torque(Motion(t, *parts), np.array([*numbers, quadratic]), None)
    rng = np.random.default_rng(k)
    seen = tau + noise * rng.standard_normal(tau.shape)
    return Recording(f"run_{k}", t, parts[0] + 1e-5 * rng.standard_normal(tau.shape), seen, joints=AXIS.joints)


def stuck(one):
    return replace(one, tau=np.where(one.t[:, None] < 5.0, one.tau, one.tau[500]))


def turned(one):
    return replace(one, tau=-one.tau)


def names(runs, held=0, **changes):
    prepared = prepare(AXIS, runs[: len(runs) - held], runs[len(runs) - held :])
    base = fitted_model(identify(AXIS, prepared.train, optimisers=()), prepared)
    return [prepared.all[k].name for k in odd_ones(base, replace(RULES, **changes))]


@pytest.fixture(scope="module")
def runs():
    return [drive(k, quadratic=0.4) for k in range(5)]


@pytest.mark.slow
def test_nothing_is_apart_where_all_lack_the_same(runs):
    assert names(runs) == [] and names(runs, 1) == []


@pytest.mark.slow
@pytest.mark.parametrize("spoil", [stuck, turned])
@pytest.mark.parametrize("place", [1, 4])
def test_a_spoilt_recording_is(runs, spoil, place):
    spoilt = [spoil(one) if k == place else one for k, one in enumerate(runs)]
    assert names(spoilt) == [f"run_{place}"] and names([*spoilt[1:], runs[0]], 2) == [f"run_{place}"]


def test_of_three_recordings_nobody_knows_which(runs):
    assert names([turned(runs[0]), *runs[1:3]]) == []


@pytest.mark.slow
def test_two_of_six_are_found_and_three_are_not(runs):
    six = [*runs, drive(5, quadratic=0.4)]
    assert names([turned(six[0]), stuck(six[1]), *six[2:]]) == ["run_0", "run_1"]
    assert len(names([turned(six[0]), stuck(six[1]), turned(six[2]), *six[3:]])) < 3


def test_a_little_more_is_no_other_machine():
    alike = [drive(k, noise=0.01) for k in range(4)]
    heavier = drive(4, numbers=NUMBERS * [1.05, 1.05, 1.0, 1.0], noise=0.01)
    assert names([*alike, heavier]) == []
    assert names([*alike, heavier], worth_telling=0.0005) == ["run_4"]


def test_a_motion_in_which_an_effect_is_large_is_not_apart():
    varied = [drive(k, quadratic=1.0) for k in range(4)]
    assert names([*varied, drive(7, quadratic=1.0)]) == []
    other = drive(7, quadratic=2.0)
    assert names([*varied, other]) == ["run_7"]
    assert names([*varied, other], near_noise=30.0) == []


def test_numbers_of_its_own_explain_another_machine_and_no_stuck_torque():
    alike = [drive(k) for k in range(4)]
    for odd, known in ((drive(4, numbers=1.5 * NUMBERS), True), (stuck(drive(4)), False)):
        prepared = prepare(AXIS, [*alike, odd])
        base = fitted_model(identify(AXIS, prepared.train, optimisers=()), prepared)
        found = identify(AXIS, prepared.train[:4], optimisers=())
        out, explained = left_out(base, found, [4])
        assert list(out) == [4] and (explained > 0.9) is known


@pytest.mark.slow
def test_the_others_are_answered_and_it_is_named(runs):
    found = discover(AXIS, [runs[0], stuck(runs[1]), *runs[2:4]], runs[4])
    assert found.verdict == "missing" and [one.effect for one in found.accepted] == ["viscous_quadratic"]
    (out,) = found.to_json()["left_out"]
    assert out["recording"] == "run_1" and "fitted alone it is not explained either" in found.sentence


@pytest.mark.slow
@pytest.mark.parametrize("path", ["run_1.csv", "today/run_1.parquet", ""])
def test_of_a_file_that_is_read_wrongly_the_option_is_told(runs, path):
    wrong = replace(turned(runs[1]), source=Source(path=path))
    found = discover(AXIS, [runs[0], wrong, *runs[2:4]], runs[4])
    assert f"--convention {path.rpartition('/')[2] or 'run_1'}=axis-torque-negated" in found.sentence


@pytest.mark.slow
def test_of_a_file_in_another_unit_the_unit_is_told():
    legs = [recording(k) for k in range(5)]
    large = replace(legs[1], tau=1e3 * legs[1].tau)
    found = discover(Model.standard(), [legs[0], large.with_findings(audit(large)), *legs[2:4]], legs[4])
    (out,) = found.left_out
    assert out.recording == large.name and "it looks like mN·m (write the unit into the header" in out.sentence


@pytest.mark.slow
def test_torques_that_are_all_many_times_too_large_are_of_another_machine_or_unit(runs):
    found = discover(AXIS, [runs[0], replace(runs[1], tau=1e3 * runs[1].tau), *runs[2:4]], runs[4])
    assert "another machine, a load (--payload), or a unit or gain of a sensor" in found.sentence


@pytest.mark.slow
def test_another_machine_is_told_by_its_numbers(runs):
    found = discover(AXIS, [*runs[:3], drive(3, quadratic=0.4, numbers=NUMBERS * [1.5, 2.5, 2.0, 3.0])], runs[4])
    assert found.verdict == "missing" and "with numbers of its own" in found.sentence


@pytest.mark.slow
def test_an_effect_that_one_recording_alone_shows_is_no_bad_file():
    stop = AXIS.with_effect("end_stop:axis")
    assert stop.shapes  # its place
    runs = [drive(k) for k in range(4)]
    wide = runs[3]
    beyond = np.maximum(1.6 * wide.q - 1.2, 0.0) - np.maximum(-1.6 * wide.q - 1.2, 0.0)
    far = replace(wide, q=1.6 * wide.q, tau=wide.tau)
    tau = AXIS.torque(_motion(far), NUMBERS, None) + 25.0 * beyond
    runs[3] = replace(far, tau=tau + 0.05 * np.random.default_rng(7).standard_normal(tau.shape))
    found = discover(AXIS, runs)
    assert "run_3 is left out" not in found.sentence


def _motion(one):
    rate = 1.0 / (one.t[1] - one.t[0])
    dq = np.gradient(one.q[:, 0], 1.0 / rate)[:, None]
    return Motion(one.t, one.q, dq, np.gradient(dq[:, 0], 1.0 / rate)[:, None])


@pytest.mark.slow
def test_a_dead_torque_channel_is_no_load_of_the_others():
    """Zero throughout, it was taken for a joint without a drive, and the other three files for loaded with 8.84 kg."""
    runs = [run.recording for run in simulate_runs(4, seed=0, bench=Bench(duration=25.0))]
    runs[1] = replace(runs[1], tau=runs[1].tau * [0.0, 1.0])
    found = discover(Model.standard(), runs[:3], runs[3:])
    assert found.verdict == "adequate" and not found.of_recordings
    assert [entry.recording for entry in found.left_out] == ["run_1"]
    assert "the torque of the hip is zero throughout: a dead channel" in found.sentence
