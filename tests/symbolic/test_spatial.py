"""Machines in space: what they say in files, and their equations against SymPy, Pinocchio and MuJoCo."""

from dataclasses import replace

import numpy as np
import pytest

from exoid.ground.errors import EffectError, ModelFileError
from exoid.symbolic import Model, Motion, read_model, write_model
from exoid.symbolic.check import check_equations
from exoid.symbolic.codegen import spatial_columns
from exoid.symbolic.codegen.fingerprint import model_key
from exoid.symbolic.codegen.kernel import compiled
from exoid.symbolic.codegen.tree_columns import DerivationError
from exoid.symbolic.joints import Joint, Origin
from exoid.symbolic.mechanics.base_parameters import absorbed_rotors
from exoid.symbolic.mechanics.spatial import KINDS, joint_frames, link_columns
from exoid.symbolic.mechanics.spatial_energy import pseudo_inertia
from exoid.symbolic.model import model_of
from exoid.symbolic.robot_file import parse_robot
from exoid.symbolic.spatial_machine import spatial_machine
from tests.symbolic.arms import arm_text

RIGHT = np.pi / 2
PANDA = tuple(
    Joint(f"joint{k + 1}", axis=(0, 0, 1), origin=Origin(place, (roll, 0, 0)))
    for k, (place, roll) in enumerate([
        ((0, 0, 0.333), 0), ((0, 0, 0), -RIGHT), ((0, -0.316, 0), RIGHT), ((0.0825, 0, 0), RIGHT),
        ((-0.0825, 0.384, 0), -RIGHT), ((0, 0, 0), RIGHT), ((0.088, 0, 0), RIGHT),
    ])
)  # fmt: skip
ELBOW = (Joint("turn", axis=(0, 0, 1)), Joint("lift", axis=(0, 1, 0), origin=Origin((0.1, 0, 0.3), (0.2, 0, 0.4))))
ARMS = [(0, 3, ("revolute",), False), (1, 6, ("revolute", "continuous"), False),
        (2, 5, ("revolute", "revolute", "prismatic"), True)]  # fmt: skip


def machine(joints, gravity=9.81):
    return Model("machine", gravity=gravity, limits={}, joints=joints)


def motion(count, samples=12):
    rng = np.random.default_rng(5)
    return Motion(np.arange(samples) * 0.01, *(rng.normal(size=(samples, count)) for _ in range(3)))


def test_the_base_parameters_of_a_known_arm_are_those_of_the_literature():
    """43 of 70, as Gaz, Cognetti, Oliva, Robuffo Giordano and De Luca give them for the Franka Emika Panda."""
    model = machine(PANDA)
    assert len(model.inertial) == 43
    assert model.inertial[0].label == "Φ1 = ZZ_joint1 + YY_joint2" and model.inertial[0].min == 0.0
    assert absorbed_rotors(PANDA) == (True, True, False, False, False, False, False)
    with pytest.raises(EffectError, match="contains it already"):
        model.with_effect("rotor_inertia:joint2")


@pytest.mark.parametrize("effect", ["gravity_tilt", "com_offset:lift", "base_motion", "cuff_interaction"])
def test_effects_of_a_plane_have_no_place(effect):
    with pytest.raises(EffectError, match=r"needs a joint|no place|in a plane"):
        machine(ELBOW).with_effect(effect)


@pytest.mark.slow
def test_an_encoder_that_reads_too_little():
    model, on = machine(ELBOW), motion(2)
    off = model.with_effect("encoder_offset:lift")
    linear = np.linspace(0.1, 1.0, len(model.parameters))
    moved = Motion(on.t, on.q + np.array([0.0, 0.2]), on.dq, on.ddq)
    np.testing.assert_allclose(off.torque(on, linear, np.array([0.2])), model.torque(moved, linear), atol=1e-12)


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["auto", "vm"])
def test_numpy_and_generated_code_agree(backend):
    model = machine((*ELBOW, Joint("slide", "prismatic", axis=(1, 0, 0), origin=Origin((0, 0, 0.2)))))
    for term in (
        "stribeck:turn", "load_friction:lift", "time_delay:slide", "motor_elasticity:lift", "rotor_inertia:slide"
    ):  # fmt: skip
        model = model.with_effect(term)
    on, linear = motion(3), np.linspace(0.05, 0.3, len(model.parameters))
    fast = compiled(model, backend)
    np.testing.assert_allclose(fast.inverse_dynamics(on, linear), model.torque(on, linear), atol=1e-10)
    np.testing.assert_allclose(fast.columns(on, None, linear), model.columns(on, None, linear), atol=1e-10)


@pytest.mark.slow
def test_every_check_of_the_equations_holds():
    for model in (machine(ELBOW), machine(PANDA[:4], (1.0, 2.0, -9.0))):
        assert all(check.holds for check in check_equations(model)), list(map(str, check_equations(model)))


def test_a_wrong_derivation_is_noticed(monkeypatch):
    monkeypatch.setattr(spatial_columns, "lagrange_torques", lambda joints, *_: _wrong(joints, *_))
    with pytest.raises(DerivationError, match="turn, lift"):
        compiled(machine(ELBOW, 9.7), "vm")


def _wrong(joints, pull, *rest):
    from exoid.symbolic.mechanics.spatial_energy import lagrange_torques

    return lagrange_torques(joints, tuple(1.0001 * part for part in pull), *rest)


@pytest.mark.slow
def test_lagrange_by_sympy_gives_every_column():
    """Column by column: energies of one unit of each of a link's ten parameters, differentiated by SymPy."""
    import sympy as sp

    pull, on = (0.5, -1.0, -9.81), motion(2, 3)
    q, dq, ddq = (sp.Matrix(sp.symbols(f"{stem}1:3", real=True)) for stem in ("q", "dq", "ddq"))
    wanted = [(link, kind) for link in range(2) for kind in KINDS]
    derived = []
    for link, kind in wanted:
        turned, place = joint_frames(ELBOW, list(q), sp)[link]
        at = sp.Matrix([[*row, step] for row, step in zip(turned, place, strict=True)])
        moved = sum((at.diff(a) * rate for a, rate in zip(q, dq, strict=True)), sp.zeros(3, 4))
        inertia = sp.Matrix(pseudo_inertia({kind: 1}))
        kinetic = (moved * inertia * moved.T).trace() / 2
        potential = -(sp.Matrix([pull]) * at * inertia[:, 3])[0]
        momentum = [kinetic.diff(rate) for rate in dq]
        derived.append([
            sum(p.diff(a) * r + p.diff(r) * b for a, r, b in zip(q, dq, ddq, strict=True))
            - kinetic.diff(q[k]) + potential.diff(q[k])
            for k, p in enumerate(momentum)
        ])  # fmt: skip
    found = sp.lambdify([*q, *dq, *ddq], sp.Matrix(derived), "numpy")
    for k in range(len(on)):
        state = on.q[k], on.dq[k], on.ddq[k]
        np.testing.assert_allclose(
            link_columns(ELBOW, pull, *state, np, wanted), found(*np.concatenate(state)), atol=1e-10
        )


def own_numbers(robot, names):
    """The ten parameters of every link (J, 10) in our order, as Pinocchio has them."""
    order = [4, 5, 7, 6, 8, 9, 1, 2, 3, 0]
    return np.array([robot.inertias[robot.getJointId(name)].toDynamicParameters()[order] for name in names])


@pytest.mark.slow
@pytest.mark.parametrize(("seed", "count", "kinds", "branch"), ARMS)
def test_pinocchio_computes_the_same(seed, count, kinds, branch):
    pin = pytest.importorskip("pinocchio")
    text = arm_text(seed, count, kinds, branch)
    found = spatial_machine(parse_robot(text.encode()))
    machine = model_of(found.model)
    robot = pin.buildModelFromXML(text.replace("continuous", "revolute"))
    data, model, on = robot.createData(), machine, motion(count)
    links = own_numbers(robot, found.names)
    linear = np.concatenate([np.einsum("pjk,jk->p", model.mixture, links), np.zeros(2 * count)])
    places = [robot.joints[robot.getJointId(name)].idx_v for name in found.names]
    fast, columns = compiled(model), model.columns(on)
    torque, mass, back = (f(on, linear) for f in (fast.inverse_dynamics, fast.mass_matrix, fast.gravity))
    bias = np.einsum("nij,nj->ni", fast.coriolis(on, linear), on.dq) + back
    forward = fast.forward_dynamics(on, torque, linear)
    ends = fast.jacobian(on, 0.0)
    order = [9, 6, 7, 8, 0, 1, 3, 2, 4, 5]
    for k in range(len(on)):
        q, dq, ddq = (np.zeros(count) for _ in range(3))
        q[places], dq[places], ddq[places] = on.q[k], on.dq[k], on.ddq[k]
        close = {"rtol": 1e-9, "atol": 1e-9}
        np.testing.assert_allclose(torque[k], pin.rnea(robot, data, q, dq, ddq)[places], **close)
        np.testing.assert_allclose(mass[k], pin.crba(robot, data, q)[np.ix_(places, places)], **close)
        np.testing.assert_allclose(bias[k], pin.nonLinearEffects(robot, data, q, dq)[places], **close)
        np.testing.assert_allclose(forward[k], on.ddq[k], rtol=1e-7, atol=1e-7)
        regressor = pin.computeJointTorqueRegressor(robot, data, q, dq, ddq)[places].reshape(count, -1, 10)
        ids = [robot.getJointId(name) - 1 for name in found.names]
        ours = np.einsum("jp,pik->jik", columns[:, k, : len(model.inertial)], model.mixture)
        np.testing.assert_allclose(ours[:, :, order], regressor[:, ids], **close)
        end = robot.getJointId(found.names[-1])
        full = pin.computeJointJacobians(robot, data, q)
        full = pin.getJointJacobian(robot, data, end, pin.ReferenceFrame.LOCAL_WORLD_ALIGNED)[:3][:, places]
        np.testing.assert_allclose(ends[k], full, **close)


@pytest.mark.parametrize(("seed", "count", "kinds", "branch"), ARMS)
def test_mujoco_computes_the_same(seed, count, kinds, branch):
    mujoco, pin = pytest.importorskip("mujoco"), pytest.importorskip("pinocchio")
    text = arm_text(seed, count, kinds, branch)
    found = spatial_machine(parse_robot(text.encode()))
    robot = pin.buildModelFromXML(text.replace("continuous", "revolute"))
    links = own_numbers(robot, found.names)
    other, on = mujoco.MjModel.from_xml_string(text), motion(count)
    other.opt.gravity[:], other.opt.disableflags = (0.0, 0.0, -9.81), mujoco.mjtDisableBit.mjDSBL_LIMIT
    state = mujoco.MjData(other)
    places = [other.jnt_dofadr[other.joint(name).id] for name in found.names]
    linear = np.concatenate([np.einsum("pjk,jk->p", found.model.mixture, links), np.zeros(2 * count)])
    torque = compiled(found.model).inverse_dynamics(on, linear)
    for k in range(len(on)):
        state.qpos[places], state.qvel[places], state.qacc[places] = on.q[k], on.dq[k], on.ddq[k]
        mujoco.mj_inverse(other, state)
        np.testing.assert_allclose(state.qfrc_inverse[places], torque[k], rtol=1e-9, atol=1e-9)


def test_a_model_file_says_the_same_again(tmp_path):
    vector = (0.3, 0.1, -9.7)
    joints = (*ELBOW, Joint("slide", "prismatic", axis=(1, 1, 0), origin=Origin((0, 0, 0.2)), parent="turn"))
    model = machine(joints, vector)
    again = read_model(write_model(model, tmp_path / "m.toml"))
    assert again.joints == model.joints and again.gravity_vector == vector and model_key(again) == model_key(model)
    assert model_key(machine(joints, (0.0, 0.0, -9.81))) == model_key(machine(joints))


def test_gravity_and_its_vector_cannot_contradict_each_other():
    model = machine(ELBOW, (0.0, 3.0, -9.0))
    assert model.gravity == np.hypot(3.0, 9.0) and replace(model, gravity=(0.0, 0.0, -1.0)).gravity_vector is None
    with pytest.raises(EffectError, match="its vector"):
        replace(model, gravity=1.0)
    with pytest.raises(EffectError, match="the machine is planar"):
        machine((Joint("a"),), (0.0, 0.0, -9.81))


HEAD = '[[joints]]\nname = "a"\n'


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (HEAD + "axis = [0, 0, 1]\n" + HEAD.replace('"a"', '"b"'), "b says no axis"),
        (HEAD + "axis = [0, 0, 1]\nlength = 0.3\n", "a has a length"),
        (HEAD + "axis = [0, 0, 0]\n", "length zero"),
        (HEAD + "axis = [0, 0]\n", "3 numbers"),
        (HEAD + "axis = [0, 0, 1]\norigin = { xyz = [1e9, 0, 0] }\n", "the origin's xyz"),
        (HEAD + "axis = [0, 0, 1]\norigin = { yaw = 1 }\n", "yaw"),
        ("gravity = [0, 0, -9.81]\n" + HEAD, "no joint has an axis"),
        ("gravity = [0, 0, -981]\n" + HEAD + "axis = [0, 0, 1]\n", "gravity is 981"),
        (HEAD + 'axis = [0, 0, 1]\n[base]\nmotion = "swaying"\n', "unknown motion"),
        (HEAD + 'axis = [0, 0, 1]\n[wearer]\nmass = 70\nheight = 1.8\n', "cannot have that yet"),
    ],
)  # fmt: skip
def test_what_is_no_machine_is_refused_with_its_place(tmp_path, text, message):
    path = tmp_path / "m.toml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises((ModelFileError, EffectError), match=message):
        read_model(path)
