"""Conventions of machines that are not the leg: made from their joints, recognised by physics, and read rightly."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from exoid.ground.errors import RecordingError
from exoid.measurement.auditing.convention import check_conventions
from exoid.measurement.reading.conventions import combined_map, conventions, conventions_of_machine, read_as
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import LEG, Joint
from exoid.symbolic.mechanics.newton_euler import BaseMotion, link_torques

DRIVE = (Joint("axis"),)
SLIDE = (Joint("carriage", "prismatic"),)
RAIL = (Joint("rail", "prismatic", 0.2), Joint("boom", length=0.3))
ANKLE = (Joint("hip", length=0.42), Joint("knee", length=0.4), Joint("ankle"))
ARM = (Joint("shoulder", length=0.3), Joint("elbow"))
PAIR = (Joint("left"), Joint("right", parent="base"))
INERTIA = {"J": 0.3, "X": 0.8, "m": 4.0}


@cache
def moved(joints, gravity=9.81, sway=False, spring=0.0, count=1200):
    """A recording of a machine by the Newton-Euler recursion, with friction and noise."""
    rng = np.random.default_rng(len(joints))
    t = np.arange(count) * 0.01
    reach = np.array([[joint.reach] for joint in joints])
    q, dq, ddq = np.zeros((3, len(joints), count))
    for w, size in zip((1.3, 3.1, 4.7), (0.6, 0.4, 0.2), strict=True):
        phase = rng.uniform(0, 6, (len(joints), 1))
        q += reach * size * np.sin(w * t + phase)
        dq += reach * size * w * np.cos(w * t + phase)
        ddq -= reach * size * w * w * np.sin(w * t + phase)
    tilt = 0.3 * np.sin(0.9 * t)
    base = BaseMotion(tilt, 0.27 * np.cos(0.9 * t), -0.81 * tilt) if sway else BaseMotion()
    links = link_torques(joints, gravity, q, dq, ddq, np, base)
    tau = np.zeros_like(q)
    for k, one in enumerate(links):
        tau += sum(INERTIA[kind] * 0.6**k * np.array([x + 0.0 * t for x in torque]) for kind, torque in one.items())
    tau += 0.05 * np.abs(tau).max(axis=1, keepdims=True) * np.tanh(dq / (0.02 * reach)) + spring * q
    tau += 0.01 * tau.std(axis=1, keepdims=True) * rng.standard_normal(tau.shape)
    known = np.column_stack([tilt, np.zeros((count, 2))]) if sway else None
    return Recording("run", t, q.T, tau.T, joints=joints, base=known)


def kept(recording, names):
    """`recording` as a lab would write it that keeps the conventions `names`."""
    to = combined_map(conventions(names, recording.joints), recording.joints)
    q = (recording.q - to.zero) @ np.linalg.inv(to.angle).T
    return replace(recording, q=q, tau=recording.tau @ np.linalg.inv(to.torque).T)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("joints", "names"),
    [
        (DRIVE, "axis-torque-negated"),
        (DRIVE, "axis-from-upright"),
        (DRIVE, "axis-from-horizontal"),
        (DRIVE, "axis-from-horizontal-backwards"),
        (DRIVE, "degrees"),
        (ANKLE, "knee-negated"),
        (ANKLE, "knee-angle-negated"),
        (ANKLE, "ankle-torque-negated"),
        (ANKLE, "load-torque"),
        (ANKLE, "absolute-angles"),
        (ANKLE, "absolute-ankle"),
        (ANKLE, "base-driven-knee"),
        (ANKLE, "hip-from-horizontal"),
        (ANKLE, "included-knee-angle"),
        (ANKLE, "swapped-joints-hip-ankle"),
        (ANKLE, "knee-negated,hip-from-upright"),
        (PAIR, "right-torque-negated"),
        (RAIL, "boom-from-upright"),
    ],
)
def test_a_convention_of_any_machine_is_named_and_the_option_puts_it_right(joints, names):
    run = moved(joints)
    (finding,) = check_conventions([kept(run, names)])
    # Of two legs that hang side by side one mirrored alone moves alike: the first of a fixed order is the option.
    mirrored = "; no motion distinguishes it from right-angle-negated: look at the machine" if joints is PAIR else ""
    assert finding.remedy == f"if so, give --convention {names}{mirrored}"
    right = read_as(kept(run, names), names)
    np.testing.assert_allclose(right.q, run.q, atol=1e-9)
    np.testing.assert_allclose(right.tau, run.tau, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("joints", [LEG, ARM])
@pytest.mark.parametrize("times", ["1:0:1:1", "0:1:1:1"])
def test_torques_that_are_sums_of_two_drives_are_told_and_put_right(joints, times):
    """As of a differential, or where a driver's map is wrong; one drive stands on the base and rubs there."""
    whole = moved(joints)
    shank = np.gradient(whole.q.sum(axis=1), whole.t)
    rubs = 0.3 * whole.tau.std() * np.tanh(shank / 0.05) + 0.1 * whole.tau.std() * shank
    whole = replace(whole, tau=whole.tau + rubs[:, None])
    halves = slice(0, 600), slice(600, None)
    runs = [Recording(f"run {k}", whole.t[k], whole.q[k], whole.tau[k], joints=joints) for k in halves]
    name = f"torque-sums={times}"
    wrong = [kept(run, name) for run in runs]
    (finding,) = check_conventions(wrong)
    assert finding.remedy == f"if so, give --convention {name}" and "tau1" in finding.what
    right = [read_as(run, name) for run in wrong]
    np.testing.assert_allclose(right[0].tau, runs[0].tau, atol=1e-9)
    assert not [item for item in check_conventions(right) if name in item.remedy]
    assert not [item for item in check_conventions(wrong[:1]) if "torque-sums" in item.remedy]


def test_sums_that_no_torques_are_found_from_again_are_refused():
    for wrong in ("torque-sums=1:1:1:1", "torque-sums=1:1:1"):
        with pytest.raises(RecordingError, match=wrong):
            read_as(moved(LEG), wrong)


@pytest.mark.parametrize("joints", [DRIVE, SLIDE, RAIL, ANKLE, PAIR])
def test_a_machine_read_rightly_is_not_doubted(joints):
    assert not check_conventions([moved(joints)])
    run = moved(joints, gravity=0.0)
    assert not check_conventions([run], weighs=False)


def test_a_force_of_the_wrong_sign_is_told_and_a_spring_is_none():
    assert not check_conventions([moved(SLIDE, gravity=0.0, spring=80.0)], weighs=False)
    (finding,) = check_conventions([kept(moved(SLIDE, gravity=0.0), "carriage-torque-negated")], weighs=False)
    assert finding.remedy.endswith("--convention carriage-torque-negated") and "the carriage force" in finding.what


def test_the_angle_of_a_measured_base_is_part_of_the_motion():
    run = moved(PAIR, sway=True)
    assert not check_conventions([run])
    (finding,) = check_conventions([kept(run, "left-negated")])
    assert finding.remedy == "if so, give --convention left-negated"


def test_absolute_angles_are_those_of_all_links():
    run = moved(ANKLE)
    whole = replace(run, q=np.cumsum(run.q, axis=1))
    for names in ("absolute-angles", "absolute-knee,absolute-ankle"):
        np.testing.assert_allclose(read_as(whole, names).q, run.q, atol=1e-12)


def test_a_name_that_a_machine_does_not_have_is_refused_with_those_it_has():
    for joints, name in ((DRIVE, "flexion-positive"), (ANKLE, "toe-negated"), (SLIDE, "carriage-from-upright")):
        with pytest.raises(RecordingError, match=f"{name}.*{joints[0].name}"):
            read_as(moved(joints), name)
    assert "degrees" not in conventions_of_machine(SLIDE)
    assert np.allclose(read_as(moved(ANKLE), "knee-motor=50").q[:, 1], moved(ANKLE).q[:, 1] / 50)


def test_conventions_of_joints_that_nobody_named_are_those_of_the_machine_in_order():
    run = moved(DRIVE)
    unnamed = replace(run, joints=(Joint("joint1"),))
    read = read_as(kept(unnamed, "joint1-torque-negated"), "joint1-torque-negated").of_machine(DRIVE)
    assert read.conventions == ("axis-torque-negated",)
    (finding,) = check_conventions([replace(read, tau=-read.tau)])
    assert finding.remedy == "if so, leave --convention away"
