"""A torque tree in the languages that compute: NumPy, SymPy, CasADi. One walk, a table for each."""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any, cast

import numpy as np

from exoid.ground.errors import ExpressionError
from exoid.symbolic.language.operators import MEMORY
from exoid.symbolic.language.tree import CONSTANTS, FUNCTIONS, OPERATORS, Binary, Call, Name, Node
from exoid.symbolic.language.walk import NONE, Spelling, lower
from exoid.symbolic.language.writing import to_text
from exoid.symbolic.waves import FEW, are_even, sines

if TYPE_CHECKING:
    from exoid.symbolic.motion import Float

ARITHMETIC: Mapping[str, Callable[[Any, Any], Any]] = {
    "+": operator.add, "-": operator.sub, "*": operator.mul, "/": operator.truediv,
}  # fmt: skip

def _functions(library: Any, **called: str) -> Mapping[str, Callable[..., Any]]:
    """Functions of the language as `library` computes them; `called` are those it has under other names."""
    return {word: getattr(library, called.get(word, word)) for word in FUNCTIONS}


NUMPY = _functions(np, sgn="sign", max="maximum", min="minimum")


@dataclass(frozen=True, eq=False)
class _Given:
    """The values that a text is evaluated with: arguments as of `to_numpy`; what is `kept` stands at the step that
    makes it.
    """

    env: Mapping[str, Any]
    signs: Mapping[str, Any]
    kept: dict[Any, Any]


_Step = Callable[[_Given], Any]


def to_numpy(
    node: Node, env: Mapping[str, Any], signs: Mapping[str, Any] = NONE, kept: dict[Any, Any] | None = None
) -> Float:
    """Return the values (N,) of the torque, or a scalar where nothing in it varies.

    `env` maps names to signals (N,) or numbers, with the time stamps `t` (N,) in s for operators with
    memory; where shapes are columns (V, 1), one number for each of V trials, so are the values: (V, N).
    `signs` maps a velocity's name to its sign signal (N,). `kept` are the values of calls in texts evaluated with the
    same `env` and `signs` before; more are added. ExpressionError where a name has no value or the torque is not a
    finite number.
    """
    # What overflows or leaves its domain is found in the result, and reported with its place.
    with np.errstate(all="ignore"):
        values = np.asarray(_step(node)(_Given(env, signs, {} if kept is None else kept)), dtype=float)
        finite = np.isfinite(values.sum()) or np.isfinite(values).all()
    if not finite:
        sample = int(np.argmin(np.isfinite(np.atleast_1d(values))))
        what = f"the torque is not a finite number at sample {sample}"
        remedy = "keep log, sqrt, exp and / away from where they have no value, for example with max(...)"
        raise ExpressionError(what, where=to_text(node), remedy=remedy)
    return values


@lru_cache(maxsize=4096)
def _step(node: Node) -> _Step:
    """Function that computes a text again and again; a call is worth the same wherever it stands."""
    if not isinstance(node, Call):
        return cast(_Step, lower(node, _STEPS))
    function, arguments = NUMPY.get(node.function), [_step(argument) for argument in node.arguments]
    first = node.arguments[0]
    velocity = first.name if node.function == "sgn" and isinstance(first, Name) else ""

    def computed(given: _Given) -> Any:
        if found := _wave(node, given):
            given.kept.update({_step(replace(node, function=word)): values for word, values in found.items()})
            return found[node.function]
        values = [argument(given) for argument in arguments]
        return function(*values) if function else with_memory(node.function, known("t", given.env), *values)

    def step(given: _Given) -> Any:
        if velocity in given.signs:
            return given.signs[velocity]
        if step not in given.kept:
            given.kept[step] = computed(given)
        return given.kept[step]

    return step


def _wave(call: Call, given: _Given) -> dict[str, Float] | None:
    """Return sin(n x) and cos(n x) for evenly spaced trial values n; None for anything else."""
    argument = call.arguments[0]
    if call.function not in ("sin", "cos") or not isinstance(argument, Binary) or argument.operator != "*":
        return None
    numbers = np.asarray(given.env.get(argument.left.name) if isinstance(argument.left, Name) else None)
    if numbers.ndim != 2 or len(numbers) < FEW or not are_even(numbers[:, 0]):
        return None
    signal = np.asarray(_step(argument.right)(given))
    return sines(numbers[:, 0], signal) if signal.ndim == 1 else None


def _number(value: float) -> _Step:
    number = np.float64(value)
    return lambda given: number


def _of_two(function: Callable[[Any, Any], Any]) -> Callable[[_Step, _Step], _Step]:
    return lambda left, right: lambda given: function(left(given), right(given))


_STEPS = Spelling(
    number=_number,
    name=lambda name: lambda given: np.asarray(known(name, given.env), dtype=float),
    negative=lambda of: lambda given: -of(given),
    power=lambda base, exponent: lambda given: power(base(given), exponent, np.sqrt),
    binary={word: _of_two(function) for word, function in ARITHMETIC.items()},
    functions={**NUMPY, **MEMORY},
    shortcut=_step,
)


def to_sympy(node: Node, symbols: Mapping[str, Any], signs: Mapping[str, Any] = NONE) -> Any:
    """Return the SymPy expression; operators with memory become undefined functions of the same name."""
    import sympy

    table = Spelling(
        number=lambda value: sympy.Rational(value) if (2.0 * value).is_integer() else sympy.Float(value),
        name=lambda name: sympy.pi if name == "pi" and name not in symbols else known(name, symbols),
        negative=operator.neg,
        power=lambda base, exponent: base ** sympy.Rational(int(2 * exponent), 2),
        binary=ARITHMETIC,
        functions={
            **_functions(sympy, abs="Abs", sgn="sign", max="Max", min="Min"),
            **{word: sympy.Function(word, real=True) for word in OPERATORS},
        },
        signs=signs,
    )
    return lower(node, table)


def to_casadi(node: Node, symbols: Mapping[str, Any], signs: Mapping[str, Any] = NONE) -> Any:
    """Return the CasADi expression; ExpressionError for operators with memory (split_memory names them)."""
    import casadi

    table = Spelling(
        number=float,
        name=lambda name: known(name, symbols),
        negative=operator.neg,
        power=lambda base, exponent: power(base, exponent, casadi.sqrt),
        binary=ARITHMETIC,
        functions=_functions(casadi, abs="fabs", sgn="sign", max="fmax", min="fmin"),
        signs=signs,
    )
    return lower(node, table)


def known(name: str, env: Mapping[str, Any]) -> Any:
    """Value of a name; ExpressionError where it has no value."""
    if name in env:
        return env[name]
    if name in CONSTANTS:
        return CONSTANTS[name]
    what = f"{name!r} has no value here"
    raise ExpressionError(what, where=name, remedy="values are given for: " + ", ".join(sorted(env)))


def with_memory(word: str, t: Any, x: Any, *parameter: Any) -> Float:
    """Output of an operator with memory for `x`, a signal or a number, on the clock `t` (N,)."""
    clock = np.asarray(t, dtype=float)
    signal = np.broadcast_to(x, (*np.shape(x)[:-1], clock.size))
    return MEMORY[word](clock, signal, *(_constant(word, p) for p in parameter))


def _constant(word: str, parameter: Any) -> Float | float:
    """Return a number, or one (V, 1) for each of V trials."""
    value = np.asarray(parameter)
    if value.ndim and (value.ndim < 2 or value.shape[-1] > 1):
        what = f"the second argument of {word} varies with the motion"
        raise ExpressionError(what, where=word, remedy="give a number or a shape parameter")
    return value if value.ndim else float(value)


def power(base: Any, exponent: float, root: Callable[[Any], Any]) -> Any:
    """Power by multiplication: the same digits in every language, and exact signs for negative bases."""
    whole = int(abs(exponent))
    factors = [base] * whole + ([root(base)] if abs(exponent) != whole else [])
    if not factors:
        return base * 0.0 + 1.0
    product = factors[0]
    for factor in factors[1:]:
        product = product * factor
    return 1.0 / product if exponent < 0.0 else product
