"""An effect that contradicts its own declaration is refused, and told where."""

from dataclasses import replace

import pytest

from ground.errors import EffectError, ExpressionError
from symbolic.effect import Coefficient, Effect, Shape
from symbolic.effect_declaration import check_effect

C = {"c": Coefficient("N·m", min=0.0)}
GOOD = Effect(id="brake", explains="", torque="c * sgn(dtheta)", coefficients=C)


@pytest.mark.parametrize(
    "text",
    [
        "c * theta",
        "-c / (1 + theta2**2)",
        "(c * theta + 2 * c) * 3 - c",
        "delay(c * theta, 0.1) + ddt(c * dtheta)",
        "c * play(theta, 0.1) * t * pi",
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
    "text", ["c * tau_model", "delay(tau_model, c) - tau_model", "ddt(ddt(tau_model)) * c", "c * tau_model1"]
)
def test_a_transform_is_linear_in_the_models_torque(text):
    check_effect(Effect(id="lag", explains="", torque=text, shape={"c": Shape("s", 0.1, 0.2)}))


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
        ({"joints": ("ankle",)}, "joints are"),
        ({"joints": ()}, "joints are"),
        ({"joints": ("hip", "hip")}, "joints are"),
        ({"joints": ("hip", "both")}, "joints are"),
        ({"torque": None}, "either a torque text or derive"),
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
