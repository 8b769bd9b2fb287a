"""Torques of an arm that are those of the motors, before the gears: seen by the masses in its robot file."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from exoid.diagnosis.discovery import discover
from exoid.measurement.auditing.masses import check_masses
from exoid.measurement.reading.read import read_recording
from exoid.symbolic.model import Model, read_model
from tests.measurement.test_conventions_in_space import ARM, DOWN, moved

GEARS = np.array([120.0, 150.0, 100.0, 80.0, 110.0])


def with_bodies(scale: float = 1.0):
    """The arm as a robot file has it whose masses are wrong by `scale`."""
    bodies = ((6.0 * 0.7**k, 0.05, 0.02, 0.03, *(0.05 * 0.6**k * np.array([1.0, 0, 0, 1.3, 0, 0.8]))) for k in range(5))
    return tuple(
        replace(joint, body=(scale * body[0], *body[1:4], *(scale * np.array(body[4:]))))
        for joint, body in zip(ARM, bodies, strict=True)
    )


@pytest.mark.parametrize("scale", [0.2, 1.0, 5.0])
def test_torques_behind_the_gears_are_no_finding(scale):
    recording = moved(ARM)
    assert not check_masses([recording], with_bodies(scale), DOWN)
    assert not check_masses([replace(recording, tau=recording.tau / 10.0)], with_bodies(), DOWN)


def test_torques_before_the_gears_are_seen_and_the_remedy_ends_the_question():
    recording = moved(ARM)
    before = replace(recording, tau=recording.tau / GEARS)
    (found,) = check_masses([before], with_bodies(), DOWN)
    assert "times smaller than the masses" in found.what and "pan" in found.what
    option = found.remedy.split("--convention ")[1].split()[0]
    ratios = dict(part.split("-motor-torque=") for part in option.split(","))
    assert 0.4 * GEARS[2] < float(ratios["elbow"]) < 2.5 * GEARS[2]  # the file's masses are not the arm's
    assert not check_masses([replace(before, conventions=tuple(option.split(",")))], with_bodies(), DOWN)


def test_without_masses_and_with_those_that_stand_for_nothing_known_nothing_is_said():
    recording = moved(ARM)
    before = replace(recording, tau=recording.tau / GEARS)
    assert not check_masses([before], ARM, DOWN)
    placeholders = tuple(replace(joint, body=(1.0, 0, 0, 0, 1.0, 0, 0, 1.0, 0, 1.0)) for joint in ARM)
    assert not check_masses([before], placeholders, DOWN)


def test_masses_of_a_robot_file_stay_in_the_model_file(tmp_path):
    model = Model("arm", joints=with_bodies())
    assert read_model(model.save(tmp_path / "arm.toml")).joints == model.joints
    again = read_model(tmp_path / "arm.toml")
    assert [joint.body for joint in again.joints] == [joint.body for joint in model.joints]


def test_a_real_arm_whose_motors_were_logged(shared_data):
    where = shared_data / "arm_kr300"
    model = read_model(where / "kr300.urdf")
    runs = [read_recording(where / f"run_{name}.csv", joints=model.joints) for name in "ABC"]
    found = discover(model, runs)
    assert found.verdict == "check_channels" and "masses" in found.rule
    line = found.next_experiment.split("--convention ")[1].split()[0]
    assert [part.partition("-motor-torque=")[0] for part in line.split(",")] == [f"a{k}" for k in range(1, 7)]
    read = [read_recording(where / f"run_{name}.csv", joints=model.joints, convention=line) for name in "ABC"]
    assert not check_masses(read, model.joints, model.pull)


@pytest.mark.parametrize(("name", "file"), [("ur10", "exciting.csv"), ("tx40", "run.csv")])
def test_real_arms_whose_joints_were_logged(shared_data, name, file):
    model = read_model(shared_data / f"arm_{name}" / f"{name}.urdf")
    recording = read_recording(shared_data / f"arm_{name}" / file, joints=model.joints)
    assert not check_masses([recording], model.joints, model.pull)
