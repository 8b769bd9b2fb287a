"""Equations to read and to use elsewhere: M, C, G, J and Y in SymPy, and as text, LaTeX, SymPy or CasADi.

    M(θ) θ'' + C(θ, θ') θ' + G(θ) + effects = τ + J(θ)ᵀ F,      the left side is Y(θ, θ', θ'') Φ

They are read back from the very expressions that C is generated from, so what is printed is what is computed. The leg's
thigh length and gravity stay symbols; the lengths of other machines are numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from exoid.symbolic.codegen.equation import Expressions, model_expressions
from exoid.symbolic.codegen.translate import sympy_from_casadi
from exoid.symbolic.language.torque import is_transform
from exoid.symbolic.mechanics.base_parameters import base_parameters
from exoid.symbolic.mechanics.mechanism import Mechanism, positive, real
from exoid.symbolic.mechanics.regressor import Regressor, derive_regressor
from exoid.symbolic.model_structure import ModelStructure
from exoid.symbolic.writing_equations import EquationError, Equations

if TYPE_CHECKING:
    from sympy import Expr, Matrix


def equations(model: ModelStructure) -> Equations:
    """Return the equations of motion of `model`; EquationError where that is no model."""
    import casadi

    if not isinstance(model, ModelStructure):
        raise _no_model(model, "equations")
    sizes = {} if model.chain else {"a_th": casadi.SX.sym("a_th"), "g": casadi.SX.sym("g")}
    x = model_expressions(model, sizes)
    entries = casadi.SX.zeros(len(model.joints), len(model.parameters))
    for joint, parameter, entry in x.columns:
        entries[joint, parameter] += entry
    whole = {term.name: x.terms[term.name] for term in model.terms if is_transform(term)}
    fed = [item for memory in x.memories for item in (memory.argument, memory.parameter) if item is not None]
    M, C, G, J, Y, *rest = _read_back(model, x, sizes, [x.M, x.C, x.G, x.J, entries, *whole.values(), *fed])
    added = dict(zip(whole, rest, strict=False))
    arguments = iter(element[0] for element in rest[len(whole) :])
    memories = {
        real(f"memory{k + 1}"): (
            memory.operator,
            next(arguments),
            None if memory.parameter is None else next(arguments),
        )
        for k, memory in enumerate(x.memories)
    }
    return Equations(
        model, M, C, G, J, Y, MappingProxyType(_base(model)), MappingProxyType(added), MappingProxyType(memories)
    )


def regressor(of: ModelStructure | Mechanism) -> Regressor:
    """Return the regressor of a model, friction and effects included, or of a bare mechanism in symbols.

    `matrix` times `parameters`, which are named in `names`, and `known` make the torque; of a model `known` (J, 1) is
    what effects without a column add. EquationError where `of` is neither.
    """
    from sympy import zeros

    if isinstance(of, Mechanism):
        return derive_regressor(of)
    if not isinstance(of, ModelStructure):
        raise _no_model(of, "regressor")
    found = equations(of)
    names = tuple(p.name for p in of.parameters)
    known = sum(found.added.values(), start=zeros(len(of.joints), 1))
    return Regressor(names, tuple(found.base.get(name, real(name)) for name in names), found.Y, known)


def _no_model(given: Any, verb: str) -> EquationError:
    return EquationError(
        f"{verb}() was given {type(given).__name__}, which is no model",
        remedy=f"give a model, such as {verb}(Model.standard()) or {verb}(read_model('leg.toml'))",
    )


def _read_back(model: ModelStructure, x: Expressions, sizes: Mapping[str, Any], wanted: list[Any]) -> list[Matrix]:
    """Return CasADi matrices as SymPy matrices, multiplied out."""
    from sympy import Matrix, expand, sign

    count = range(1, len(model.joints) + 1)
    names: dict[str, Any] = {"t": real("t"), **{name: positive(name) for name in (*sizes, "reach")}}
    inputs = {"t": x.t, **sizes, "reach": x.reach}
    for stem, vector in (("theta", x.q), ("dtheta", x.dq), ("ddtheta", x.ddq)):
        names |= {f"{stem}{k}": real(f"{stem}{k}") for k in count}
        inputs |= {f"{stem}{k}": vector[k - 1] for k in count}
    names |= {f"sign{k}": sign(real(f"dtheta{k}")) for k in count}
    inputs |= {f"sign{k}": x.sign[k - 1] for k in count}
    for numbers, vector in (
        (model.base_state, x.base_motion),
        ([p.name for p in model.parameters], x.linear),
        ([s.name for s in model.shapes], x.shape),
        ([f"memory{k + 1}" for k in range(len(x.memories))], x.memory),
    ):
        names |= {name: real(name) for name in numbers}
        inputs |= {name: vector[k] for k, name in enumerate(numbers)}
    flat = sympy_from_casadi(wanted, list(inputs.values()), [names[name] for name in inputs])
    return [Matrix(*item.shape, [expand(entry) for entry in flat[k]]) for k, item in enumerate(wanted)]


def _base(model: ModelStructure) -> dict[str, Expr]:
    """Return {Phi1..: what it is made of}."""
    if not model.chain:
        form = derive_regressor(model.mechanism)
        return dict(zip(form.names, form.parameters, strict=True))
    from sympy import Float, Integer

    made = {}
    for parameter, found in zip(
        model.inertial, base_parameters(model.chain, model.pull, model.moving_base), strict=True
    ):
        own = ((found.link, found.kind, 1.0), *found.parts)
        made[parameter.name] = sum(
            (Integer(int(f)) if f == int(f) else Float(f)) * real(f"{kind}_{model.chain[link].name}")
            for link, kind, f in own
        )
    return made
