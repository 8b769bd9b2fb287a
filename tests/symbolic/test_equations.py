"""Equations to read: they are those that are computed, in every format, and what is no model is told in words."""

import runpy

import casadi
import numpy as np
import pytest
import sympy

import exoid
from exoid.symbolic.codegen.kernel import compiled
from exoid.symbolic.joints import Joint
from exoid.symbolic.model_equations import EquationError
from exoid.symbolic.motion import Motion
from exoid.symbolic.writing_equations import FORMATS

LEG = exoid.Model.standard(thigh_length=0.43)
CHAIN = exoid.Model(
    "machine", limits={}, joints=(Joint("hip", length=0.42), Joint("knee", length=0.4), Joint("slide", "prismatic"))
)
MODELS = {
    "leg": LEG,
    "effects": LEG.with_effect("stribeck:knee").with_effect("load_friction:hip").with_effect("gravity_tilt"),
    "past": LEG.with_effect("backlash:knee").with_effect("time_delay:hip"),
    "chain": CHAIN.with_effect("rotor_inertia:knee").with_effect("viscous_cubic:slide"),
}


@pytest.fixture(params=MODELS.values(), ids=MODELS)
def model(request):
    return request.param


def state(model):
    """One instant: its motion, the numbers of the model, and the value of every symbol by its name."""
    rng, count = np.random.default_rng(3), len(model.joints)
    at = Motion(np.zeros(1), *(rng.normal(size=(1, count)) for _ in range(3)))
    linear, shape = rng.uniform(0.2, 1.0, len(model.parameters)), model.typical_shape
    values = {"t": 0.0, "a_th": model.thigh_length, "g": model.gravity, "reach": 0.3}
    for stem, row in (("theta", at.q), ("dtheta", at.dq), ("ddtheta", at.ddq)):
        values |= {f"{stem}{k + 1}": value for k, value in enumerate(row[0])}
    values |= {p.name: value for p, value in zip(model.parameters, linear, strict=True)}
    values |= {s.name: value for s, value in zip(model.shapes, shape, strict=True)}
    values |= {f"memory{k + 1}": 0.1 + k for k in range(4)}
    return at, linear, shape, values


def evaluated(matrix, values):
    symbols = sorted(matrix.free_symbols, key=str)
    function = sympy.lambdify(symbols, matrix, "numpy")
    return np.asarray(function(*(values[symbol.name] for symbol in symbols)), dtype=float)


@pytest.mark.slow
def test_they_are_those_that_are_computed(model):
    found = exoid.equations(model)
    at, linear, shape, values = state(model)
    code, memory = compiled(model), np.array([[values[str(s)] for s in found.memories]])
    wanted = code.mass_matrix(at, linear, shape)[0], code.coriolis(at, linear, shape)[0]
    np.testing.assert_allclose(evaluated(found.M, values), wanted[0], atol=1e-12)
    np.testing.assert_allclose(evaluated(found.C, values), wanted[1], atol=1e-12)
    np.testing.assert_allclose(evaluated(found.G, values)[:, 0], code.gravity(at, linear, shape)[0], atol=1e-12)
    if not memory.size:
        torque = evaluated(found.Y, values) @ linear + sum(evaluated(one, values)[:, 0] for one in found.added.values())
        np.testing.assert_allclose(torque, code.inverse_dynamics(at, linear, shape)[0], atol=1e-12)


@pytest.mark.slow
def test_python_for_sympy_and_casadi_says_the_same(model, tmp_path):
    found = exoid.equations(model)
    values = state(model)[-1]
    values |= {name.replace(":", "_").replace(".", "_"): value for name, value in values.items()}
    made = {}
    for form in ("sympy", "casadi"):
        (tmp_path / f"{form}.py").write_text(found.text(form), encoding="utf-8")
        made[form] = runpy.run_path(str(tmp_path / f"{form}.py"))
    for name, matrix in found.matrices.items():
        again = made["sympy"][name]
        assert again.shape == matrix.shape
        expression = made["casadi"][name]
        inputs = casadi.symvar(expression)
        function = casadi.Function("f", [casadi.vertcat(casadi.SX(0, 1), *inputs)], [expression])
        numbers = np.asarray(function([values[str(symbol)] for symbol in inputs]))
        # Signals with a past are functions in SymPy; as numbers they are compared where there are none of them.
        if not found.memories:
            np.testing.assert_allclose(evaluated(again, values), numbers, atol=1e-12)


def test_base_parameters_come_with_what_they_are_made_of():
    text = exoid.equations(LEG).text()
    assert "Phi3 [kg·m²] = a_th*l_sh*m_sh" in text and "coulomb:knee [N·m]: Coulomb friction knee" in text
    assert "= J_knee" in exoid.equations(CHAIN).text()


@pytest.mark.parametrize("form", FORMATS)
def test_every_format_tells_of_signals_with_a_past(form):
    text = exoid.equations(MODELS["past"]).text(form)
    assert "play" in text and "delay" in text


def test_the_regressor_of_a_model_has_its_effects():
    model = MODELS["effects"]
    form = exoid.regressor(model)
    assert form.names == tuple(p.name for p in model.parameters)
    assert form.matrix.shape == (2, len(form.names)) == (2, len(form.parameters))
    assert exoid.regressor(model.base()).matrix[:, :4] == exoid.regressor(model.base().mechanism).matrix


@pytest.mark.parametrize("verb", [exoid.regressor, exoid.equations])
@pytest.mark.parametrize("given", [None, "leg.toml", 3.0])
def test_what_is_no_model_is_told_in_words(verb, given):
    with pytest.raises(EquationError, match=f"was given {type(given).__name__}, which is no model"):
        verb(given)


def test_an_unknown_format_is_told_in_words():
    with pytest.raises(EquationError, match="no format 'word'"):
        exoid.equations(LEG).text("word")
