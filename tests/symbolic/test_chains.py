"""Models of machines that are not the leg: one joint, three, a tree, a drive that slides."""

import numpy as np
import pytest

from exoid.ground.errors import EffectError, ExoidError, ExpressionError
from exoid.symbolic import Coefficient, Effect, Model, Motion, read_model, write_model
from exoid.symbolic.check import check_equations
from exoid.symbolic.codegen import tree_columns
from exoid.symbolic.codegen.code import generate
from exoid.symbolic.codegen.fingerprint import model_key
from exoid.symbolic.codegen.kernel import compiled
from exoid.symbolic.identifiability import structural_look_alikes
from exoid.symbolic.joints import Joint
from exoid.symbolic.mechanics.newton_euler import link_torques
from exoid.symbolic.term import Term

KNEE = (Joint("knee"),)
LEG3 = (Joint("hip", length=0.42), Joint("knee", length=0.40), Joint("ankle", length=0.2))
DRIVE = (Joint("stage", "prismatic"),)
TREE = (Joint("left", length=0.42, parent="base"), Joint("left_knee"), Joint("right", parent="base"))


def machine(joints, gravity=9.81):
    return Model("machine", gravity=gravity, limits={}, joints=joints)


def motion(count, samples=30):
    rng = np.random.default_rng(5)
    return Motion(np.arange(samples) * 0.01, *(rng.normal(size=(samples, count)) for _ in range(3)))


def masses(model):
    """Numbers of links that could exist, as Phi."""
    numbers = {(k, kind): value for k in range(9) for kind, value in (("J", 0.4 + k), ("X", 0.5), ("m", 1.5 + k))}
    from exoid.symbolic.mechanics.base_parameters import base_parameters

    found = base_parameters(model.chain, model.gravity)
    return [numbers[p.link, p.kind] + sum(f * numbers[k, kind] for k, kind, f in p.parts) for p in found], numbers


@pytest.mark.slow
@pytest.mark.parametrize("backend", ["auto", "vm"])
@pytest.mark.parametrize(
    ("joints", "gravity", "terms"),
    [
        (KNEE, 9.81, ("stribeck:knee", "load_friction:knee", "backlash:knee")),
        (LEG3, 9.81, ("joint_spring:ankle", "biarticular_spring:knee", "rotor_inertia:ankle", "time_delay:hip")),
        (TREE, 9.81, ("cross_viscous:left", "hysteresis:right")),
        (DRIVE, 0.0, ("stribeck:stage", "viscous_quadratic:stage")),
    ],
)
def test_numpy_and_generated_code_agree(joints, gravity, terms, backend):
    model = machine(joints, gravity)
    for term in terms:
        model = model.with_effect(term)
    on, linear = motion(len(joints)), np.linspace(0.05, 0.3, len(model.parameters))
    fast = compiled(model, backend)
    wanted = model.torque(on, linear)
    assert wanted.shape == (30, len(joints))
    np.testing.assert_allclose(fast.inverse_dynamics(on, linear), wanted, atol=1e-10)
    np.testing.assert_allclose(fast.columns(on, None, linear), model.columns(on, None, linear), atol=1e-10)


@pytest.mark.parametrize(("joints", "gravity"), [(KNEE, 9.81), (LEG3, 9.81), (TREE, 9.81), (DRIVE, 0.0)])
def test_the_rigid_machine_obeys_newton_and_euler(joints, gravity):
    model, on = machine(joints, gravity), motion(len(joints))
    phi, numbers = masses(model)
    linear = np.array([*phi, *([0.0] * 2 * len(joints))])
    links = link_torques(joints, gravity, on.q.T, on.dq.T, on.ddq.T, np)
    wanted = sum(
        numbers[k, kind] * np.array([row + np.zeros(30) for row in one[kind]]).T
        for k, one in enumerate(links)
        for kind in one
    )
    fast = compiled(model)
    np.testing.assert_allclose(fast.inverse_dynamics(on, linear), wanted, atol=1e-9)
    np.testing.assert_allclose(fast.forward_dynamics(on, wanted, linear), on.ddq, atol=1e-9)
    assembled = (
        np.einsum("nij,nj->ni", fast.mass_matrix(on, linear), on.ddq)
        + np.einsum("nij,nj->ni", fast.coriolis(on, linear), on.dq)
        + fast.gravity(on, linear)
    )
    np.testing.assert_allclose(assembled, wanted, atol=1e-9)
    assert np.linalg.eigvalsh(fast.mass_matrix(on, linear)).min() > 0.0
    assert fast.jacobian(on, 0.1).shape == (30, 2, len(joints))


def test_two_joints_on_one_axis_are_a_machine(tmp_path):
    """Coaxial drives: the second link's angle counts from the first, and neither carries the other's weight."""
    path = tmp_path / "coaxial.toml"
    path.write_text('[[joints]]\nname = "first"\nlength = 0\n[[joints]]\nname = "second"\n', encoding="utf-8")
    model, on = read_model(path), motion(2)
    assert [joint.length for joint in model.joints] == [0.0, None]
    inertia, moment = (0.3, 0.2), (0.8, 0.5)
    phi = np.cumsum(on.q, axis=1)
    turning = np.array(inertia) * np.cumsum(on.ddq, axis=1) + 9.81 * np.array(moment) * np.sin(phi)
    wanted = np.column_stack([turning.sum(axis=1), turning[:, 1]])
    columns = np.moveaxis(model.columns(on), 1, 0)[:, :, : len(model.inertial)]
    x, y = columns.reshape(-1, columns.shape[2]), wanted.ravel()
    assert np.abs(x @ np.linalg.lstsq(x, y, rcond=None)[0] - y).max() < 1e-10


@pytest.mark.slow
def test_two_joints_that_are_hip_and_knee_give_the_torque_of_the_leg():
    """The general derivation against the leg's own, of the same masses."""
    joints = (Joint("hip", length=0.40), Joint("shank"))
    chain, leg, on = machine(joints), Model.standard(), motion(2)
    th, sh = {"m": 4.0, "l": 0.2, "I": 0.1}, {"m": 3.0, "l": 0.15, "I": 0.05}
    j_th, j_sh = (one["I"] + one["m"] * one["l"] ** 2 for one in (th, sh))
    phi = [j_th + 0.16 * sh["m"], th["m"] * th["l"] + 0.4 * sh["m"], j_sh, sh["m"] * sh["l"]]
    general = chain.torque(on, [*phi, 1.0, 2.0, 3.0, 4.0])
    paper = [
        j_th + j_sh + 0.16 * sh["m"], j_sh, 0.4 * sh["m"] * sh["l"], 0.4 * th["m"] * th["l"] - j_th,
    ]  # fmt: skip
    np.testing.assert_allclose(general, leg.torque(on, [*paper, 1.0, 2.0, 3.0, 4.0]), atol=1e-10)


@pytest.mark.slow
def test_many_joints_use_the_recursion_itself():
    joints = tuple(Joint(f"j{k}", length=0.2) for k in range(tree_columns.LONGEST_SYMBOLIC + 1))
    model, on = machine(joints), motion(len(joints), 4)
    linear = np.ones(len(model.parameters))
    np.testing.assert_allclose(compiled(model, "vm").inverse_dynamics(on, linear), model.torque(on, linear), atol=1e-9)


def test_a_wrong_derivation_is_noticed(monkeypatch):
    from exoid.symbolic.mechanics import tree

    form = tree.tree_form(KNEE, 9.7)
    monkeypatch.setattr(tree_columns, "tree_form", lambda *_: tree.TreeForm(form.parameters, 1.0001 * form.matrix))
    with pytest.raises(tree_columns.DerivationError, match="knee"):
        compiled(machine(KNEE, 9.7), "vm")


def test_words_of_other_joints():
    pull = Effect("pull", "", "k * (theta_next - theta) + d * dtheta[hip]",
                  coefficients={"k": Coefficient("N·m/rad"), "d": Coefficient("N·m·s/rad")}, custom=True)  # fmt: skip
    third = Effect("third", "", "k * theta3", coefficients={"k": Coefficient("N·m/rad")})
    model = machine(LEG3).with_effect(pull, "knee").with_effect(third, "hip")
    on, linear = motion(3), np.zeros(15)
    linear[12:] = 2.0, 3.0, 5.0
    tau = model.torque(on, linear)
    np.testing.assert_allclose(tau[:, 1], 2.0 * (on.q[:, 2] - on.q[:, 1]) + 3.0 * on.dq[:, 0], atol=1e-12)
    np.testing.assert_allclose(tau[:, 0], 5.0 * on.q[:, 2], atol=1e-12)
    for effect, joint in (
        (pull, "ankle"),
        (Effect("far", "", "k * theta4", coefficients={"k": Coefficient("N·m")}), "hip"),
    ):
        with pytest.raises(ExpressionError, match="there is no such joint"):
            machine(LEG3).with_effect(effect, joint).columns(on)
    with pytest.raises(ExpressionError, match="unknown name 'theta3'"):
        Model.standard().with_effect(third, "hip").columns(motion(2))


def test_effects_at_joints_of_a_machine():
    model = machine(LEG3)
    assert model.with_effect("stribeck:ankle").parameters[-1].name == "stribeck:ankle.c"
    for wrong, message in (
        ("stribeck:hop", "stribeck:hip or stribeck:knee or stribeck:ankle"),
        ("stribeck", "needs a joint"),
        ("biarticular_spring:ankle", "no place at 'ankle'"),
        ("rotor_inertia:hip", "contains it already"),
        ("gravity_tilt:hip", "all joints at once"),
        ("com_offset_thigh", "the leg with hip and knee alone has it"),
    ):
        with pytest.raises(EffectError, match=message):
            model.with_effect(wrong)
    with pytest.raises(EffectError, match="other joints"):
        Model("mixed", limits={}, joints=LEG3, terms=Model.standard().with_effect("stribeck:knee").terms)


def test_units_of_a_drive_that_slides():
    model = machine(DRIVE, 0.0).with_effect("stribeck:stage").with_effect("joint_spring:stage")
    units = {p.name: p.unit for p in model.parameters} | {s.name: s.shape.unit for s in model.shapes}
    assert units == {
        "Phi1": "kg", "coulomb:stage": "N", "viscous:stage": "N·s/m", "stribeck:stage.c": "N",
        "stribeck:stage.v_s": "m/s", "joint_spring:stage.k": "N/m", "joint_spring:stage.c": "N",
    }  # fmt: skip
    force = Effect("own", "", "c * dtheta", coefficients={"c": Coefficient("N·s/m")}, custom=True)
    assert machine(DRIVE, 0.0).with_effect(force, "stage").parameters[-1].unit == "N·s/m"
    with pytest.raises(ExpressionError, match="comes out in N·m"):
        wrong = Effect("own", "", "c * dtheta", coefficients={"c": Coefficient("N·m·s/rad")}, custom=True)
        machine(DRIVE, 0.0).with_effect(wrong, "stage")
    with pytest.raises(ExpressionError, match="comes out in"):
        Model.standard().with_effect(force, "knee")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("on_leg", "on_chain", "numbers", "shape"),
    [
        ("gravity_tilt", "gravity_tilt", (), (0.1,)),
        ("com_offset_thigh", "com_offset:hip", (0.3,), ()),
        ("com_offset_shank", "com_offset:shank", (0.3,), ()),
        ("encoder_offset_knee", "encoder_offset:shank", (), (0.2,)),
        ("base_motion", "base_motion", (0.3, 0.1, 0.7, 0.2), (1.3, 0.4)),
        ("cuff_interaction", "cuff_interaction", (200.0, 20.0, 3.0, 4.0), (0.2,)),
        ("motor_elasticity:hip", "motor_elasticity:hip", (0.02,), ()),
        ("series_backlash:knee", "series_backlash:shank", (0.02,), (1.0,)),
    ],
)
def test_what_changes_the_mechanism_changes_it_as_it_changes_the_leg(on_leg, on_chain, numbers, shape):
    chain, leg = machine((Joint("hip", length=0.40), Joint("shank"))).with_effect(on_chain), Model.standard()
    rng = np.random.default_rng(8)
    t = np.arange(40) * 0.02  # slow enough for what gives way under load
    q, dq, ddq = (np.stack([f(3.0 * t + k) for k in rng.normal(size=2)], axis=1) for f in (np.sin, np.cos, np.sin))
    on = Motion(t, q, dq, ddq)
    phi, paper = [2.3, 1.7, 0.4, 0.45], [2.7, 0.4, 0.4 * 0.45, 0.4 * 1.7 - 2.3]
    general = chain.torque(on, [*phi, *([0.0] * 4), *numbers], shape)
    np.testing.assert_allclose(
        general, leg.with_effect(on_leg).torque(on, [*paper, *([0.0] * 4), *numbers], shape), atol=1e-9
    )
    assert np.abs(general - chain.base().torque(on, [*phi, *([0.0] * 4)])).max() > 1e-3


@pytest.mark.slow
@pytest.mark.parametrize("joints", [KNEE, LEG3])
def test_a_base_that_turns_and_is_accelerated(joints):
    moving = Model("backpack", limits={}, joints=joints, moving_base=True)
    on, rng, count = motion(len(joints)), np.random.default_rng(4), len(joints)
    linear = np.array([*masses(machine(joints))[0], *([0.0] * 2 * count)])
    base = rng.normal(size=(30, 5))
    first = np.eye(count)[0]
    turned = Motion(on.t, *(x + base[:, [k]] * first for k, x in enumerate((on.q, on.dq, on.ddq))))
    swung = Motion(on.t, on.q, on.dq, on.ddq, base=np.column_stack([base[:, :3], 0.0 * base[:, 3:]]))
    np.testing.assert_allclose(moving.torque(swung, linear), machine(joints).torque(turned, linear), atol=1e-9)
    # An accelerated base is a pull of another size and direction (d'Alembert).
    ax, az = 1.3, -2.1
    pull, lean = np.hypot(ax, 9.81 + az), np.arctan2(ax, 9.81 + az)
    shaken = Motion(on.t, on.q, on.dq, on.ddq, base=np.tile([0.0, 0.0, 0.0, ax, az], (30, 1)))
    leaning = Motion(on.t, on.q + lean * first, on.dq, on.ddq)
    np.testing.assert_allclose(moving.torque(shaken, linear), machine(joints, pull).torque(leaning, linear), atol=1e-9)
    np.testing.assert_allclose(compiled(moving, "vm").inverse_dynamics(shaken, linear), moving.torque(shaken, linear))


def test_two_legs_on_a_backpack_are_a_tree():
    legs = tuple(Joint(f"{side}_{name}", length=length, parent=parent and parent.format(side))
                 for side in ("left", "right")
                 for name, length, parent in (("hip", 0.42, "base"), ("knee", None, None)))  # fmt: skip
    model = Model("legs", limits={}, joints=legs, moving_base=True)
    assert [str(one) for one in check_equations(model) if not one.holds] == []
    reached = model.with_effect("motor_elasticity:left_knee").columns(motion(4), None, np.ones(17))[:, :, -1]
    assert np.abs(reached[:2]).min(axis=1).max() > 0.0 and not reached[2:].any()


def test_what_no_motion_distinguishes_on_three_joints():
    model = machine(LEG3)
    candidates = [
        Term(model.find_effect(name), joint, LEG3) for name, joint in (("rotor_inertia", "knee"), ("stribeck", "ankle"))
    ]
    assert structural_look_alikes(model, candidates) == ()
    extra = Effect("extra", "", "c * sin(theta1)", coefficients={"c": Coefficient("N·m")})
    (one,) = structural_look_alikes(model, [Term(extra, "hip", LEG3)])
    assert one.absorbed and set(one.names) == {"extra:hip.c", "Phi2"}


def test_the_header_names_the_joints():
    made = generate(machine(LEG3))
    assert "state (13 per sample): t, theta1, theta2, theta3" in made.header
    assert "torque (hip, knee, ankle) in N m" in made.header and '"joints"' in made.manifest
    assert "J_ankle" in made.manifest


@pytest.mark.parametrize(("joints", "gravity"), [(KNEE, 9.81), (LEG3, 9.81), (TREE, 9.81), (DRIVE, 0.0)])
def test_every_check_of_a_machine_holds(joints, gravity):
    assert [str(one) for one in check_equations(machine(joints, gravity)) if not one.holds] == []


TEXT = """name = "leg with ankle"
gravity = 9.81

[[joints]]
name = "hip"
length = 0.42
position = [-0.3, 1.2]
velocity = 1.9
acceleration = 5.0

[[joints]]
name = "knee"
kind = "revolute"
length = 0.4

[[joints]]
name = "ankle"
velocity = 2.5

[[effects]]
id = "stribeck"
joint = "ankle"

[[custom_effects]]
id = "brake"
joint = "ankle"
torque = "c * dtheta[knee]"
coefficients = { c = { unit = "N·m·s/rad", min = 0 } }

[base]
motion = "fixed"
"""


def test_a_file_with_joints_comes_back_as_it_was(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(TEXT, encoding="utf-8")
    model = read_model(path)
    assert model.joint_names == ("hip", "knee", "ankle") and model.gravity == 9.81
    assert model.limits["hip"].angle == (-0.3, 1.2) and model.limits["ankle"].velocity == 2.5
    assert "knee" not in model.limits
    assert model.with_effect("brake:ankle").parameters[-1].name == "brake:ankle.c"
    again = read_model(write_model(model, tmp_path / "again.toml"))
    assert model_key(again) == model_key(model) and again.chain == model.chain and not again.moving_base
    path.write_text(TEXT.replace('"fixed"', '"measured"'), encoding="utf-8")
    moving = read_model(path)
    assert moving.moving_base and model_key(moving) != model_key(model)
    assert model_key(read_model(write_model(moving, tmp_path / "moving.toml"))) == model_key(moving)


def test_a_file_with_hip_and_knee_is_the_leg(tmp_path):
    path = tmp_path / "leg.toml"
    path.write_text('[[joints]]\nname = "hip"\nlength = 0.38\n[[joints]]\nname = "knee"\nvelocity = 1.0\n')
    model = read_model(path)
    assert not model.chain and model.thigh_length == 0.38 and model.gravity == 9.81
    assert model.limits["knee"].velocity == 1.0 and model.limits["knee"].angle == (-1.62, -0.23)
    assert model_key(model.with_effect("gravity_tilt"))


@pytest.mark.parametrize(
    ("old", "new", "line", "message"),
    [
        ("length = 0.42", "", 5, "the length of hip is missing"),
        ("length = 0.42", "length = -1", 6, "out of range"),
        ('name = "knee"', 'name = "hip"', 12, "two joints called 'hip'"),
        ('kind = "revolute"', 'kind = "ball"', 12, "unknown kind 'ball'"),
        ('kind = "revolute"', 'parent = "ankle"', 12, "no joint 'ankle' before it"),
        ("position = [-0.3, 1.2]", "position = [1.2, -0.3]", 7, "is empty"),
        ("velocity = 1.9", "speed = 1.9", 8, "unknown key 'speed'"),
        ("gravity = 9.81", "gravity = -1", 2, "out of range"),
        ("gravity = 9.81", "geometry = {}", 2, "does not go with"),
        ('joint = "ankle"\ntorque', 'joint = "elbow"\ntorque', 26, "there is no joint 'elbow'"),
        ("dtheta[knee]", "dtheta[elbow]", 27, "there is no such joint"),
        ('motion = "fixed"', 'motion = "free"', 31, "unknown motion 'free'"),
        ('id = "stribeck"', 'id = "gravity_tilt"', 22, "all joints at once"),
    ],
)
def test_refusals_name_the_line(tmp_path, old, new, line, message):
    assert old in TEXT
    path = tmp_path / "machine.toml"
    path.write_text(TEXT.replace(old, new, 1), encoding="utf-8")
    with pytest.raises(ExoidError, match=message) as caught:
        read_model(path)
    assert str(path) in str(caught.value) and f"line {line}" in str(caught.value)


def test_friction_of_the_last_of_twelve_joints_has_its_own_sign():
    """Numbers of joints may have two digits."""
    model = machine(tuple(Joint(f"j{k + 1}", length=0.3) for k in range(12)))
    moved = motion(12, 4)
    columns = compiled(model, "vm").columns(moved)
    places = [p.name for p in model.parameters]
    for joint in (9, 10, 11):
        assert columns[joint, :, places.index(f"coulomb:j{joint + 1}")] == pytest.approx(np.sign(moved.dq[:, joint]))
