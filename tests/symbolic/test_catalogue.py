"""Every effect of the catalogue keeps what it declares, and says the same in every language."""

import sys
from functools import partial

import casadi
import numpy as np
import pytest
import sympy

from exoid.ground.errors import EffectError
from exoid.symbolic import effects
from exoid.symbolic.effect_catalogue import FAMILIES, catalogue, find_effect
from exoid.symbolic.effect_declaration import check_effect, texts
from exoid.symbolic.language.instant import split_memory
from exoid.symbolic.language.lower import to_casadi, to_numpy, to_sympy
from exoid.symbolic.language.operators import MEMORY
from exoid.symbolic.language.words import MODEL_TORQUE, read_text
from exoid.symbolic.language.writing import to_text
from exoid.symbolic.model import Model
from exoid.symbolic.term import Term

TEXTS = [(effect, text) for effect in catalogue().values() for text in texts(effect)]
NAMES = [f"{effect.id}-{k}" for k, (effect, _) in enumerate(TEXTS)]
every_text = pytest.mark.parametrize(("effect", "text"), TEXTS, ids=NAMES)
every_effect = pytest.mark.parametrize("effect", catalogue().values(), ids=catalogue().keys())


def node_of(effect, text):
    return read_text(text, not effect.on_both, (*effect.coefficients, *effect.shape))


def signals(effect, node, n=200):
    """A motion and values of coefficients and shapes, at uneven times."""
    rng = np.random.default_rng(11)
    t = np.cumsum(0.01 * (0.5 + rng.random(n)))
    numbers = {key: 0.7 + k for k, key in enumerate(effect.coefficients)}
    numbers |= {key: middle(shape) for key, shape in effect.shape.items()}
    waves = {
        name: (2.0 if "tau" in name else 0.8) * np.sin((1.0 + k) * t + k)
        for k, name in enumerate(sorted(node.names() - numbers.keys() - {"t"}))
    }
    return {"t": t} | waves | numbers


def middle(shape):
    if shape.choices:
        return shape.choices[0]
    return (shape.min * shape.max) ** 0.5 if shape.spacing == "log" else 0.4 * shape.min + 0.6 * shape.max


def test_it_is_sorted_by_family_and_id():
    keys = [(FAMILIES.index(effect.family), effect.id) for effect in catalogue().values()]
    assert keys == sorted(keys)


@every_effect
def test_every_effect_is_complete(effect):
    check_effect(effect)
    for part in (effect.title, effect.explains, effect.tells_apart, effect.reference):
        assert part.strip() == part != ""
    assert effect.explains.endswith(".")
    assert effect.tells_apart.endswith(".")
    assert any(year in effect.reference for year in ("19", "20"))
    assert not effect.custom
    for number in (*effect.coefficients.values(), *effect.shape.values()):
        assert number.unit
        assert number.explains
    for shape in effect.shape.values():
        assert 2 <= shape.points <= 400
    for coefficient in effect.coefficients.values():
        assert coefficient.typical is not None


@every_effect
def test_the_parameters_get_names_at_every_joint(effect):
    for joint in [None] if effect.on_both else effect.joints:
        term = Term(effect, joint)
        assert [p.name for p in term.parameters] == [f"{term.name}.{key}" for key in effect.coefficients]
        assert [s.name for s in term.shapes] == [f"{term.name}.{key}" for key in effect.shape]
        for shape in term.shapes:
            assert shape.shape.min <= shape.typical <= shape.shape.max


@every_text
def test_numpy_sympy_and_casadi_agree(effect, text):
    node = node_of(effect, text)
    env = signals(effect, node)
    values = np.broadcast_to(to_numpy(node, env), env["t"].shape)
    names = sorted(env)
    symbols = dict(zip(names, sympy.symbols(names, real=True), strict=True))
    memory = {word: partial(operator_over, word, env["t"]) for word in MEMORY}
    function = sympy.lambdify(list(symbols.values()), to_sympy(node, symbols), [memory, "numpy"])
    np.testing.assert_allclose(function(*(env[name] for name in names)), values, rtol=1e-9, atol=1e-9)

    env |= {f"sign{word.removeprefix('dtheta')}": np.sign(env[word]) for word in names if word.startswith("dtheta")}
    rest, operations = split_memory(node, 0)
    for one in operations:
        parameter = [] if one.parameter is None else [to_numpy(one.parameter, env)]
        env[one.name] = operator_over(one.operator, env["t"], to_numpy(one.argument, env), *parameter)
    inputs = {name: casadi.SX.sym(name) for name in env}
    compiled = casadi.Function("f", list(inputs.values()), [casadi.SX(to_casadi(rest, inputs))])
    table = [np.broadcast_to(env[name], env["t"].shape)[None, :] for name in inputs]
    scale = max(1.0, float(np.max(np.abs(values))))
    np.testing.assert_allclose(compiled(*table).full().ravel(), values, rtol=1e-12, atol=1e-13 * scale)


def operator_over(word, t, x, *parameters):
    return MEMORY[word](t, np.broadcast_to(x, t.shape), *map(float, parameters))


@every_text
def test_the_torque_is_linear_and_homogeneous_by_algebra(effect, text):
    node = node_of(effect, text)
    names = sorted(node.names())
    symbols = dict(zip(names, sympy.symbols(names, real=True), strict=True))
    torque = to_sympy(node, symbols)
    if not effect.coefficients:
        assert MODEL_TORQUE & node.names()
        # delay and ddt are linear themselves, so any linear stand-in shows whether the rest is.
        for word, stand_in in (("delay", lambda x, d: (3 + d) * x), ("ddt", lambda x: 5 * x)):
            torque = torque.replace(sympy.Function(word, real=True), stand_in)
    linear = [symbols[name] for name in names if name in (effect.coefficients or MODEL_TORQUE)]
    assert linear
    assert torque.subs({symbol: 0 for symbol in linear}) == 0
    assert sympy.expand(torque - sum(sympy.diff(torque, s) * s for s in linear)) == 0
    for symbol in linear:
        assert not sympy.diff(torque, symbol).free_symbols & set(linear)


@every_text
def test_the_torque_is_linear_in_numbers(effect, text):
    node = node_of(effect, text)
    env = signals(effect, node)
    linear = [name for name in node.names() if name in (effect.coefficients or MODEL_TORQUE)]
    twice = env | {name: 2.0 * env[name] for name in linear}
    np.testing.assert_allclose(to_numpy(node, twice), 2.0 * to_numpy(node, env), rtol=1e-12, atol=1e-12)


@every_text
def test_what_has_no_coefficients_and_nothing_else_is_made_of_the_whole_torque(effect, text):
    words = {name.rstrip("12") for name in node_of(effect, text).names()}
    assert ("tau_model" in words) == (not effect.coefficients)


@every_text
def test_no_corner_of_the_shapes_overflows(effect, text):
    node = node_of(effect, text)
    for corner in range(2 ** len(effect.shape)):
        ends = {
            key: (shape.max if corner >> k & 1 else shape.min) for k, (key, shape) in enumerate(effect.shape.items())
        }
        values = to_numpy(node, signals(effect, node) | ends)
        assert np.max(np.abs(values)) < 1e12


@every_text
def test_it_is_written_as_it_was_read(effect, text):
    node = node_of(effect, text)
    assert to_text(node) == text


def turned(effect, text):
    """Return the own velocity, the torque, and the torque of the motion with every velocity the other way round."""
    node = node_of(effect, text)
    env = signals(effect, node)
    back = env | {name: -env[name] for name in env if name.startswith("dtheta")}
    return env.get("dtheta"), to_numpy(node, env), to_numpy(node, back)


WITHOUT_MEMORY = [pair for pair in TEXTS if not node_of(*pair).calls() & MEMORY.keys()]


@pytest.mark.parametrize(
    ("effect", "text"), [p for p in WITHOUT_MEMORY if p[0].family == "friction"], ids=lambda x: getattr(x, "id", "")
)
def test_friction_depends_on_which_way_a_joint_moves(effect, text):
    _, forth, back = turned(effect, text)
    odd, even = np.allclose(back, -forth, atol=1e-12), np.allclose(back, forth, atol=1e-12)
    assert odd or (even and any(name.startswith("dtheta") for name in node_of(effect, text).names()))


@pytest.mark.parametrize(("effect", "text"), WITHOUT_MEMORY, ids=lambda x: getattr(x, "id", ""))
def test_what_turns_with_the_velocity_takes_power_from_the_motion(effect, text):
    velocity, forth, back = turned(effect, text)
    positive = all(c.min is not None and c.min >= 0.0 for c in effect.coefficients.values())
    if velocity is not None and positive and np.allclose(back, -forth, atol=1e-12):
        assert np.all(forth * velocity >= 0.0)


@pytest.mark.parametrize(
    "effect", [e for e in catalogue().values() if isinstance(e.torque, dict)], ids=lambda effect: effect.id
)
def test_an_effect_on_both_joints_has_a_potential_or_a_dissipation_function(effect):
    hip, knee = (node_of(effect, effect.torque[joint]) for joint in ("hip", "knee"))
    names = {*hip.names(), *knee.names()}
    stem = "dtheta" if any(name.startswith("dtheta") for name in names) else "theta"
    symbols = {name: sympy.Symbol(name, real=True) for name in names}
    one, two = to_sympy(hip, symbols), to_sympy(knee, symbols)
    assert sympy.diff(one, symbols[f"{stem}2"]) == sympy.diff(two, symbols[f"{stem}1"])


def test_the_rotor_belongs_to_the_knee_and_the_hip_says_why():
    with pytest.raises(EffectError, match="base model contains it already, as a change of Φ1 and Φ4"):
        Term(find_effect("rotor_inertia"), "hip")


def test_an_unknown_effect_gets_a_suggestion():
    with pytest.raises(EffectError, match=r"there is no effect 'stribek'(.|\n)*did you mean stribeck"):
        find_effect("stribek")
    with pytest.raises(EffectError, match=r"the catalogue has: .*stribeck"):
        find_effect("!" * 5000)


def test_the_ripple_search_misses_no_frequency():
    shape = find_effect("torque_ripple").shape["n"]
    step = (shape.max - shape.min) / (shape.points - 1)
    theta = np.linspace(0.0, 1.4, 2000)  # the range of Table 1

    def wave(n):
        return np.stack([np.sin(n * theta), np.cos(n * theta)], axis=1)

    for n in (3.5 * step, 100.0 + step / 2.0):
        near = wave(n + step / 2.0)
        rest = wave(n) - near @ np.linalg.lstsq(near, wave(n), rcond=None)[0]
        assert np.sum(rest**2) < 0.1 * np.sum(wave(n) ** 2)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder of effects instead of the catalogue's own; what is imported from it is forgotten again."""
    monkeypatch.setattr(effects, "__path__", [str(tmp_path)])
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        if name.startswith("exoid.symbolic.effects."):
            del sys.modules[name]


def test_a_new_file_is_a_new_effect(folder):
    source = (
        "from exoid.symbolic.effect import Effect, Shape\n"
        "def derive(mechanism, symbols):\n    return mechanism\n"
        'TIP = {"d": Shape("m", 0.0, 1.0)}\n'
        'EFFECT = Effect("trial_a", "", None, derive, ("both",), shape=TIP, family="base")\n'
    )
    (folder / "trial_a.py").write_text(source)
    assert list(catalogue.__wrapped__()) == ["trial_a"]


@pytest.mark.parametrize(
    "source",
    [
        "",
        "EFFECT = 3",
        'from exoid.symbolic.effect import Effect\nEFFECT = Effect(id="other", explains="", family="base")',
        'from exoid.symbolic.effect import Effect\nEFFECT = Effect(id="trial_b", explains="", family="magic")',
    ],
)
def test_a_file_that_is_no_effect_is_named(folder, source):
    (folder / "trial_b.py").write_text(source)
    with pytest.raises(EffectError, match=r"exoid/symbolic/effects/trial_b\.py: the file does not define"):
        catalogue.__wrapped__()


def test_a_leg_on_a_moving_base_is_another_machine_whatever_was_asked_before():
    """Of equal joints the catalogue that was asked for first answered for both: suspects hung on what ran before."""
    standing, moving = Model.standard(), Model("walker", moving_base=True)
    assert standing.joints != moving.joints
    assert "com_offset" in catalogue(moving.joints) and "com_offset" not in catalogue(standing.joints)
