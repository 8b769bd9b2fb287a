"""Measured forces in a model: their torque by virtual work, their numbers, and how a model file says them."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from exoid.ground.errors import EffectError, ModelFileError
from exoid.symbolic.check import check_equations
from exoid.symbolic.codegen.fingerprint import model_key
from exoid.symbolic.codegen.kernel import compiled
from exoid.symbolic.force import NORMAL, TORQUE, VERTICAL, WORLD, Force
from exoid.symbolic.joints import Joint
from exoid.symbolic.mechanics.newton_euler import BaseMotion
from exoid.symbolic.mechanics.pushed import placed_joints, pushed_torques
from exoid.symbolic.model import Model, read_model
from exoid.symbolic.model_file import write_model
from exoid.symbolic.motion import Motion

CUFFS = (Force("thigh cuff", "hip", ("f1",)), Force("shank cuff", "knee", ("f2",)))
GROUND = Force("ground", "knee", ("grf_x", "grf_z"))
TREE = (
    Joint("hip", length=0.4),
    Joint("knee", length=0.42),
    Joint("rail", "prismatic", length=0.2),
    Joint("ankle"),
    Joint("other", parent="hip"),
)


def motion_of(model, seed=0, count=20):
    rng = np.random.default_rng(seed)
    joints = len(model.joints)
    base = rng.normal(size=(count, 5)) if model.moving_base else None
    states = (rng.normal(size=(count, joints)) for _ in range(3))
    return Motion(np.arange(count) * 0.01, *states, base=base, force=rng.normal(size=(count, len(model.channels))))


def test_the_cuffs_of_the_leg_act_as_the_formula_says():
    leg = Model.standard().with_forces(*CUFFS)
    motion = motion_of(leg)
    r1, r2 = 0.27, 0.19
    linear = np.zeros(len(leg.parameters))
    linear[leg.friction.stop :] = r1, r2
    f1, f2 = motion.force.T
    knee = r2 * f2
    hip = r1 * f1 + 0.40 * np.cos(motion.q[:, 1]) * f2 + knee
    assert leg.torque(motion, linear) == pytest.approx(-np.column_stack([hip, knee]))


@pytest.mark.slow
@pytest.mark.parametrize("moving", [False, True])
def test_virtual_work_and_newton_euler_ask_the_drives_for_the_same_on_a_tree(moving):
    forces = [
        Force("a", "knee", ("f1",)),
        Force("b", "rail", ("x", "z")),
        Force("c", "ankle", ("n",), at=0.1),
        Force("v", "other", ("u",), frame=VERTICAL),
        Force("p", "ankle", ("it",), frame=TORQUE),
    ]
    model = Model(joints=TREE, moving_base=moving).with_forces(*forces)
    checks = [check for check in check_equations(model) if check.name == "measured forces"]
    assert len(checks) == len(forces)
    assert all(check.holds for check in checks), [str(check) for check in checks]


@pytest.mark.slow
@given(
    frame=st.sampled_from([NORMAL, WORLD, VERTICAL, TORQUE]),
    link=st.sampled_from(["hip", "knee", "ankle", "other"]),
    at=st.floats(-0.5, 1.5),
    gain=st.floats(0.1, 10.0),
    sign=st.sampled_from([1, -1]),
    seed=st.integers(0, 1000),
)
@settings(max_examples=8, deadline=None)
def test_place_and_gain_may_be_known_or_numbers_of_the_model(frame, link, at, gain, sign, seed):
    columns = ("x", "z") if frame == WORLD else ("x",)
    open_, known = (
        Model(joints=TREE).with_forces(Force("f", link, columns, a, frame, g, sign=sign))
        for a, g in ((None, None), (at, gain))
    )
    motion = motion_of(known, seed)
    numbers = {"f.gain": gain, "f.gain_at": gain * at}
    linear = np.array([numbers.get(p.name, 0.0) for p in open_.parameters])
    wanted = sign * gain * pushed_torques(placed_joints(known), motion.q, known.forces[0], at, motion.force)
    size = np.abs(wanted).max() + 1.0
    assert len(known.parameters) == known.friction.stop
    for model, numbers_of in ((open_, linear), (known, np.zeros(len(known.parameters)))):
        assert np.abs(model.torque(motion, numbers_of) - wanted).max() < 1e-9 * size


@pytest.mark.slow
def test_compiled_code_and_columns_agree_beside_effects_that_follow_the_model():
    leg = Model.standard().with_forces(*CUFFS).with_effect("load_friction:knee").with_effect("time_delay:hip")
    motion = motion_of(leg)
    linear = np.random.default_rng(3).normal(size=len(leg.parameters))
    assert leg.torque(motion, linear) == pytest.approx(compiled(leg).inverse_dynamics(motion, linear))


@pytest.mark.slow
def test_a_force_is_no_part_of_the_rigid_body_torque_that_friction_follows():
    leg = Model.standard().with_effect("load_friction:knee")
    pushed = leg.with_forces(Force("shank cuff", "knee", ("f2",), at=0.2))
    motion = motion_of(pushed)
    linear = np.abs(np.random.default_rng(4).normal(size=len(leg.parameters)))
    apart = pushed.torque(motion, linear) - leg.torque(motion, linear)
    assert apart == pytest.approx(pushed_torques(placed_joints(leg), motion.q, pushed.forces[0], 0.2, motion.force))


@pytest.mark.slow
def test_a_measured_base_turns_the_point_with_it():
    model = Model(joints=TREE[:2], moving_base=True).with_forces(Force("g", "knee", ("x", "z"), at=0.3))
    motion = motion_of(model)
    wanted = pushed_torques(model.chain, motion.q, model.forces[0], 0.3, motion.force, BaseMotion(*motion.base.T))
    assert model.torque(motion, np.zeros(len(model.parameters))) == pytest.approx(wanted)


FILE = """
name = "worn leg"
[[forces]]
name = "thigh cuff"
link = "hip"
at = 0.25
columns = ["f1"]
[[forces]]
name = "ground"
link = "shank"
columns = ["grf_x", "grf_z"]
gain = "identified"
sign = -1
delay = 0.01
"""


def test_a_model_file_says_the_forces_and_writes_them_again(tmp_path):
    (tmp_path / "leg.toml").write_text(FILE)
    leg = read_model(tmp_path / "leg.toml")
    assert leg.forces == (
        Force("thigh cuff", "hip", ("f1",), 0.25),
        Force("ground", "shank", ("grf_x", "grf_z"), None, WORLD, None, 0.01, -1),
    )
    write_model(leg, tmp_path / "again.toml")
    assert read_model(tmp_path / "again.toml").forces == leg.forces
    assert model_key(leg) != model_key(Model.standard())


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (('link = "hip"', 'link = "foot"'), "no link 'foot'"),
        (("at = 0.25", "at = 250"), "at is 250"),
        (('columns = ["f1"]', 'columns = "f1"'), "columns is a text"),
        (('columns = ["f1"]', 'columns = ["f1", "f2", "f3"]'), "3 columns"),
        (('columns = ["f1"]', 'columns = ["grf_x"]'), "grf_x is that of"),
        (('name = "ground"', 'name = "thigh cuff"'), "two called"),
        (("sign = -1", "sign = 2"), "sign is 0"),
        (("delay = 0.01", "delay = 20"), "delay is 20"),
        (("delay = 0.01", 'frame = "sideways"'), "unknown frame"),
    ],
)
def test_what_a_file_says_wrongly_of_a_force_is_told_with_its_place(tmp_path, change, said):
    path = tmp_path / "leg.toml"
    path.write_text(FILE.replace(*change))
    with pytest.raises(ModelFileError, match=r"leg\.toml") as caught:
        read_model(path)
    assert said in str(caught.value)


def test_a_force_that_does_no_work_is_refused():
    with pytest.raises(EffectError, match="does no work"):
        Model(joints=(Joint("rail", "prismatic"),)).with_forces(Force("f", "rail", ("x",)))
