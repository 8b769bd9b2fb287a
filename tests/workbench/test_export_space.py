"""Arms in space go out as URDF, MJCF and C, into their own URDF, and onto the virtual bench."""

import numpy as np
import pytest

from exoid.measurement.bench.simulation import simulate
from exoid.optimisation.linear.bodies import Body3D, nearest_bodies
from exoid.symbolic.mechanics.base_parameters import absorbed_rotors
from exoid.symbolic.model import model_of, read_model
from exoid.symbolic.model_file import Numbers, write_model
from exoid.symbolic.robot_file import parse_robot
from exoid.symbolic.spatial_machine import spatial_machine
from exoid.workbench.command import main
from exoid.workbench.export import mjcf, urdf
from exoid.workbench.identified import ExportError, Options, ready
from exoid.workbench.into_urdf import into_urdf
from tests.symbolic.arms import arm_text
from tests.workbench.test_export_machines import motion, rigid_torque

TEXT = arm_text(4, 4, ("revolute", "revolute", "prismatic"))


def bodies(count):
    rng = np.random.default_rng(3)
    return [
        Body3D(float(mass), rng.normal(size=3) * 0.1, float(mass) * 0.01 * np.diag([1.0, 1.3, 0.8]))
        for mass in rng.uniform(1.0, 4.0, count)
    ]


def identified(text=TEXT, gravity=9.81):
    model = model_of(spatial_machine(parse_robot(text.encode()), gravity=gravity).model)
    count = len(model.joints)
    phi = np.einsum("pjk,jk->p", model.mixture, [one.numbers for one in bodies(count)])
    linear = dict(zip([p.name for p in model.parameters], [*phi, *([0.5, 0.7] * count)], strict=True))
    return model, Numbers(linear, {}, None)


def check(text, model, given, read):
    on = motion(model)
    wanted = rigid_torque(model, given, on)
    for k in range(0, len(on), 9):
        np.testing.assert_allclose(read(text, on.q[k], on.dq[k], on.ddq[k]), wanted[k], rtol=1e-9, atol=1e-9)


def pinocchio_reads(text, q, dq, ddq):
    pin = pytest.importorskip("pinocchio")
    robot = pin.buildModelFromXML(text)
    return pin.rnea(robot, robot.createData(), q, dq, ddq)


def mujoco_reads(text, q, dq, ddq):
    mujoco = pytest.importorskip("mujoco")
    machine = mujoco.MjModel.from_xml_string(text)
    machine.dof_damping[:] = machine.dof_frictionloss[:] = 0.0
    machine.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    state = mujoco.MjData(machine)
    state.qpos, state.qvel, state.qacc = q, dq, ddq
    mujoco.mj_inverse(machine, state)
    return state.qfrc_inverse


@pytest.mark.slow
def test_urdf_and_mjcf_have_the_torque():
    model, given = identified()
    one = ready(model, given)
    check(urdf.write(one, Options())["exoid_leg.urdf"], model, given, pinocchio_reads)
    check(mjcf.write(one, Options())["exoid_leg.xml"], model, given, mujoco_reads)


@pytest.mark.slow
def test_gravity_goes_out_as_a_vector():
    from dataclasses import replace

    model, given = identified()
    tilted = replace(model, gravity=(1.0, 2.0, -9.0))
    text = mjcf.write(ready(tilted, given), Options())["exoid_leg.xml"]
    assert '<option gravity="1 2 -9"/>' in text
    check(text, tilted, given, mujoco_reads)


@pytest.mark.slow
def test_numbers_go_into_the_arms_own_urdf(tmp_path):
    model, given = identified()
    path = tmp_path / "arm.urdf"
    path.write_text(TEXT, encoding="utf-8")
    content, notes = into_urdf(ready(model, given), path)
    check(content.decode(), model, given, pinocchio_reads)
    assert any("plate0 moves with link0" in note for note in notes)
    path.write_text(arm_text(5, 4, ("revolute", "revolute", "prismatic")), encoding="utf-8")
    with pytest.raises(ExportError, match="another kind, axis or origin"):
        into_urdf(ready(model, given), path)


@pytest.mark.slow
def test_numbers_that_no_bodies_have_are_refused():
    model, given = identified()
    one = next(p.name for p in model.inertial if p.min == 0.0)
    given.linear[one] = -1.0
    with pytest.raises(ExportError, match="no machine of positive masses"):
        urdf.write(ready(model, given), Options())


def test_bodies_that_are_known_stay_as_they_are():
    model, given = identified()
    known = bodies(len(model.joints))
    phi = np.array([given.linear[p.name] for p in model.inertial])
    for one, other in zip(nearest_bodies(model, phi, known), known, strict=True):
        np.testing.assert_allclose(one.numbers, other.numbers, rtol=1e-6, atol=1e-9)


def test_the_bench_moves_an_arm():
    model, _ = identified(arm_text(6, 3))
    recording = simulate(model, duration=3.0)
    assert recording.joints == model.joints and np.isfinite(recording.tau).all()
    assert np.ptp(recording.q, axis=0).min() > 0.1, "every joint moves"


def test_the_command_makes_a_model_of_an_arm(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "arm.urdf").write_text(TEXT, encoding="utf-8")
    assert main(["model", "--from-urdf", "arm.urdf"]) == 0
    assert "a spatial machine" in capsys.readouterr().out
    assert read_model("arm.toml").joint_names == ("j0", "j1", "j2", "j3")
    assert main(["model", "--from-urdf", "arm.urdf", "--out", "new", "--quiet"]) == 0
    assert read_model("new/arm.toml").spatial
    model, given = identified()
    bare = write_model(model, tmp_path / "m.toml").read_text(encoding="utf-8")
    lines = "\n".join(f'"{name}" = {float(value)!r}' for name, value in given.linear.items())
    (tmp_path / "m.toml").write_text(f"{bare}\n[identified.parameters]\n{lines}\n", encoding="utf-8")
    assert main(["export", "m.toml", "--out", "done", "--into", "arm.urdf", "--quiet"]) == 0
    assert (tmp_path / "done" / "arm_identified.urdf").is_file()


@pytest.mark.slow
def test_friction_rotors_and_springs_go_out_in_mujocos_conventions():
    """MuJoCo's torque has its own damping, armature and springs, and frictionloss times the sign of the rate."""
    mujoco = pytest.importorskip("mujoco")
    model, given = identified(arm_text(6, 4, ("revolute", "revolute", "prismatic")))
    joint = next(name for name, own in zip(model.joint_names, absorbed_rotors(model.chain), strict=True) if not own)
    model = model.with_effect(f"rotor_inertia:{joint}").with_effect(f"joint_spring:{joint}")
    more = {f"rotor_inertia:{joint}.c": 0.4, f"joint_spring:{joint}.k": 3.0, f"joint_spring:{joint}.c": -1.5}
    given = Numbers({**given.linear, **more}, {}, None)
    text = mjcf.write(ready(model, given), Options())["exoid_leg.xml"]
    machine = mujoco.MjModel.from_xml_string(text)
    loss = machine.dof_frictionloss.copy()
    machine.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONSTRAINT
    on = motion(model)
    wanted = model.torque(on, np.array([given.linear[p.name] for p in model.parameters]))
    for k in range(0, len(on), 9):
        state = mujoco.MjData(machine)
        state.qpos, state.qvel, state.qacc = on.q[k], on.dq[k], on.ddq[k]
        mujoco.mj_inverse(machine, state)
        np.testing.assert_allclose(state.qfrc_inverse + loss * on.sign[k], wanted[k], rtol=1e-9, atol=1e-9)
    content = urdf.write(ready(model, given), Options())["exoid_leg.urdf"]
    assert f"cannot carry: rotor_inertia:{joint}, joint_spring:{joint}" in content
    assert 'damping="0.7" friction="0.5"' in content
