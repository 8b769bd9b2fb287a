"""Equations to read and to use elsewhere: M, C, G, J and Y in SymPy, and as text, LaTeX, SymPy or CasADi.

    M(θ) θ'' + C(θ, θ') θ' + G(θ) + effects = τ + J(θ)ᵀ F,      the left side is Y(θ, θ', θ'') Φ

They are read back from the very expressions that C is generated from, so what is printed is what is computed. The leg's
thigh length and gravity stay symbols; the lengths of other machines are numbers.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from exoid.ground.errors import ExoidError
from exoid.ground.lazy import LentMethod
from exoid.symbolic.codegen.equation import Expressions, model_expressions
from exoid.symbolic.codegen.layout import BASE_STATE
from exoid.symbolic.codegen.translate import sympy_from_casadi
from exoid.symbolic.language.torque import is_transform
from exoid.symbolic.mechanics.base_parameters import base_parameters
from exoid.symbolic.mechanics.mechanism import Mechanism, positive, real
from exoid.symbolic.mechanics.regressor import Regressor, derive_regressor
from exoid.symbolic.model import Model
from exoid.symbolic.term import Parameter

if TYPE_CHECKING:
    from sympy import Expr, Matrix, Symbol


class EquationError(ExoidError):
    """Equations that cannot be given: of what is no model, or in no known format."""


@dataclass(frozen=True, eq=False)
class Equations:
    """The equations of `model` in SymPy, for J joints and P linear parameters.

    `M`, `C` (J, J) and `G` (J, 1) are those of the rigid machine in its base parameters, `C` in Christoffel's form; `J`
    (2, J) leads from joint velocities to that of a point `reach` m down the last link. `Y` (J, P) has a column for each
    of `parameters`; `base` says what Φ1.. are made of. What has no column stands in `added`: {term: torque (J, 1)}.
    `memories` are signals with a past, {symbol: (operator, what feeds it, its parameter or None)}.
    """

    model: Model
    M: Matrix = field(repr=False)
    C: Matrix = field(repr=False)
    G: Matrix = field(repr=False)
    J: Matrix = field(repr=False)
    Y: Matrix = field(repr=False)
    base: Mapping[str, Expr] = field(repr=False)
    added: Mapping[str, Matrix] = field(repr=False)
    memories: Mapping[Symbol, tuple[str, Expr, Expr | None]] = field(repr=False)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The linear parameters (P,), in the order of the columns of `Y`."""
        return self.model.parameters

    @cached_property
    def symbols(self) -> tuple[Symbol, ...]:
        """Every symbol that the equations hold, motion first."""
        found: set[Symbol] = set()
        for one in (self.M, self.C, self.G, self.J, self.Y, *self.added.values()):
            found |= one.free_symbols
        for _, argument, parameter in self.memories.values():
            found |= argument.free_symbols | (set() if parameter is None else parameter.free_symbols)
        numbers = [p.name for p in self.model.parameters] + [s.name for s in self.model.shapes]
        stems = ("t", "theta", "dtheta", "ddtheta", *BASE_STATE, "a_th", "g", "reach")
        place = {name: k for k, name in enumerate(numbers, len(stems))}
        place |= {name: k for k, name in enumerate(stems)}

        def order(symbol: Symbol) -> tuple[int, str]:
            return place.get(symbol.name, place.get(symbol.name.rstrip("0123456789"), len(place))), symbol.name

        return tuple(sorted(found - set(self.memories), key=order))

    @property
    def matrices(self) -> Mapping[str, Matrix]:
        """{letter: matrix}, in the order in which they are read."""
        return {"M": self.M, "C": self.C, "G": self.G, "J": self.J, "Y": self.Y}

    text = LentMethod[str]("exoid.symbolic.writing_equations:equations_text")

    def _repr_latex_(self) -> str:
        return self.text("latex")

    def __str__(self) -> str:
        return self.text()


def equations(model: Model) -> Equations:
    """Return the equations of motion of `model`; EquationError where that is no model."""
    import casadi

    if not isinstance(model, Model):
        raise _no_model(model, "equations")
    sizes = {} if model.chain else {"a_th": casadi.SX.sym("a_th"), "g": casadi.SX.sym("g")}
    x = model_expressions(model, sizes)
    entries = casadi.SX.zeros(len(model.joints), len(model.parameters))
    for joint, parameter, entry in x.columns:
        entries[joint, parameter] += entry
    whole = {term.name: x.terms[term.name] for term in model.terms if is_transform(term)}
    fed = [one for memory in x.memories for one in (memory.argument, memory.parameter) if one is not None]
    M, C, G, J, Y, *rest = _read_back(model, x, sizes, [x.M, x.C, x.G, x.J, entries, *whole.values(), *fed])
    added = dict(zip(whole, rest, strict=False))
    arguments = iter(one[0] for one in rest[len(whole) :])
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


def regressor(of: Model | Mechanism) -> Regressor:
    """Return the regressor of a model, friction and effects included, or of a bare mechanism in symbols.

    `matrix` times `parameters`, which are named in `names`, and `known` make the torque; of a model `known` (J, 1) is
    what effects without a column add. EquationError where `of` is neither.
    """
    from sympy import zeros

    if isinstance(of, Mechanism):
        return derive_regressor(of)
    if not isinstance(of, Model):
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


def _read_back(model: Model, x: Expressions, sizes: Mapping[str, Any], wanted: list[Any]) -> list[Matrix]:
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
        (BASE_STATE if model.moving_base else (), x.base_motion),
        ([p.name for p in model.parameters], x.linear),
        ([s.name for s in model.shapes], x.shape),
        ([f"memory{k + 1}" for k in range(len(x.memories))], x.memory),
    ):
        names |= {name: real(name) for name in numbers}
        inputs |= {name: vector[k] for k, name in enumerate(numbers)}
    flat = sympy_from_casadi(wanted, list(inputs.values()), [names[name] for name in inputs])
    return [Matrix(*one.shape, [expand(entry) for entry in flat[k]]) for k, one in enumerate(wanted)]


def _base(model: Model) -> dict[str, Expr]:
    """Return {Phi1..: what it is made of}."""
    if not model.chain:
        form = derive_regressor(model.mechanism)
        return dict(zip(form.names, form.parameters, strict=True))
    from sympy import Float, Integer

    made = {}
    for parameter, found in zip(
        model.inertial, base_parameters(model.chain, model.gravity, model.moving_base), strict=True
    ):
        own = ((found.link, found.kind, 1.0), *found.parts)
        made[parameter.name] = sum(
            (Integer(int(f)) if f == int(f) else Float(f)) * real(f"{kind}_{model.chain[link].name}")
            for link, kind, f in own
        )
    return made
