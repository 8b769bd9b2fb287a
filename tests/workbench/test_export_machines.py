"""Exports of machines that are not the leg: one drive, a slide, hip-knee-ankle, both legs on a base that moves."""

from __future__ import annotations

import ctypes
import shutil
import subprocess

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from exoid.optimisation.linear.links import LinkInertia, nearest_links
from exoid.symbolic.joints import Joint
from exoid.symbolic.model import Model, model_of
from exoid.symbolic.model_file import Numbers, write_model
from exoid.symbolic.motion import Motion
from exoid.symbolic.planar_machine import planar_machine
from exoid.symbolic.robot_file import read_robot
from exoid.workbench.command import main
from exoid.workbench.export import c, mjcf, numpy, urdf
from exoid.workbench.identified import ExportError, Options, ready
from exoid.workbench.into_urdf import into_urdf
from tests.exported_module import python_module

HKA = (Joint("hip", length=0.42), Joint("knee", length=0.4), Joint("ankle"))
LEGS = (Joint("hip_l", length=0.42, parent="base"), Joint("knee_l"), Joint("hip_r", length=0.4, parent="base"),
        Joint("knee_r"))  # fmt: skip
MACHINES = {
    "drive": Model("drive", limits={}, joints=(Joint("drive"),)).with_effect("stribeck:drive"),
    "slide": Model("slide", gravity=0.0, limits={}, joints=(Joint("axis", "prismatic"),)).with_effect(
        "torque_offset:axis"
    ),
    "hka": Model("hka", limits={}, joints=HKA).with_effect("com_offset:ankle").with_effect("backlash:knee"),
    "legs": Model("legs", limits={}, joints=LEGS, moving_base=True),
}


def numbers(model: Model, seed: int = 1) -> Numbers:
    """Return numbers of links that could exist, with friction and the usual sizes of effects."""
    rng, count = np.random.default_rng(seed), len(model.joints)
    mass, along, own = rng.uniform(1.0, 4.0, count), rng.uniform(0.05, 0.3, count), rng.uniform(0.05, 0.1, count)
    links = np.column_stack([own + mass * along**2, mass * along, mass])
    phi = np.einsum("pjk,jk->p", model.mixture, links)
    effects = [0.2 * (p.typical or 1.0) for p in model.parameters[model.base_count :]]
    linear = dict(zip([p.name for p in model.parameters], [*phi, *([0.5, 0.7] * count), *effects], strict=True))
    return Numbers(linear, {s.name: float(v) for s, v in zip(model.shapes, model.typical_shape, strict=True)}, None)


def motion(model: Model) -> Motion:
    t = np.arange(0.0, 1.0, 0.01)
    phase = np.arange(len(model.joints)) + 1.0
    q, dq, ddq = (a * np.sin(np.outer(t, 3.0 * phase) + phase + b) for a, b in ((0.4, 0.0), (1.2, 1.6), (3.6, 3.1)))
    base = np.random.default_rng(2).normal(size=(len(t), 5)) if model.moving_base else None
    return Motion(t, q, dq, ddq, base=base)


def rigid_torque(model: Model, given: Numbers, on: Motion) -> np.ndarray:
    """Return the torque (N, J) without friction and effects other than a mass beside an axis."""
    kept = {n: v for n, v in given.linear.items() if n.startswith(("Phi", "com_offset"))}
    linear = np.array([kept.get(p.name, 0.0) for p in model.parameters])
    return model.torque(on, linear, np.array(list(given.shape.values())))


@pytest.mark.parametrize("name", MACHINES)
def test_c_and_numpy_give_the_torque_of_the_model(name, tmp_path):
    model = MACHINES[name]
    given, on, options = numbers(model), motion(model), Options("machine", 0.01)
    one = ready(model, given)
    wanted = model.torque(on, np.array(list(given.linear.values())), np.array(list(given.shape.values())))
    swaying = [] if on.base is None else [on.base]
    module = python_module(numpy.write(one, options)["machine.py"], tmp_path, "machine")
    np.testing.assert_allclose(module.torque(on.t, on.q, on.dq, on.ddq, *swaying), wanted, rtol=1e-9, atol=1e-9)
    compiler = shutil.which("cc") or shutil.which("gcc")
    if compiler is None:
        pytest.skip("no C compiler")
    for file, text in c.write(one, options).items():
        (tmp_path / file).write_text(text, encoding="utf-8")
    strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-shared", "-fPIC"]
    command = [compiler, *strict, "-o", "m.so", "machine.c", "-lm"]
    made = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert made.returncode == 0, made.stderr
    library = ctypes.CDLL(str(tmp_path / "m.so"))
    count, state = len(model.joints), (ctypes.c_double * 64)()
    vector = ctypes.c_double * count
    if one.memories:
        library.machine_init(state)
    found = np.empty_like(wanted)
    for k in range(len(on)):
        tau = vector()
        given_base = [] if on.base is None else [(ctypes.c_double * 5)(*on.base[k])]
        library.machine_torque(
            *([state] if one.memories else []), ctypes.c_double(on.t[k]),
            *(vector(*x[k]) for x in (on.q, on.dq, on.ddq)), *given_base, tau,
        )  # fmt: skip
        found[k] = tau
    np.testing.assert_allclose(found, wanted, rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", MACHINES)
def test_pinocchio_and_mujoco_read_the_machine_and_give_its_rigid_torque(name):
    pin, mujoco = pytest.importorskip("pinocchio"), pytest.importorskip("mujoco")
    model = MACHINES[name]
    given, on = numbers(model), motion(model)
    one = ready(model, given)
    on = Motion(on.t, on.q, on.dq, on.ddq)  # a base that stands still: these files do not move it
    wanted = rigid_torque(model, given, on)
    robot = pin.buildModelFromXML(urdf.write(one, Options())["exoid_leg.urdf"])
    robot.gravity.linear = np.array([0.0, 0.0, -model.gravity])
    machine = mujoco.MjModel.from_xml_string(mjcf.write(one, Options())["exoid_leg.xml"])
    machine.dof_damping[:] = 0.0
    machine.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    data, state = robot.createData(), mujoco.MjData(machine)
    assert [robot.getJointId(j) - 1 for j in model.joint_names] == list(range(len(model.joints)))
    assert [machine.joint(j).dofadr[0] for j in model.joint_names] == list(range(len(model.joints)))
    for k in range(0, len(on), 9):
        np.testing.assert_allclose(pin.rnea(robot, data, on.q[k], on.dq[k], on.ddq[k]), wanted[k], rtol=1e-9, atol=1e-9)
        state.qpos, state.qvel, state.qacc = on.q[k], on.dq[k], on.ddq[k]
        mujoco.mj_inverse(machine, state)
        np.testing.assert_allclose(state.qfrc_inverse, wanted[k], rtol=1e-9, atol=1e-9)


def test_mujoco_has_rotor_spring_and_viscous_friction():
    mujoco = pytest.importorskip("mujoco")
    model = Model("hk", limits={}, joints=HKA).with_effect("rotor_inertia:knee").with_effect("joint_spring:ankle")
    given, on = numbers(model), motion(model)
    given.linear["joint_spring:ankle.c"] = -0.4
    machine = mujoco.MjModel.from_xml_string(mjcf.write(ready(model, given), Options())["exoid_leg.xml"])
    machine.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    linear = np.array([0.0 if p.name.startswith("coulomb") else given.linear[p.name] for p in model.parameters])
    wanted, state = model.torque(on, linear), mujoco.MjData(machine)
    for k in range(0, len(on), 9):
        state.qpos, state.qvel, state.qacc = on.q[k], on.dq[k], on.ddq[k]
        mujoco.mj_inverse(machine, state)
        np.testing.assert_allclose(state.qfrc_inverse, wanted[k], rtol=1e-9, atol=1e-9)


OWN = """<?xml version="1.0"?>
<!-- Müller's walker -->
<robot name="walker">
  <link name="base"/>
  <link name="thigh"><inertial><origin xyz="0 0.05 -0.2"/><mass value="4"/>
    <inertia ixx="0.06" iyy="0.05" izz="0.01" ixy="0" ixz="0" iyz="0"/></inertial><visual/></link>
  <link name="shank"/>
  <link name='cover'><inertial><origin xyz="0 0 -0.1"/><mass value='.3'/></inertial></link>
  <link name="foot"><inertial><origin xyz="0.06 0 -0.05"/><mass value="1"/></inertial></link>
  <joint name="hip" type="revolute"><parent link="base"/><child link="thigh"/><origin xyz="0 0.1 0"/>
    <axis xyz="0 -1 0"/><limit lower="-0.3" upper="1.2" velocity="1.9" effort="80"/><dynamics damping="9"/></joint>
  <joint name="knee" type="revolute"><parent link="thigh"/><child link="shank"/>
    <origin xyz="0 0.02 -0.42" rpy="0 0 1.5707963267948966"/><axis xyz="-1 0 0"/>
    <limit lower="-2" upper="0" velocity="2" effort="80"/></joint>
  <joint name="plate" type="fixed"><parent link="shank"/><child link="cover"/></joint>
  <joint name="foot-lift" type="revolute"><parent link="cover"/><child link="foot"/>
    <origin xyz="0 0 -0.4" rpy="0 0 -1.5707963267948966"/><axis xyz="0 -1 0"/>
    <limit lower="-1" upper="1" velocity="2" effort="80"/></joint>
</robot>
"""


def test_numbers_go_back_into_the_own_urdf_and_nothing_else_changes(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(OWN, encoding="utf-8")
    model = model_of(planar_machine(read_robot(path)).model)
    assert [term.name for term in model.terms] == ["com_offset:foot_lift"]
    given = numbers(model)
    data, notes = into_urdf(ready(model, given), path)
    text = data.decode("utf-8")
    assert "<!-- Müller's walker -->" in text and 'effort="80"' in text and "<visual/>" in text
    assert 'damping="0.7" friction="0.5"' in text and 'damping="9"' not in text
    assert notes == ("cover moves with shank, whose inertial now holds both",)
    pin = pytest.importorskip("pinocchio")
    robot, on = pin.buildModelFromXML(text), motion(model)
    state, wanted = robot.createData(), rigid_torque(model, given, on)
    for k in range(0, len(on), 9):
        np.testing.assert_allclose(
            pin.rnea(robot, state, on.q[k], on.dq[k], on.ddq[k]), wanted[k], rtol=1e-9, atol=1e-9
        )


def odd_urdf(seed: int) -> str:
    """Return a chain whose frames are turned anyhow: axes reversed, fixed joints between, links without inertia or with
    a picture alone, the plane turned about the vertical and its parts beside each other.
    """
    rng = np.random.default_rng(seed)
    turned = Rotation.from_euler("z", rng.uniform(0.0, 2.0 * np.pi))
    normal, parts = turned.apply([0.0, -1.0 if seed % 2 else 1.0, 0.0]), ['<link name="world"/>']
    place, frame, parent = np.zeros(3), Rotation.identity(), "world"

    def origin(at: np.ndarray, to: Rotation) -> str:
        xyz, rpy = frame.inv().apply(at - place), (frame.inv() * to).as_euler("xyz")
        return f'<origin xyz="{" ".join(map(repr, map(float, xyz)))}" rpy="{" ".join(map(repr, map(float, rpy)))}"/>'

    def body(k: int) -> str:
        rpy = " ".join(f"{x:.3f}" for x in rng.uniform(-3.0, 3.0, 3))
        beside = normal * rng.uniform(-0.05, 0.05) + [0.0, 0.0, -0.15]
        at = " ".join(map(repr, map(float, frame.inv().apply(beside))))
        inertia = '<inertia ixx="0.03" iyy="0.02" izz="0.015" ixy="0.001" ixz="0" iyz="-0.002"/>'
        inertial = f'<inertial><origin xyz="{at}" rpy="{rpy}"/><mass value="2.5"/>{inertia}</inertial>'
        return ("", "<visual><geometry><box size='1 1 1'/></geometry></visual>", inertial)[(seed + k) % 3]

    for k in range(3):
        if k == 1 or seed % 3 == 0:  # a fixed joint between
            at, to = rng.normal(size=3), Rotation.random(random_state=rng)
            parts.append(f'<link name="plate{k}"/><joint name="bolt{k}" type="fixed"><parent link="{parent}"/>'
                         f'<child link="plate{k}"/>{origin(at, to)}</joint>')  # fmt: skip
            place, frame, parent = at, to, f"plate{k}"
        at, to = np.array([0.0, 0.0, -0.4 * k]) + normal * rng.uniform(-0.3, 0.3), Rotation.random(random_state=rng)
        axis = " ".join(map(repr, map(float, to.inv().apply(normal) * rng.uniform(0.5, 2.0))))
        parts.append(f'<joint name="j{k}" type="continuous"><parent link="{parent}"/><child link="b{k}"/>'
                     f'{origin(at, to)}<axis xyz="{axis}"/></joint>')  # fmt: skip
        place, frame, parent = at, to, f"b{k}"
        parts.append(f'<link name="b{k}">{body(k)}</link>')
    return f'<robot name="odd">{"".join(parts)}</robot>'


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(6))
def test_numbers_go_into_an_odd_urdf(seed, tmp_path):
    pin, mujoco = pytest.importorskip("pinocchio"), pytest.importorskip("mujoco")
    path = tmp_path / "robot.urdf"
    path.write_text(odd_urdf(seed), encoding="utf-8")
    model = model_of(planar_machine(read_robot(path), ["j0", "j1", "j2"]).model)
    given, on = numbers(model, seed), motion(model)
    text = into_urdf(ready(model, given), path)[0].decode("utf-8")
    wanted = rigid_torque(model, given, on)
    robot, machine = pin.buildModelFromXML(text), mujoco.MjModel.from_xml_string(text)
    machine.dof_damping[:] = machine.dof_frictionloss[:] = 0.0
    data, state = robot.createData(), mujoco.MjData(machine)
    for k in range(0, len(on), 17):
        q = np.column_stack([np.cos(on.q[k]), np.sin(on.q[k])]).ravel()  # Pinocchio has no angle of a continuous joint
        np.testing.assert_allclose(pin.rnea(robot, data, q, on.dq[k], on.ddq[k]), wanted[k], rtol=1e-9, atol=1e-9)
        state.qpos, state.qvel, state.qacc = on.q[k], on.dq[k], on.ddq[k]
        mujoco.mj_inverse(machine, state)
        np.testing.assert_allclose(state.qfrc_inverse, wanted[k], rtol=1e-9, atol=1e-9)


def test_numbers_that_are_the_files_own_leave_its_bodies_as_they_are(tmp_path):
    """Of all bodies with the same numbers, the nearest to the file's is the file's."""
    model = Model("hka", limits={}, joints=HKA)
    mine = [LinkInertia(0.3, 0.8, 0.0, 4.0), LinkInertia(0.15, 0.45, 0.0, 2.5), LinkInertia(0.02, 0.08, 0.0, 1.0)]
    links = [[one.inertia, one.along, one.mass] for one in mine]
    phi = np.einsum("pjk,jk->p", model.mixture, links)
    found = nearest_links(model, phi, near=mine)
    for one, other in zip(found, mine, strict=True):
        np.testing.assert_allclose(
            [one.inertia, one.along, one.mass], [other.inertia, other.along, other.mass], rtol=1e-6
        )


def test_what_cannot_be_written_is_refused_in_words(tmp_path):
    path = tmp_path / "robot.urdf"
    path.write_text(OWN, encoding="utf-8")
    model = Model("hka", limits={}, joints=HKA)
    with pytest.raises(ExportError, match="no joint 'ankle'"):
        into_urdf(ready(model, numbers(model)), path)
    longer = Model("hka", limits={}, joints=(Joint("hip", length=0.5), Joint("knee")))
    with pytest.raises(ExportError, match=r"0\.5 m long in the model"):
        into_urdf(ready(longer, numbers(longer)), path)
    bent = numbers(model)
    bent.linear["Phi1"] = -1.0
    with pytest.raises(ExportError, match="no machine of positive masses"):
        urdf.write(ready(model, bent), Options())


def test_the_command_writes_all_of_it(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "robot.urdf").write_text(OWN, encoding="utf-8")
    model = model_of(planar_machine(read_robot("robot.urdf")).model)
    bare = write_model(model, tmp_path / "m.toml").read_text(encoding="utf-8")
    lines = "\n".join(f'"{name}" = {float(value)!r}' for name, value in numbers(model).linear.items())
    (tmp_path / "m.toml").write_text(f"{bare}\n[identified.parameters]\n{lines}\n", encoding="utf-8")
    assert main(["export", "m.toml", "--out", "done", "--into", "robot.urdf", "--quiet"]) == 0
    assert (tmp_path / "done" / "robot_identified.urdf").is_file() and (tmp_path / "done" / "exoid_leg.xml").is_file()
    assert (tmp_path / "robot.urdf").read_text(encoding="utf-8") == OWN
