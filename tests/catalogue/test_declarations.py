"""What the catalogue declares is so: friction takes power, sizes are visible, bounds mean what they say."""

import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from exoid.ground.errors import EffectError
from exoid.symbolic.effect_catalogue import catalogue, find_effect
from exoid.symbolic.effect_declaration import texts
from exoid.symbolic.language.lower import to_numpy
from exoid.symbolic.language.words import read_text
from exoid.symbolic.term import Term

WITH_TEXT = [effect for effect in catalogue().values() if effect.torque is not None]
FRICTION = [effect for effect in WITH_TEXT if effect.family == "friction"]

NOT_DISSIPATIVE = {
    "viscous_asymmetry": "the difference between two directions: more in one, less in the other",
    "position_friction": "a variation about the Coulomb friction of the base model, which keeps the sum positive",
    "hysteresis": "what presliding takes away from Coulomb friction; the sum of both is tested below",
}
DISSIPATIVE = [effect for effect in FRICTION if effect.id not in NOT_DISSIPATIVE]

# Joint angles and velocities of Table 1 of the paper, period 10 s.
T = np.linspace(0.0, 20.0, 2001)
W = 2.0 * np.pi / 10.0
ANGLE = np.array([[0.565], [-0.925]]) + np.array([[0.65], [0.65]]) * np.sin(W * T + [[0.0], [1.0]])
SPEED = np.array([[1.9], [1.6]]) * np.cos(3.0 * T + [[0.0], [1.0]])


def torque(effect, env, joint=None):
    """Return the torque at `joint` (0 hip, 1 knee), whose own words are taken from the numbered ones."""
    text = effect.torque if isinstance(effect.torque, str) else effect.torque[("hip", "knee")[joint]]
    own = {} if effect.on_both else {key[:-1]: value for key, value in env.items() if key.endswith(str(joint + 1))}
    node = read_text(text, not effect.on_both, (*effect.coefficients, *effect.shape))
    return np.broadcast_to(to_numpy(node, env | own), env["t"].shape)


def motion():
    """A motion within Table 1 with a load of some N·m."""
    env = {"t": T}
    for j in (0, 1):
        load = 20.0 * np.sin(5.0 * W * T + j)  # the highest harmonic of the paper's excitation
        env |= {f"theta{j + 1}": ANGLE[j], f"dtheta{j + 1}": SPEED[j], f"ddtheta{j + 1}": 4.0 * np.sin(3.0 * T)}
        env |= {f"tau_rigid{j + 1}": load, f"tau_model{j + 1}": load, f"theta[{('hip', 'knee')[j]}]": ANGLE[j]}
    return env


def typical(effect, side=1.0):
    """Return the typical numbers of an effect; a shape without one takes the middle of its range."""
    numbers = {key: c.typical for key, c in effect.coefficients.items()}
    for key, shape in effect.shape.items():
        usual = side if shape.choices else 0.5 * (shape.min + shape.max)
        numbers[key] = usual if shape.typical is None else shape.typical
    return numbers


def test_every_friction_is_declared_dissipative_or_says_why_not():
    assert set(NOT_DISSIPATIVE) <= {effect.id for effect in FRICTION}
    for effect in DISSIPATIVE:
        assert all(coefficient.min == 0.0 for coefficient in effect.coefficients.values()), effect.id


@pytest.mark.parametrize("effect", DISSIPATIVE, ids=lambda effect: effect.id)
@given(data=st.data())
def test_friction_takes_power_at_every_state(effect, data):
    state = st.floats(-5.0, 5.0)
    env = {"t": np.array([data.draw(st.floats(0.0, 300.0))])}
    for name in ("theta1", "theta2", "dtheta1", "dtheta2", "tau_rigid1", "tau_rigid2"):
        env[name] = np.array([data.draw(state, name)])
    for key, coefficient in effect.coefficients.items():
        env[key] = data.draw(st.floats(coefficient.min, 100.0), key)
    for key, shape in effect.shape.items():
        env[key] = data.draw(st.floats(shape.min, shape.max), key)
    power = [torque(effect, env, j) * env[f"dtheta{j + 1}"] for j in (0, 1)]
    if effect.on_both:
        # A damper between two bodies may push one of them, but the two together lose energy.
        scale = sum(np.abs(p) for p in power)
        assert np.all(sum(power) >= -1e-12 * (1.0 + scale))
    else:
        assert np.all(np.array(power) >= 0.0)


@pytest.mark.parametrize("law", [0.0, 1.0])
@pytest.mark.parametrize("sigma", [10.0, 70.0, 500.0])
def test_presliding_and_the_coulomb_friction_it_replaces_lose_energy_together(sigma, law):
    effect, env = find_effect("hysteresis"), motion() | {"c": 1.0, "sigma": sigma, "law": law}
    angle = 0.3 * np.sin(3.0 * T)
    speed = np.gradient(angle, T)
    env |= {"theta1": angle, "dtheta1": speed}
    together = np.sign(speed) + torque(effect, env, 0)
    assert np.abs(together).max() <= 1.0 + 1e-12
    power = together * speed
    assert power[300:].sum() > 0.0  # from the second swing on


@given(st.lists(st.floats(-2.0, 2.0), min_size=2, max_size=50), st.floats(0.001, 0.1))
def test_backlash_is_a_spring_behind_a_gap(angles, gap):
    effect = find_effect("backlash")
    theta = np.array(angles)
    env = {"t": np.arange(len(theta)) * 0.01, "theta1": theta, "c": 3.0}
    np.testing.assert_allclose(torque(effect, env | {"h": 0.0}, 0), 3.0 * theta, atol=1e-12)
    assert np.all(np.abs(torque(effect, env | {"h": gap}, 0) - 3.0 * theta) <= 3.0 * gap + 1e-9)


@pytest.mark.parametrize("side", [-1.0, 1.0])
@given(theta=st.floats(-2.0, 2.0), place=st.floats(-2.0, 2.0))
def test_an_end_stop_pushes_back_beyond_its_place_only(side, theta, place):
    env = {"t": np.zeros(1), "theta1": np.array([theta]), "c": 50.0, "side": side, "theta_s": place}
    value = float(torque(find_effect("end_stop"), env, 0)[0])
    beyond = side * (theta - place)
    assert value == pytest.approx(50.0 * side * beyond if beyond > 0.0 else 0.0)


def test_the_place_of_an_end_stop_belongs_to_the_recording():
    place = find_effect("end_stop").shape["theta_s"]
    assert place.per_recording and place.spacing == "position"
    assert "strapping" in place.explains and "encoder zero" in place.explains


@pytest.mark.parametrize("effect", WITH_TEXT, ids=lambda effect: effect.id)
def test_the_typical_size_is_visible_and_not_absurd(effect):
    largest = 0.0
    for side in (-1.0, 1.0):
        env = motion() | typical(effect, side)
        for joint in (0, 1):
            if effect.on_both or ("hip", "knee")[joint] in effect.joints:
                largest = max(largest, float(np.abs(torque(effect, env, joint)).max()))
    assert 0.3 < largest < 150.0


@pytest.mark.parametrize("effect", WITH_TEXT, ids=lambda effect: effect.id)
def test_every_number_declared_changes_the_torque(effect):
    def total(numbers):
        env = motion() | {"theta1": ANGLE[0], "theta2": ANGLE[1]} | numbers
        return np.concatenate([torque(effect, env, joint) for joint in (0, 1)])

    usual = {**dict.fromkeys(effect.coefficients, 1.0), **{k: typical(effect)[k] for k in effect.shape}}
    for key in usual:
        other = usual[key] * 0.5 if usual[key] else 0.25
        assert not np.allclose(total(usual), total(usual | {key: other})), key
    assert texts(effect)


def test_an_id_with_its_joint_is_understood():
    assert find_effect("stribeck:knee") is find_effect("stribeck")


@pytest.mark.parametrize(
    ("id", "message"),
    [
        ("stribeck:ankle", r"stribeck has no place at 'ankle'(.|\n)*use stribeck:hip or stribeck:knee"),
        ("stribeck:", "use stribeck:hip or stribeck:knee"),
        ("stribek:knee", "no effect 'stribek'(.|\n)*did you mean stribeck"),
        ("gravity_tilt:hip", "acts on both joints at once(.|\n)*leave the joint out: gravity_tilt"),
        ("rotor_inertia:hip", "Φ1 and Φ4(.|\n)*use rotor_inertia:knee"),
    ],
)
def test_a_wrong_joint_gets_a_helpful_text(id, message):
    with pytest.raises(EffectError, match=message):
        find_effect(id)


def test_a_reason_is_given_wherever_an_effect_is_absorbed():
    for effect in catalogue().values():
        for joint, reason in effect.absorbed_on.items():
            assert joint not in effect.joints and reason
            with pytest.raises(EffectError):
                Term(effect, joint)


def test_the_catalogue_itself_needs_no_arrays_and_no_algebra():
    # The package's front door offers Model, which needs NumPy; behind it the catalogue does not.
    code = (
        "import importlib.util, sys, types\n"
        "package = types.ModuleType('exoid.symbolic')\n"
        "package.__path__ = importlib.util.find_spec('exoid.symbolic').submodule_search_locations\n"
        "sys.modules['exoid.symbolic'] = package\n"
        "from exoid.symbolic.effect_catalogue import catalogue\n"
        "assert catalogue()\n"
        "print([m for m in ('numpy', 'sympy', 'casadi', 'scipy') if m in sys.modules])\n"
    )
    out = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert out.stdout.strip() == "[]"
