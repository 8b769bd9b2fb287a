"""An effect that contradicts its own declaration is refused, and told where."""

from dataclasses import replace

import pytest

from exoid.ground.errors import EffectError, ExpressionError
from exoid.symbolic.effect import Coefficient, Effect, Shape
from exoid.symbolic.effect_declaration import check_effect

C = {"c": Coefficient("N·m", min=0.0)}
GOOD = Effect(id="brake", explains="", torque="c * sgn(dtheta)", coefficients=C)


@pytest.mark.parametrize(
    "text",
    [
        "c * theta",
        "-c / (1 + theta2**2)",
        "(c * theta + 2 * c) * 3 - c",
        "delay(c * theta, 0.1) + ddt(c * t)",
        "c * play(theta, 0.1) * exp(-t / 3) * pi",
        "c * max(theta, 0)",
    ],
)
def test_linear_texts_pass(text):
    check_effect(replace(GOOD, torque=text))


@pytest.mark.parametrize(
    ("text", "pointed"),
    [
        ("c * theta + 1", "1"),
        ("theta - c", "theta"),
        ("c**2 * theta", "c**2"),
        ("theta * (c * c)", "c * c"),
        ("theta / c", "theta / c"),
        ("2 * abs(c)", "abs(c)"),
        ("max(c, theta)", "max(c, theta)"),
        ("sin(c * theta)", "sin(c * theta)"),
        ("play(c * theta, 0.1)", "play(c * theta, 0.1)"),
        ("theta", "theta"),
        ("c * play(theta, 0.1 * t)", "0.1 * t"),
        ("delay(theta, c)", "delay(theta, c)"),
        ("c * dahl(theta, tau_rigid)", "tau_rigid"),
    ],
)
def test_other_texts_are_refused_with_the_place(text, pointed):
    with pytest.raises(ExpressionError) as caught:
        check_effect(replace(GOOD, torque=text))
    shown, carets = caught.value.where.split("\n")
    assert shown[carets.index("^") : carets.rindex("^") + 1] == pointed


@pytest.mark.parametrize(
    ("text", "unit"),
    [
        ("c * tau_model", "1"),
        ("delay(tau_model, c) - tau_model", "s"),
        ("ddt(ddt(tau_model)) * c", "s²"),
        ("c * tau_model1", "1"),
    ],
)
def test_a_transform_is_linear_in_the_models_torque(text, unit):
    check_effect(Effect(id="lag", explains="", torque=text, shape={"c": Shape(unit, 0.1, 0.2)}))


@pytest.mark.parametrize("text", ["c * tau_model**2", "abs(tau_model) * c", "c * theta", "c * tau_rigid"])
def test_without_coefficients_anything_else_is_refused(text):
    with pytest.raises(ExpressionError):
        check_effect(Effect(id="lag", explains="", torque=text, shape={"c": Shape("s", 0.1, 0.2)}))


BOTH = {"hip": "c * theta1", "knee": "c * theta2"}


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"id": "Brake!"}, "is not an effect's id"),
        ({"id": ""}, "is not an effect's id"),
        ({"joints": ("an kle",)}, "joints are"),
        ({"joints": ()}, "joints are"),
        ({"joints": ("hip", "hip")}, "joints are"),
        ({"joints": ("hip", "both")}, "joints are"),
        ({"torque": None}, "this has no torque"),
        ({"derive": lambda mechanism, symbols: mechanism}, "either a torque text or derive"),
        ({"torque": BOTH}, "one text per joint"),
        ({"joints": ("both",)}, "does not fit its joints"),
        ({"joints": ("both",), "torque": {"hip": "c", "ankle": "c"}}, "ankle"),
        ({"coefficients": {}}, "nothing to identify"),
        ({"coefficients": {**C, "d": C["c"]}}, "d is declared but does not appear"),
        ({"coefficients": {**C, "theta": C["c"]}}, "already means something else"),
        ({"coefficients": {**C, "play": C["c"]}}, "already means something else"),
        ({"coefficients": {**C, "ｄ": C["c"]}}, "is not a name"),
        ({"coefficients": {**C, "_d": C["c"]}}, "is not a name"),
        ({"shape": {"c": Shape("s", 0.0, 1.0)}}, "as a coefficient and as a shape"),
        ({"coefficients": {"c": Coefficient(" ")}}, "unit is missing"),
        ({"coefficients": {"c": Coefficient("N·m", min=2.0, max=1.0)}}, "not below max"),
        ({"coefficients": {"c": Coefficient("N·m", min=0.0, typical=-1.0)}}, "outside its bounds"),
        ({"coefficients": {"c": Coefficient("N·m", min=float("nan"))}}, "not below max"),
    ],
)
def test_a_contradiction_is_named(changes, message):
    with pytest.raises(EffectError, match=message):
        check_effect(replace(GOOD, **changes))


@pytest.mark.parametrize(
    ("shape", "message"),
    [
        (Shape("s", 0.0, float("inf")), "bounds are"),
        (Shape("s", 1.0, 1.0), "not below max"),
        (Shape("s", 0.0, 1.0, choices=(0.0, 2.0)), "within the bounds"),
        (Shape("s", 0.0, 1.0, spacing="log"), "spacing 'log' from 0"),
        (Shape("s", 0.0, 1.0, spacing="cubic"), "spacing 'cubic'"),
        (Shape("s", 0.0, 1.0, points=0), "0 trial points"),
        (Shape("s", 0.0, 1.0, typical=2.0), "outside its bounds"),
        (Shape("", 0.0, 1.0), "unit is missing"),
    ],
)
def test_a_shape_without_sense_is_named(shape, message):
    with pytest.raises(EffectError, match=message):
        check_effect(replace(GOOD, torque="c * sgn(dtheta) * exp(-t / w)", shape={"w": shape}))


def test_an_effect_on_both_joints_does_not_know_an_own_joint():
    with pytest.raises(ExpressionError, match=r"unknown name 'theta'(.|\n)*did you mean"):
        check_effect(replace(GOOD, joints=("both",), torque={"hip": "c * theta", "knee": "c * theta2"}))


def test_a_change_of_the_mechanism_needs_no_text():
    check_effect(replace(GOOD, torque=None, derive=lambda mechanism, symbols: mechanism))


def effect(text, units=(), shape=()):
    coefficients = {key: Coefficient(unit) for key, unit in dict(units).items()}
    shapes = {key: Shape(unit, 0.1, 1.0) for key, unit in dict(shape).items()}
    return Effect(id="own", explains="", torque=text, coefficients=coefficients, shape=shapes)


@pytest.mark.parametrize(
    ("text", "units", "shape"),
    [
        ("c * dtheta", {"c": "N·m·s/rad"}, {}),
        ("c * dtheta", {"c": "Nm s/rad"}, {}),
        ("c * dtheta", {"c": "N*m/(rad/s)"}, {}),
        ("c * ddtheta", {"c": "kg·m²"}, {}),
        ("c * ddtheta", {"c": "kg m^2"}, {}),
        ("k * theta + c * dtheta", {"k": "N·m/rad", "c": "N·m·s/rad"}, {}),
        ("c * sqrt(abs(dtheta)) * sgn(dtheta)", {"c": "N·m·(s/rad)^0.5"}, {}),
        ("c * sqrt(dtheta**2 + 0.01)", {"c": "N·m·s/rad"}, {}),
        ("c * tanh(dtheta / 0.05)", {"c": "N·m"}, {}),
        ("c * max(dtheta, 0.1)", {"c": "N·m·s"}, {}),
        ("c * min(0, theta - a)", {"c": "N·m/rad"}, {"a": "rad"}),
        ("c * exp(-t / T) * sin(2 * pi * f * t)", {"c": "N·m"}, {"T": "s", "f": "Hz"}),
        ("c * dahl(theta, s) + d * play(theta, h)", {"c": "N·m", "d": "N·m"}, {"s": "1/rad", "h": "rad"}),
        ("c * abs(tau_rigid) * sgn(dtheta)", {"c": "1"}, {}),
    ],
)
def test_units_that_fit_pass(text, units, shape):
    effect(text, units, shape)


@pytest.mark.parametrize(
    ("text", "units", "shape", "message", "pointed"),
    [
        ("c * dtheta", {"c": "N·m"}, {}, "comes out in N·m/s, not in N·m", "c * dtheta"),
        ("c * dtheta", {"c": "N·m"}, {}, "give c the unit N·m·s", "c * dtheta"),
        ("k * theta + c * dtheta", {"k": "N·m/rad", "c": "N·m"}, {}, "N·m/s", "c * dtheta"),
        ("c * theta", {"c": "N"}, {}, "comes out in N, not", "c * theta"),
        ("c * exp(-t)", {"c": "N·m"}, {}, r"exp\(\) of a quantity in s", "-t"),
        ("c * sin(dtheta / w)", {"c": "N·m"}, {"w": "rad"}, r"sin\(\) of a quantity in 1/s", "dtheta / w"),
        ("c * (theta + dtheta)", {"c": "N·m"}, {}, "1 and 1/s are added", "theta + dtheta"),
        ("c * play(theta, h)", {"c": "N·m"}, {"h": "s"}, r"play\(\) wants 1 here", "h"),
        ("delay(tau_model, d) - tau_model", {}, {"d": "rad"}, r"delay\(\) wants s", "d"),
    ],
)
def test_units_that_do_not_fit_are_refused_with_the_place(text, units, shape, message, pointed):
    with pytest.raises(ExpressionError, match=message) as caught:
        effect(text, units, shape)
    shown, carets = caught.value.where.split("\n")
    assert shown[carets.index("^") : carets.rindex("^") + 1] == pointed


@pytest.mark.parametrize(
    ("unit", "message"),
    [
        ("deg", "use rad"),
        ("N·mm", "use m,"),
        ("rpm", "use rad/s"),
        ("in", "use m"),
        ("kN", "use N"),
        ("mV", "did you mean"),
        ("mNm", "use N·m"),
        ("%", "use 1"),
        ("N·mm/", "use m,"),
        ("N·m/", "is not a unit"),
        ("N·m)", "is not a unit"),
        ("(" * 20 + "m" + ")" * 20, "is not a unit"),
        ("m^999", "is not a unit"),
        ("m^(1/0)", "is not a unit"),
        ("Newton", "unknown unit 'Newton'"),
        ("m" * 100, "100 characters"),
    ],
)
def test_a_unit_that_is_none_is_named(unit, message):
    with pytest.raises(EffectError, match=message):
        effect("c", {"c": unit})


def test_model_and_notebook_refuse_what_the_file_refuses():
    with pytest.raises(EffectError, match="not below max"):
        Effect("own", "", "c * exp(-t / w)", coefficients=C, shape={"w": Shape("s", 2.0, 1.0)})
    with pytest.raises(EffectError, match="unit is missing"):
        Effect("own", "", "c * sgn(dtheta)", coefficients={"c": Coefficient("")})
    with pytest.raises(EffectError, match="t already means something else"):
        Effect("own", "", "t * sgn(dtheta)", coefficients={"t": Coefficient("N·m")})
