"""Two clocks, and angles or torques that were filtered before: said, and nothing is named on top of it."""

import re
from dataclasses import replace

import numpy as np
import pytest

from exoid.diagnosis import discover
from exoid.diagnosis.evidence.fitted import fitted_model
from exoid.diagnosis.evidence.model_error import model_error
from exoid.measurement.bench.sensors import Sensors
from exoid.measurement.bench.simulation import Bench, simulate_runs
from exoid.measurement.signals.conditioning import low_pass
from exoid.optimisation.fitting.identify import identify
from exoid.optimisation.preparation.prepare import prepare
from exoid.optimisation.preparation.smoothed import ANGLES, FILTERED, TORQUES
from exoid.symbolic import Model
from tests.made_recordings import recording


def runs(change=None, **more):
    """Four recordings of a leg with friction; `change` makes others of them."""
    made = [recording(k, noise=0.05, **more) for k in range(4)]
    return made if change is None else [change(one) for one in made]


def fast(share):
    """What the torques are if their clock runs faster by this share."""

    def change(one):
        at = one.t[0] + (one.t - one.t[0]) * (1.0 + share)
        return replace(one, tau=np.column_stack([np.interp(at, one.t, column) for column in one.tau.T]))

    return change


def checks(given, name):
    made = prepare(Model(), given[:3], given[3:])
    return [finding for finding in made.findings if finding.check == name]


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.002, -0.003])
def test_two_clocks_are_said_and_nothing_is_named(share):
    given = runs(fast(share))
    answer = discover(Model(), given[:3], given[3:])
    assert answer.verdict == "adequate" and not answer.accepted
    assert ("faster" if share > 0 else "slower") in answer.sentence
    (told,) = (one for one in answer.of_recordings if one.what == "clock_rate")
    assert {name: one.value for name, one in told.values.items()} == pytest.approx(
        {one.name: share for one in given}, rel=0.02
    )


@pytest.mark.slow
def test_a_single_recording_tells_its_clock():
    answer = discover(Model(), [fast(0.004)(recording(0, noise=0.05))])
    (told,) = answer.of_recordings
    assert told.what == "clock_rate" and [one.value for one in told.values.values()] == pytest.approx([0.004], rel=0.05)


@pytest.mark.slow
def test_torques_of_single_recordings_that_come_late_are_told():
    def late(one):
        return replace(one, tau=np.column_stack([np.interp(one.t - 0.04, one.t, column) for column in one.tau.T]))

    given = runs()
    given[1] = late(given[1])
    answer = discover(Model(), given[:3], given[3:])
    (told,) = answer.of_recordings
    assert answer.verdict == "adequate" and told.what == "clock_offset" and not answer.accepted
    assert {name: one.value for name, one in told.values.items()} == pytest.approx({given[1].name: 0.04}, abs=0.0005)
    (found,) = told.values.values()
    assert found.low < 0.04 < found.high


@pytest.mark.slow
@pytest.mark.parametrize(("joint", "seconds"), [(0, 0.04), (1, 0.15)])
def test_the_torque_of_one_joint_that_comes_late_in_one_recording_is_told_of_that(joint, seconds):
    given = runs()
    tau = given[1].tau.copy()
    tau[:, joint] = np.interp(given[1].t - seconds, given[1].t, tau[:, joint])
    given[1] = replace(given[1], tau=tau)
    answer = discover(Model(), given[:3], given[3:])
    (told,) = answer.of_recordings
    assert answer.verdict == "adequate" and not answer.accepted
    assert told.what == "clock_offset" and told.joint == ("hip", "knee")[joint]
    assert f"The torque of the {told.joint} comes at another time than in the other recordings" in answer.sentence
    ((name, found),) = told.values.items()
    assert name == given[1].name and found.low < seconds < found.high and found.high - found.low < 0.02


@pytest.mark.slow
@pytest.mark.parametrize("change", [None, fast(1e-5)])
def test_one_clock_is_not_told(change):
    given = runs(change)
    assert not discover(Model(), given[:3], given[3:]).of_recordings


@pytest.mark.slow
@pytest.mark.parametrize("part", [0.3, 0.5, 0.8])
def test_a_load_taken_up_midway_is_no_clock(part):
    def change(one):
        late = one.t > one.t[0] + part * (one.t[-1] - one.t[0])
        return replace(one, tau=one.tau + (6.0 * late * np.sin(one.q.sum(axis=1)))[:, None])

    given = runs(change)
    assert not [one for one in discover(Model(), given[:3], given[3:]).of_recordings if "clock" in one.what]


@pytest.mark.slow
@pytest.mark.parametrize("late", [0.02, -0.03])
def test_torques_that_come_late_from_a_moment_on_are_no_other_rate(late):
    given = runs()
    one = given[1]
    middle = 0.5 * (one.t[0] + one.t[-1])
    at = one.t - late * (one.t > middle)
    given[1] = replace(one, tau=np.column_stack([np.interp(at, one.t, column) for column in one.tau.T]))
    answer = discover(Model(), given[:3], given[3:])
    (told,) = answer.of_recordings
    assert answer.verdict == "adequate" and told.what == "clock_offset"
    assert told.values[one.name].value == pytest.approx(late, abs=0.003)
    assert told.spans[one.name][0] == pytest.approx(middle, abs=0.3)


def filtered(hertz):
    """What a file holds whose angles were filtered at so many Hz."""
    return lambda one: replace(one, q=np.round(low_pass(one.q, hertz, one.rate), 8))


@pytest.mark.slow
def test_filtered_angles_are_said_and_nothing_is_named():
    given = runs(filtered(0.5))
    (said,) = checks(given, FILTERED)
    assert "filtered before" in said.what and not checks(runs(), FILTERED)
    answer = discover(Model(), given[:3], given[3:])
    assert answer.verdict == "check_channels" and not answer.accepted and "filtered before" in answer.sentence


@pytest.mark.slow
def test_where_the_model_explains_filtered_angles_it_is_said_with_that_reserve():
    given = runs(filtered(1.5))
    answer = discover(Model(), given[:3], given[3:])
    assert answer.verdict == "adequate" and "With one reserve: the angles" in answer.sentence


@pytest.mark.slow
def test_what_a_simulation_computed_exactly_is_no_veto():
    def drag(seed):
        return -6.0 * np.column_stack([np.zeros(1200), np.tanh(40.0 * np.gradient(recording(seed).q[:, 1], 0.01) ** 3)])

    given = [recording(k, noise=0.0, angle_noise=0.0) for k in range(4)]
    answer = discover(Model(), given[:3], given[3:])
    assert answer.verdict == "adequate" and ANGLES in {finding.check for finding in answer.audit}
    given = [recording(k, noise=0.0, angle_noise=0.0, extra=drag(k)) for k in range(4)]
    assert discover(Model(), given[:3], given[3:]).verdict != "check_channels"


@pytest.mark.slow
def test_noise_of_filtered_torques_is_no_measure():
    def change(one):
        return replace(one, tau=low_pass(one.tau, 4.0, one.rate) + 3.0 * np.sin(7.0 * one.t[:, None]))

    given = runs(change)
    assert checks(given, TORQUES) and not checks(runs(), TORQUES)
    answer = discover(Model(), given[:3], given[3:])
    assert "times the noise" not in answer.sentence + answer.rule and "filtered before" in answer.sentence
    prepared = prepare(Model(), given[:3], given[3:])
    left = model_error(fitted_model(identify(Model(), prepared.train, optimisers=()), prepared))
    assert left is not None and "It is not noise" not in left.sentence
    assert re.fullmatch(r"[\d.]+ N·m \(these torques were filtered before .*\)", left.beside)


@pytest.mark.slow
def test_torques_that_were_smoothed_are_not_only_somebody_who_pushes():
    """The top of their spectrum, which says how much noise there is, is nearly empty."""
    def change(one):
        smooth = [np.convolve(np.pad(x, 2, mode="edge"), np.ones(5) / 5.0, "valid") for x in one.tau.T]
        return replace(one, tau=np.column_stack(smooth))

    calm = Bench(duration=25.0, sensors=Sensors(outlier_share=0.0, burst_rate=0.0))
    given = [change(one.recording) for one in simulate_runs(4, seed=45, bench=calm)]
    answer = discover(Model(), given[:3], given[3:])
    assert answer.verdict == "unexplained" and not answer.accepted
    assert "smoothed before they were stored" in answer.sentence and "log the torques" in answer.next_experiment


@pytest.mark.parametrize(("noise", "said"), [(1e-7, True), (2e-6, False)])
def test_less_noise_than_that_of_a_good_encoder_is_said(noise, said):
    given = [recording(k, noise=0.05, angle_noise=noise) for k in range(2)]
    found = {one.check for one in prepare(Model(), given).findings}
    assert bool(found & {ANGLES, FILTERED}) is said


@pytest.mark.parametrize(("noise", "of_torques", "of_angles"), [(1e-6, True, ANGLES), (3e-3, False, ANGLES),
                                                               (0.3, False, FILTERED)])  # fmt: skip
def test_torques_without_noise_are_said_and_angles_beside_noisy_torques_were_filtered(noise, of_torques, of_angles):
    given = [recording(k, noise=noise, angle_noise=1e-8) for k in range(2)]
    found = {one.check for one in prepare(Model(), given).findings}
    assert (TORQUES in found) is of_torques and of_angles in found
