"""Recordings in other conventions than exoid's are recognised by physics, and read rightly once somebody says so."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement.auditing import convention, power_left
from exoid.measurement.auditing.convention import better_reading, check_conventions
from exoid.measurement.auditing.hypotheses import hypothesis, readings, stages
from exoid.measurement.auditing.rough import Smooth
from exoid.measurement.reading.conventions import combined_map, conventions, read_as
from exoid.measurement.recording import Recording
from tests.newton_euler import Leg, torque

LEG = Leg(m=(7.0, 4.5), inertia=(0.14, 0.07), along=(0.18, 0.2))


@cache
def moved(seed, count=1200):
    """Time, motion and torque of a leg without friction."""
    rng = np.random.default_rng(seed)
    t = np.arange(count) * 0.01
    q, dq, ddq = np.zeros((3, count, 2))
    for joint, (middle, size) in enumerate(((0.4, 0.9), (-0.9, 0.8))):
        q[:, joint] += middle
        for w, a, phase in zip((1.3, 3.1, 4.7), rng.uniform(0.3, 0.5, 3), rng.uniform(0, 6, 3), strict=True):
            q[:, joint] += size * a * np.sin(w * t + phase)
            dq[:, joint] += size * a * w * np.cos(w * t + phase)
            ddq[:, joint] -= size * a * w * w * np.sin(w * t + phase)
    return t, q, dq, np.array([torque(LEG, *state) for state in zip(q, dq, ddq, strict=True)])


def motion(seed=0, noise=0.05, friction=True):
    """A recording of a leg by the Newton-Euler recursion, with friction and noise."""
    t, q, dq, tau = moved(seed)
    rng = np.random.default_rng(seed)
    if friction:
        tau = tau + np.array([2.0, 1.0]) * np.tanh(dq / 0.02) + np.array([1.0, 0.5]) * dq
    return Recording(f"run{seed}", t, q, tau + noise * rng.standard_normal(tau.shape))


def better(recordings):
    """The reading that fits recordings far better than they stand."""
    return better_reading(power_left.motions_of(recordings))


def kept(recording, names):
    """`recording` as a lab would write it that keeps the conventions `names`."""
    to = combined_map(conventions(names))
    q = (recording.q - to.zero) @ np.linalg.inv(to.angle).T
    return replace(recording, q=q, tau=recording.tau @ np.linalg.inv(to.torque).T)


SEEN = (
    "flexion-positive",
    "absolute-shank",
    "absolute-shank,base-driven-shank",
    "hip-from-upright",
    "hip-from-horizontal",
    "hip-from-horizontal-backwards",
    "included-knee-angle",
    "load-torque",
    "knee-torque-negated",
    "hip-torque-negated",
    "hip-angle-negated",
    "knee-angle-negated",
    "swapped-joints",
    "swapped-angles",
    "swapped-torques",
    "degrees",
    "flexion-positive,hip-from-upright",
    "hip-from-horizontal,absolute-shank",
    "degrees,flexion-positive",
    "hip-motor=50",
)


@pytest.mark.slow
@pytest.mark.parametrize("names", SEEN)
def test_a_convention_is_recognised_and_the_option_named_puts_it_right(names):
    run = motion()
    (finding,) = check_conventions([kept(run, names)])
    assert finding.severity == "warning" and finding.remedy == f"if so, give --convention {names}"
    option = finding.remedy.rsplit(" ", 1)[1]
    right = read_as(kept(run, names), option)
    np.testing.assert_allclose(right.q, run.q, atol=1e-9)
    np.testing.assert_allclose(right.tau, run.tau, atol=1e-9)
    assert not check_conventions([right])


@pytest.mark.slow
def test_the_option_names_files_where_others_are_right_as_they_stand():
    runs = [replace(motion(seed), name=f"run_{seed}") for seed in range(3)]
    wrong = [kept(run, "flexion-positive") for run in runs]
    remedies = [f"if so, give --convention run_{k}=flexion-positive" for k in range(3)]
    (last,) = check_conventions([*runs[:2], wrong[2]])
    assert last.remedy == remedies[2] and not last.option
    assert [found.remedy for found in check_conventions([*wrong[:2], runs[2]])] == remedies[:2]
    (every,) = check_conventions(wrong)
    assert every.remedy == "if so, give --convention flexion-positive"


@pytest.mark.slow
def test_a_recording_that_would_not_move_in_the_other_reading_is_right_as_it_stands():
    (found,) = check_conventions([kept(motion(0), "degrees"), motion(1)])
    assert found.remedy == "if so, give --convention run0=degrees"


@pytest.mark.slow
@pytest.mark.parametrize(
    "names",
    [
        "flexion-positive,hip-from-horizontal,absolute-shank",
        "swapped-joints,knee-torque-negated,hip-from-upright",
        "swapped-angles,hip-torque-negated,hip-from-horizontal",
        "degrees,flexion-positive,absolute-shank",
    ],
)
def test_three_conventions_together_are_not_taken_for_two_that_fit_somewhat(names):
    (finding,) = check_conventions([kept(motion(noise=0.3), names)])
    assert finding.remedy == f"if so, give --convention {names}"


def test_honest_recordings_give_no_finding():
    for seed in range(4):
        assert not check_conventions([motion(seed)])
    assert not check_conventions([motion(0), motion(1)])
    assert not check_conventions([motion(0, noise=2.0)])
    assert not check_conventions([motion(0, friction=False)])


@pytest.mark.slow
@pytest.mark.parametrize("names", ["flexion-positive", "hip-from-upright", "swapped-joints,hip-from-upright"])
def test_conventions_are_recognised_beside_the_rotor_of_a_drive_and_model_error(names):
    """As on rigs with light links and geared motors: the rotor is as large as the shank, friction is not smooth."""
    run = disturbed(motion(), 0.3)
    rotor = 0.25 * np.column_stack([np.zeros(len(run.t)), np.gradient(np.gradient(run.q[:, 1], run.t), run.t)])
    (finding,) = check_conventions([kept(replace(run, tau=run.tau + rotor), names)])
    assert finding.remedy == f"if so, give --convention {names}" and finding.confidence == "possible"


def test_a_strong_stop_is_no_convention():
    run = motion()
    for joint in (0, 1):
        stop = np.zeros(run.tau.shape)
        stop[:, joint] = 60.0 * np.maximum(run.q[:, joint] - np.quantile(run.q[:, joint], 0.85), 0.0)
        assert not check_conventions([replace(run, tau=run.tau + stop)])


def test_the_leg_mirrored_is_the_same_leg():
    run = motion()
    assert not check_conventions([replace(run, q=-run.q, tau=-run.tau)])
    keys = [tuple(np.concatenate([r.map.angle.ravel(), r.map.torque.ravel(), r.map.zero])) for r in readings()]
    assert len(set(keys)) == len(keys)


@pytest.mark.slow
def test_noise_for_torque_is_no_convention():
    run = motion()
    noise = np.random.default_rng(1).standard_normal(run.tau.shape)
    assert better([replace(run, tau=noise)]) is None


def test_one_file_of_another_convention_is_named():
    runs = [motion(0), motion(1), kept(motion(2), "flexion-positive")]
    (finding,) = check_conventions(runs)
    assert finding.where == "run2" and finding.remedy == "if so, give --convention run2=flexion-positive"


@pytest.mark.slow
def test_a_convention_given_wrongly_is_told():
    (finding,) = check_conventions([read_as(motion(), "flexion-positive")])
    assert finding.remedy == "if so, leave --convention away"
    (finding,) = check_conventions([read_as(kept(motion(), "absolute-shank"), "flexion-positive")])
    assert finding.remedy == "if so, give --convention absolute-shank"


@pytest.mark.parametrize("name", ["flexion-positive", "hip-extension-positive", "knee-motor=6"])
def test_angle_and_torque_of_a_pair_keep_power(name):
    run = motion()
    rate = np.gradient(run.q, 0.01, axis=0)
    other = kept(replace(run, dq=rate), name)
    turned = read_as(replace(other, dq=rate @ np.linalg.inv(combined_map(conventions(name)).angle).T), name)
    np.testing.assert_allclose(np.sum(turned.dq * turned.tau, axis=1), np.sum(rate * run.tau, axis=1))


def test_absolute_angles_with_their_own_torques_keep_power():
    to = combined_map(conventions("absolute-shank,base-driven-shank"))
    np.testing.assert_allclose(to.torque.T @ to.angle, np.eye(2))


def test_names_are_checked():
    with pytest.raises(RecordingError, match="no convention called 'flexion-postive'") as error:
        read_as(motion(), "flexion-postive")
    assert "flexion-positive" in error.value.remedy
    with pytest.raises(RecordingError, match="given twice"):
        conventions("degrees,degrees")
    with pytest.raises(RecordingError, match="no convention"):
        conventions("hip-motor=0")
    assert [c.name for c in conventions(["absolute-shank", "swapped-joints,degrees"])] == [
        "swapped-joints",
        "degrees",
        "absolute-shank",
    ]


def swung(seed, count=1200):
    """A recording of a leg without friction whose knee drive swings it: nothing drives the hip (an acrobot)."""
    rng = np.random.default_rng(seed)
    phase, step, inner = rng.uniform(0, 6, 2), 0.01, 2
    state, rows = np.zeros((2, 2)), []
    for k in range(count):
        t = k * step
        tau = np.array([0.0, 12.0 * np.sin(3.1 * t + phase[0]) + 6.0 * np.sin(5.3 * t + phase[1])])
        rows.append((t, *state[0], *tau))
        for _ in range(inner):
            rest = torque(LEG, *state, np.zeros(2))
            mass = np.column_stack([torque(LEG, *state, unit) - rest for unit in np.eye(2)])
            state[1] += step / inner * np.linalg.solve(mass, tau - rest - 0.8 * state[1])
            state[0] += step / inner * state[1]
    t, q, tau = np.split(np.array(rows), [1, 3], axis=1)
    return Recording(f"swung{seed}", t.ravel(), q, tau)


@pytest.mark.parametrize("really", [False, True])
def test_what_one_file_says_alone_must_not_make_the_fit_of_all_worse(really, monkeypatch):
    """A file in which little moves fits a leg with hip and knee exchanged too."""
    runs = [motion(0), motion(1), motion(2)]
    if really:
        runs[2] = kept(runs[2], "swapped-joints")
    found = better([kept(motion(2), "swapped-joints")])
    (alone,) = power_left.motions_of([runs[2]])
    monkeypatch.setattr(
        convention, "better_reading", lambda some: found if np.array_equal(some[0].q, alone.q) else None
    )
    monkeypatch.setattr(convention, "LEAST", 0.0)
    assert len(check_conventions(runs)) == really


@pytest.mark.slow
def test_a_leg_without_a_drive_at_the_hip_is_not_read_as_swapped():
    runs = [swung(seed, 700) for seed in range(2)]
    assert not check_conventions(runs)
    assert not any(check_conventions([run]) for run in runs)


def test_the_torque_of_a_joint_that_a_lock_holds_speaks_for_no_convention():
    runs = []
    for seed, held in enumerate((0, 1, 0)):
        t, q, dq, _ = moved(seed)
        q, dq = q.copy(), dq.copy()
        q[:, held], dq[:, held] = 0.0, 0.0
        ddq = np.gradient(dq, t, axis=0)
        tau = np.array([torque(LEG, *state) for state in zip(q, dq, ddq, strict=True)])
        tau[:, held] = 0.0
        runs.append(Recording(f"locked{seed}", t, q, tau + 0.02 * np.random.default_rng(seed).normal(size=tau.shape)))
    assert not check_conventions(runs)


def disturbed(run, size):
    """`run` with waves that no leg explains, `size` times as large as its torques vary."""
    t = run.t[:, None]
    waves = np.sin(t * [7.0, 9.0]) + np.sin(t * [5.3, 4.1] + [1.0, 2.0])
    return replace(run, tau=run.tau + size * run.tau.std(axis=0) * waves)


@pytest.mark.slow
@pytest.mark.parametrize(("size", "named"), [(0.5, True), (0.55, False)])
def test_a_reading_that_fits_badly_itself_is_not_named(size, named):
    assert (better([kept(disturbed(motion(), size), "load-torque")]) is not None) is named


@pytest.mark.slow
@pytest.mark.parametrize(("size", "named"), [(0.3, True), (0.35, False)])
def test_a_reading_is_named_where_it_leaves_four_times_less(size, named):
    assert (better([kept(disturbed(motion(), size), "flexion-positive")]) is not None) is named


@pytest.mark.slow
@pytest.mark.parametrize(("size", "named"), [(0.02, True), (0.05, False)])
def test_recordings_of_which_little_is_left_are_doubted_only_where_another_reading_is_far_better(size, named):
    assert (better([kept(disturbed(motion(), size), "absolute-shank")]) is not None) is named


@pytest.mark.parametrize(("mass", "named"), [(0.3, False), (2.0, True)])
def test_recordings_of_which_nearly_nothing_is_left_are_not_doubted(mass, named):
    t, q, dq, _ = moved(0)
    light = Leg(m=(7.0, mass), inertia=(0.14, 0.016 * mass), along=(0.18, 0.2))
    ddq = np.gradient(dq, t, axis=0)
    run = Recording("run", t, q, np.array([torque(light, *state) for state in zip(q, dq, ddq, strict=True)]))
    assert (better([kept(run, "absolute-shank")]) is not None) is named


@pytest.mark.slow
@pytest.mark.parametrize(("ratio", "named"), [(5.0, False), (8.0, True)])
def test_a_gear_is_looked_for_where_an_angle_turns_far(ratio, named):
    t, q, dq, _ = moved(0)
    q, dq = np.array([0.4, -0.9]) + 0.2 * (q - [0.4, -0.9]), 0.2 * dq
    ddq = np.gradient(dq, t, axis=0)
    run = Recording("run", t, q, np.array([torque(LEG, *state) for state in zip(q, dq, ddq, strict=True)]))
    found = better([kept(run, f"hip-motor={ratio:g}")])
    assert (found is not None and [c.name for c in found.reading.names] == [f"hip-motor={ratio:g}"]) is named


def shares(*powers):
    """What a reading leaves that explains nothing of torques of these powers (K,)."""
    count = len(powers)
    sums = power_left.Sums(
        np.ones((count, count, count, 1, 1)) * np.eye(count)[None, :, :, None, None],
        np.zeros((count, count, 1)), np.array(powers), np.ones((count, count), dtype=bool),
    )  # fmt: skip
    return float(power_left.shares_left([sums], np.eye(count)[None])[0])


@pytest.mark.parametrize(("size", "counts"), [(0.12, 1.0), (0.08, 0.64), (0.025, 0.0625), (0.015, 0.000225)])
def test_the_noise_of_a_light_joint_chooses_no_reading(size, counts):
    """The torque of the other joint varies by 1 N·m and counts once."""
    assert shares(1.0, size**2) - 1.0 == pytest.approx(counts, rel=1e-3)


@pytest.mark.parametrize(("deviation", "moves"), [(0.007, False), (0.014, True)])
def test_the_torque_of_a_joint_that_stands_speaks_for_no_reading(deviation, moves):
    """No leg explains this knee torque, which counts where the knee moves."""
    t = np.arange(400.0)
    q = np.column_stack([np.sin(t), deviation * np.sqrt(2.0) * np.sin(t)])
    tau = np.column_stack([np.sin(t), np.sin(7.3 * t)])
    found = Smooth(q, q, q, tau, 0.01, slice(None), np.ones(400, dtype=bool))
    assert bool(power_left.power_left([found], [hypothesis(())])[0] > 0.5) is moves


@pytest.mark.parametrize(("plain", "named"), [(0.013, 1), (0.017, 2)])
def test_the_reading_with_the_fewest_names_is_named_of_those_that_fit_about_as_well(plain, named, monkeypatch):
    """The better of two readings needs two names and leaves a hundredth; the other needs one."""
    _readings(monkeypatch, {("flexion-positive", "absolute-shank"): 0.01, ("load-torque",): plain})
    assert len(better([motion()]).reading.names) == named


@pytest.mark.parametrize(("hip", "named"), [(0.08, "load-torque"), (0.12, "swapped-joints")])
def test_a_torque_next_to_nothing_speaks_for_no_swap(hip, named, monkeypatch):
    _readings(monkeypatch, {("swapped-joints", "base-driven-shank"): 0.01, ("load-torque",): 0.02}, hip)
    assert better([motion()]).reading.names[0].name == named


def _readings(monkeypatch, left, hip=1.0):
    """Let a motion whose hip torque varies by `hip` times the knee's leave so much so read, and 0.5 as it stands."""
    kinds = [hypothesis(list(names)) for names in left]
    q = np.column_stack([np.sin(np.arange(400.0)), np.sin(np.arange(400.0))])
    one = Smooth(q, q, q, q * [hip, 1.0], 0.01, slice(None), np.ones(400, dtype=bool))
    monkeypatch.setattr(power_left, "motions_of", lambda recordings: [one])
    monkeypatch.setattr(convention, "_stands", lambda motions: 0.5)
    monkeypatch.setattr(convention, "stages", lambda now, turning, joints, still, several: [lambda best: kinds])
    found = {kind.names: value for kind, value in zip(kinds, left.values(), strict=True)}
    monkeypatch.setattr(convention, "power_left", lambda some, kinds: np.array([found[k.names] for k in kinds]))


@pytest.mark.parametrize(("now", "tried"), [(0.35, False), (0.45, True)])
def test_readings_of_many_names_are_tried_where_the_recordings_are_very_wrong(now, tried):
    found = (one for stage in stages(now, []) for one in stage([]))
    assert any(len(one.names) > 2 and "degrees" not in str(one.names) for one in found) is tried
