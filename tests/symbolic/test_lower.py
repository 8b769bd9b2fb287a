"""One tree says the same in NumPy, SymPy and CasADi, and reads well as plain text."""

import casadi
import numpy as np
import pytest
import sympy
from hypothesis import given, settings
from hypothesis import strategies as st

from exoid.ground.errors import ExpressionError
from exoid.symbolic.language.lower import to_casadi, to_numpy, to_sympy
from exoid.symbolic.language.parser import parse
from exoid.symbolic.language.torque import Torque, part_of
from exoid.symbolic.language.tree import FUNCTIONS, Binary, Call, Name, Number, Unary
from exoid.symbolic.language.writing import to_text

NAMES = ("theta1", "dtheta2", "c", "v_s")
STATES = np.array([[0.3, -0.7, 0.9, 0.2], [-0.4, 0.6, -1.0, 0.5], [0.8, 1.0, 0.1, 0.7]]).T


def in_numpy(node):
    values = to_numpy(node, dict(zip(NAMES, STATES, strict=True)))
    return np.broadcast_to(values, STATES.shape[1])


def in_sympy(node):
    symbols = sympy.symbols(NAMES, real=True)
    expression = to_sympy(node, dict(zip(NAMES, symbols, strict=True)))
    return [float(expression.subs(dict(zip(symbols, state, strict=True)))) for state in STATES.T]


def in_casadi(node):
    symbols = [casadi.SX.sym(name) for name in NAMES]
    expression = to_casadi(node, dict(zip(NAMES, symbols, strict=True)))
    function = casadi.Function("f", symbols, [casadi.SX(expression)])
    return [float(function(*state)) for state in STATES.T]


def check_agreement(node):
    values = in_numpy(node)
    np.testing.assert_allclose(in_sympy(node), values, rtol=1e-9, atol=1e-10)
    np.testing.assert_allclose(in_casadi(node), values, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("word", sorted(FUNCTIONS))
def test_every_function_agrees(word):
    positive = word in ("log", "sqrt")
    arguments = ["v_s + 0.1", "v_s"] if positive else ["theta1 * dtheta2", "c"]
    check_agreement(parse(f"{word}({', '.join(arguments[: FUNCTIONS[word]])})", NAMES))


@pytest.mark.parametrize("exponent", [n / 2 for n in range(-16, 17)])
def test_every_power_agrees(exponent):
    base = "theta1" if exponent == int(exponent) else "v_s"
    check_agreement(parse(f"({base})**{exponent}", NAMES))


@pytest.mark.parametrize(
    "text", ["pi", "2", "1.7e308 * theta1 / 1e308", "theta1 - c / v_s", "-theta1**2", "-2**0.5 * 1e-3", "--c"]
)
def test_arithmetic_agrees(text):
    check_agreement(parse(text, NAMES))


def _grow(children):
    # Only what stays well conditioned, so that rounding cannot be mistaken for disagreement.
    return st.one_of(
        children.map(lambda part: Unary("-", part)),
        st.builds(Binary, st.sampled_from("+-*"), children, children),
        st.builds(lambda word, a: Call(word, (a,)), st.sampled_from(["sin", "cos", "tanh", "abs"]), children),
        st.builds(lambda word, a, b: Call(word, (a, b)), st.sampled_from(["max", "min"]), children, children),
    )


calm = st.recursive(
    st.one_of(st.integers(1, 10).map(lambda n: Number(n / 10)), st.sampled_from(NAMES).map(Name)),
    _grow,
    max_leaves=8,
)


@settings(max_examples=60, deadline=None)
@given(calm)
def test_random_trees_agree(tree):
    check_agreement(tree)


def test_the_sign_of_a_velocity_is_the_signal_that_was_given():
    node = parse("c * sgn(dtheta1) + sgn(2 * dtheta1)", ["c", "dtheta1"])
    env = {"c": 2.0, "dtheta1": np.array([0.5, -0.5])}
    assert to_numpy(node, env, {"dtheta1": np.array([0.25, 0.0])}).tolist() == [1.5, -1.0]
    c, v, s = sympy.symbols("c v s", real=True)
    assert to_sympy(node, {"c": c, "dtheta1": v}, {"dtheta1": s}) == c * s + sympy.sign(2 * v)
    symbol = casadi.SX.sym("s")
    written = to_casadi(node, {"c": 2.0, "dtheta1": casadi.SX(0.5)}, {"dtheta1": symbol})
    assert float(casadi.substitute(written, symbol, 0.25)) == 1.5


def test_operators_run_over_the_recording():
    t = np.array([0.0, 0.1, 0.3, 0.4])
    x = np.array([0.0, 1.0, 1.0, 0.0])
    node = parse("c * (delay(theta1, d) - theta1)", ["c", "d", "theta1"])
    values = to_numpy(node, {"t": t, "theta1": x, "c": 2.0, "d": 0.1})
    np.testing.assert_allclose(values, [0.0, -2.0, 0.0, 2.0], atol=1e-12)


def test_operators_become_undefined_functions_in_sympy():
    theta = sympy.Symbol("theta", real=True)
    expression = to_sympy(parse("play(theta, 0.5)", ["theta"]), {"theta": theta})
    assert str(expression) == "play(theta, 1/2)"


def test_casadi_says_that_it_cannot_remember():
    with pytest.raises(ExpressionError, match="needs a whole recording"):
        to_casadi(parse("ddt(c)", ["c"]), {"c": casadi.SX.sym("c")})


@pytest.mark.parametrize("text", ["log(theta1)", "sqrt(theta1)", "1 / (theta1 - theta1)", "exp(1e4 * v_s)"])
def test_a_torque_that_is_no_number_is_refused_with_its_sample(text):
    with pytest.raises(ExpressionError, match=r"not a finite number at sample [01]\b"):
        in_numpy(parse(text, NAMES))


def test_a_missing_value_is_named():
    with pytest.raises(ExpressionError, match="'c' has no value here"):
        to_numpy(parse("c", ["c"]), {"t": np.zeros(2)})


def test_a_parameter_of_an_operator_must_not_vary():
    node = parse("play(theta1, theta1)", ["theta1"])
    with pytest.raises(ExpressionError, match="varies with the motion"):
        to_numpy(node, {"t": np.arange(3.0), "theta1": np.ones(3)})


@pytest.mark.parametrize(
    "text", ["c - (1 - 2)", "-(c * 2)", "(-c)**2", "-c**2", "c * (-1)", "c / (2 * 3)", "(c + 1) * 2", "1e-12 * c"]
)
def test_plain_text_keeps_the_brackets_it_needs(text):
    node = parse(text, ["c"])
    assert parse(to_text(node), ["c"]) == node


def test_a_coefficient_alone_is_the_text_without_the_others():
    rng = np.random.default_rng(5)
    env = {"theta1": rng.normal(size=9), "dtheta1": rng.normal(size=9), "t": np.arange(9.0), "w": 0.7}
    texts = ("a * sin(w * theta1) - b * theta1", "-(b / 2) * dtheta1 + a * delay(theta1, w)", "ddt(a * theta1 - b)")
    for text in texts:
        node = parse(text, ["a", "b", *env])
        torque = Torque(0, text, node, node.names())
        for key in ("a", "b"):
            whole = to_numpy(torque.node, {**env, "a": float(key == "a"), "b": float(key == "b")})
            alone = part_of(torque, key, ("a", "b"))
            assert not alone.names & {"a", "b"}
            np.testing.assert_array_equal(np.broadcast_to(to_numpy(alone.node, env), 9), np.broadcast_to(whole, 9))


@pytest.mark.parametrize("numbers", [np.linspace(3.0, 400.0, 398), np.geomspace(1.0, 90.0, 20), np.arange(5.0)])
def test_waves_of_many_trial_values_are_those_of_each(numbers):
    x = np.linspace(-2.0, 3.0, 50)
    node = parse("sin(n * theta1) - cos(n * theta1 * 2)", ["n", "theta1"])
    values = to_numpy(node, {"t": x, "theta1": x, "n": numbers[:, None]})
    each = [to_numpy(node, {"t": x, "theta1": x, "n": float(n)}) for n in numbers]
    np.testing.assert_allclose(values, each, atol=2e-12)


def test_torques_with_memory_of_many_trial_values_are_those_of_each():
    t = np.cumsum(np.linspace(0.008, 0.012, 300))
    x = np.sin(3.0 * t) + 0.3 * np.sin(17.0 * t)
    text = "play(theta1, h) + dahl(tanh(theta1 / h), 5 * h) + delay(theta1, h) + ddt(slow(theta1 * h, 9 + h))"
    node = parse(text, ["h", "theta1"])
    sizes = np.array([0.0625, 0.25, 0.5])
    values = to_numpy(node, {"t": t, "theta1": x, "h": sizes[:, None]})
    each = [to_numpy(node, {"t": t, "theta1": x, "h": float(h)}) for h in sizes]
    np.testing.assert_allclose(values, each, rtol=1e-12, atol=1e-12)
