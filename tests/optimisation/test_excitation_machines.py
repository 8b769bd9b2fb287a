"""Motions are designed for any machine: the sums in C are those of CasADi, the limits of every joint hold."""

import numpy as np
import pytest

from exoid.measurement.trajectories.trajectory_file import read_trajectory, sample_table, write_trajectory
from exoid.optimisation.excitation.criteria import Noise
from exoid.optimisation.excitation.design import design
from exoid.optimisation.fitting.nominal import nominal
from exoid.symbolic.codegen.information import information
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model

MACHINES = {
    "drive": Model("drive", joints=(Joint("drive"),)),
    "crane": Model("crane", joints=(Joint("boom", length=0.4), Joint("reach", "prismatic"))),
    "three": Model("three", joints=(Joint("hip", length=0.4), Joint("knee", length=0.4), Joint("ankle"))),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", MACHINES)
def test_both_backends_make_the_same_sums(name):
    model, rng = MACHINES[name], np.random.default_rng(0)
    joints, at = len(model.joints), nominal(model)
    limits = np.array([(-1.0, 1.0, 2.0, 6.0)] * joints)
    swings, offsets = 0.2 * rng.normal(size=(3, joints, 4)), 0.1 * rng.normal(size=(3, joints))
    made = [
        information(model, at.linear, at.shape, limits, period=8.0, harmonics=2, grid=64, backend=backend)
        for backend in ("auto", "vm")
    ]
    one, other = (info.sums(swings, offsets, rescale=True) for info in made)
    np.testing.assert_allclose(one.factor, other.factor, rtol=1e-9)
    np.testing.assert_allclose(one.gram, other.gram, rtol=1e-8, atol=1e-9 * np.abs(other.gram).max())


@pytest.mark.parametrize("name", ["drive", "crane"])
def test_a_motion_is_inside_the_limits_of_every_joint(name, tmp_path):
    model = MACHINES[name]
    found = design(
        model, individuals=8, generations=20, harmonics=3, noise=Noise.white(0.3, joints=model.joints)
    )
    assert found.feasible and np.isfinite(found.condition)
    assert [use.joint for use in found.uses] == [joint for joint in model.joint_names for _ in range(3)]
    again = read_trajectory(
        write_trajectory(found.trajectory, tmp_path / "m.toml", model.joint_names), model.joint_names
    )
    assert np.allclose(again.sine, found.trajectory.sine)
    assert sample_table(again, 50.0).splitlines()[0].count("q") == 3 * len(model.joints)
    assert list(found.to_json()["trajectory"])[1:] == list(model.joint_names)
    assert len(found.plot().axes) == 3 * len(model.joints)
