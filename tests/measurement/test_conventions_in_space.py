"""Signs, zeros, gears and order of a log of an arm in space: recognised by physics, and put right by an option."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from exoid.diagnosis import discover
from exoid.ground.errors import RecordingError
from exoid.measurement.auditing.convention import check_conventions
from exoid.measurement.reading.conventions import combined_map, conventions, read_as
from exoid.measurement.recording import Recording
from exoid.symbolic.joints import Joint, Origin
from exoid.symbolic.mechanics.spatial import about_joint, joint_torques
from exoid.symbolic.model import Model

DOWN, ASIDE = (0.0, 0.0, -9.81), (6.0, 0.0, -7.76)
Z, UP = (0.0, 0.0, 1.0), 0.5 * np.pi
ARM = (
    Joint("pan", axis=Z, origin=Origin((0.0, 0.0, 0.2))),
    Joint("lift", axis=Z, origin=Origin((0.0, 0.1, 0.0), (UP, 0.0, 0.0))),
    Joint("elbow", axis=Z, origin=Origin((0.4, 0.0, 0.0))),
    Joint("roll", axis=Z, origin=Origin((0.0, -0.05, 0.0), (UP, 0.0, 0.0))),
    Joint("bend", axis=(0.6, 0.0, 0.8), origin=Origin((0.0, 0.05, 0.3), (-UP, 0.2, 0.0))),
)
RAIL = (Joint("rail", "prismatic", axis=(1.0, 0.0, 0.0)), *(replace(joint, parent=None) for joint in ARM[:3]))


@cache
def moved(joints, pull=DOWN, seed=1, count=1500):
    """A recording of an arm of uneven links, with dry friction that may stick, and noise."""
    rng = np.random.default_rng(seed)
    t, reach = np.arange(count) * 0.01, np.array([[joint.reach] for joint in joints])
    q, dq, ddq = np.zeros((3, len(joints), count))
    for w, size in zip((0.9, 2.1, 3.7), (0.5, 0.35, 0.2), strict=True):
        size, phase = reach * size * rng.uniform(0.7, 1.3, reach.shape), rng.uniform(0, 6, reach.shape)
        q += size * np.sin(w * t + phase)
        dq += size * w * np.cos(w * t + phase)
        ddq -= size * w * w * np.sin(w * t + phase)
    links = [
        about_joint(6.0 * 0.7**k, rng.uniform(-0.15, 0.2, 3), 0.05 * 0.6**k * np.diag([1.0, 1.3, 0.8]))
        for k in range(len(joints))
    ]
    tau = np.array(joint_torques(joints, pull, q, dq, ddq, np, links))
    tau += np.abs(tau).mean(axis=1, keepdims=True) * (0.3 * np.tanh(dq / (0.01 * reach)) + 0.1 * dq / reach)
    tau += 0.01 * tau.std(axis=1, keepdims=True) * rng.standard_normal(tau.shape)
    return Recording("run", t, q.T, tau.T, joints=joints)


def kept(recording, names):
    """`recording` as a lab would write it that keeps the conventions `names`."""
    to = combined_map(conventions(names, recording.joints), recording.joints)
    q, tau = to.undone(recording.q, recording.tau)
    return replace(recording, q=q, tau=tau)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("joints", "names"),
    [
        (ARM, "elbow-torque-negated"),
        (ARM, "lift-angle-negated"),
        (ARM, "elbow-negated"),
        (ARM, "lift-zero=-90"),
        (ARM, "elbow-zero=180"),
        (ARM, "swapped-joints-lift-elbow"),
        (ARM, "swapped-torques-lift-elbow"),
        (ARM, "load-torque"),
        (ARM, "degrees"),
        (ARM, "lift-negated,elbow-zero=90"),
        (RAIL, "elbow-angle-negated"),
    ],
)
def test_a_convention_of_an_arm_is_named_and_the_option_puts_it_right(joints, names):
    run = moved(joints)
    (finding,) = check_conventions([kept(run, names)], DOWN)
    assert finding.remedy == f"if so, give --convention {names}"
    right = read_as(kept(run, names), names)
    turns = (right.q - run.q) / (2.0 * np.pi)
    np.testing.assert_allclose(turns, np.round(turns), atol=1e-9)
    np.testing.assert_allclose(right.tau, run.tau, atol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("names", ["elbow-motor-torque=8", "lift-motor-torque=50", "lift-motor=50"])
def test_a_torque_of_the_motor_is_seen_by_what_its_links_share_with_the_others(names):
    (finding,) = check_conventions([kept(moved(ARM), names)], DOWN)
    assert finding.remedy == f"if so, give --convention {names}"


@pytest.mark.parametrize("joints", [ARM, RAIL])
@pytest.mark.parametrize("pull", [DOWN, ASIDE, (0.0, 0.0, 0.0)])
def test_an_arm_read_rightly_is_not_doubted(joints, pull):
    assert not check_conventions([moved(joints, pull)], pull)


@pytest.mark.slow
def test_of_several_recordings_the_odd_one_is_named():
    runs = [replace(moved(ARM), name=f"run_{k}") for k in range(3)]
    (finding,) = check_conventions([*runs[:2], kept(runs[2], "elbow-negated")], DOWN)
    assert finding.remedy == "if so, give --convention run_2=elbow-negated"


def test_a_zero_may_lie_at_any_angle_and_a_rails_at_any_place():
    run = moved(RAIL)
    right = read_as(run, "elbow-negated,elbow-zero=-37.5,rail-zero=0.25")
    assert right.conventions == ("elbow-negated", "elbow-zero=-37.5", "rail-zero=0.25")
    assert conventions("lift-zero=12.3456789", ARM)[0].name == "lift-zero=12.3456789"
    np.testing.assert_allclose(right.q[:, 3], -run.q[:, 3] - np.radians(37.5), atol=1e-12)
    np.testing.assert_allclose(right.q[:, 0], run.q[:, 0] + 0.25, atol=1e-12)
    (rail,) = conventions("rail-zero=0.25", RAIL)
    assert rail.what == "the rail position is zero where the model's is 0.25 m"
    with pytest.raises(RecordingError, match="no convention called 'nose-zero=90'"):
        conventions("nose-zero=90", ARM)


@pytest.mark.slow
def test_a_diagnosis_stops_at_the_channels_and_says_the_option():
    found = discover(Model("arm", joints=ARM), [kept(moved(ARM), "lift-zero=90")])
    assert found.verdict == "check_channels" and "--convention lift-zero=90" in str(found.to_json())
