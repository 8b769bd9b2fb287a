"""A torque tree in other languages: NumPy, SymPy, CasADi, LaTeX, plain text. One walk, a table for each."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from ground.errors import ExpressionError
from symbolic.language.tree import CONSTANTS, OPERATORS, Binary, Name, Node, Number, Unary

if TYPE_CHECKING:
    from symbolic.motion import Float

NONE: Mapping[str, Any] = {}


@dataclass(frozen=True)
class Table:
    """How one target language writes each kind of node.

    `signs` gives, for a velocity, what its sign is: near standstill a measured sign is more than
    sgn(velocity).
    """

    number: Callable[[float], Any]
    name: Callable[[str], Any]
    negative: Callable[[Any], Any]
    power: Callable[[Any, float], Any]
    binary: Mapping[str, Callable[[Any, Any], Any]]
    functions: Mapping[str, Callable[..., Any]]
    signs: Mapping[str, Any] = field(default_factory=lambda: NONE)


def lower(node: Node, table: Table) -> Any:
    """Translate a tree by a table; ExpressionError for a word the table does not have."""
    if isinstance(node, Number):
        return table.number(node.value)
    if isinstance(node, Name):
        return table.name(node.name)
    if isinstance(node, Unary):
        return table.negative(lower(node.operand, table))
    if isinstance(node, Binary):
        if node.operator == "**" and isinstance(node.right, Number):
            return table.power(lower(node.left, table), node.right.value)
        return table.binary[node.operator](lower(node.left, table), lower(node.right, table))
    if node.function == "sgn" and isinstance(node.arguments[0], Name) and node.arguments[0].name in table.signs:
        return table.signs[node.arguments[0].name]
    if node.function not in table.functions:
        raise ExpressionError(
            f"{node.function} needs a whole recording and cannot be written here",
            where=to_text(node),
            remedy="replace it by a named input (separate.py)",
        )
    return table.functions[node.function](*(lower(argument, table) for argument in node.arguments))


_ARITHMETIC: Mapping[str, Callable[[Any, Any], Any]] = {
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
}


def to_numpy(node: Node, env: Mapping[str, Any], signs: Mapping[str, Any] = NONE) -> Float:
    """Return the values (N,) of the torque, or a scalar where nothing in it varies.

    `env` maps names to signals (N,) or numbers, with the time stamps `t` (N,) in s for operators with
    memory; `signs` maps a velocity's name to its sign signal (N,). ExpressionError where a name has no
    value or the torque is not a finite number.
    """
    from symbolic.language.operators import MEMORY

    def remember(word: str) -> Callable[..., Any]:
        def apply(x: Any, *parameter: Any) -> Float:
            t = np.asarray(_known("t", env), dtype=float)
            return MEMORY[word](t, np.broadcast_to(x, t.shape), *(_scalar(word, p) for p in parameter))

        return apply

    table = Table(
        number=np.float64,
        name=lambda name: np.asarray(_known(name, env), dtype=float),
        negative=lambda a: -a,
        power=lambda base, exponent: _power(base, exponent, np.sqrt),
        binary=_ARITHMETIC,
        functions={
            "sin": np.sin,
            "cos": np.cos,
            "tan": np.tan,
            "exp": np.exp,
            "log": np.log,
            "sqrt": np.sqrt,
            "abs": np.abs,
            "sgn": np.sign,
            "tanh": np.tanh,
            "max": np.maximum,
            "min": np.minimum,
            **{word: remember(word) for word in OPERATORS},
        },
        signs=signs,
    )
    # What overflows or leaves its domain is found in the result, and reported with its place.
    with np.errstate(all="ignore"):
        values = np.asarray(lower(node, table), dtype=float)
    if not np.isfinite(values).all():
        sample = int(np.argmin(np.isfinite(np.atleast_1d(values))))
        raise ExpressionError(
            f"the torque is not a finite number at sample {sample}",
            where=to_text(node),
            remedy="keep log, sqrt, exp and / away from where they have no value, for example with max(...)",
        )
    return values


def to_sympy(node: Node, symbols: Mapping[str, Any], signs: Mapping[str, Any] = NONE) -> Any:
    """Return the SymPy expression; operators with memory become undefined functions of the same name."""
    import sympy

    table = Table(
        number=lambda value: sympy.Rational(value) if (2.0 * value).is_integer() else sympy.Float(value),
        name=lambda name: sympy.pi if name == "pi" and name not in symbols else _known(name, symbols),
        negative=lambda a: -a,
        power=lambda base, exponent: base ** sympy.Rational(int(2 * exponent), 2),
        binary=_ARITHMETIC,
        functions={
            "sin": sympy.sin,
            "cos": sympy.cos,
            "tan": sympy.tan,
            "exp": sympy.exp,
            "log": sympy.log,
            "sqrt": sympy.sqrt,
            "abs": sympy.Abs,
            "sgn": sympy.sign,
            "tanh": sympy.tanh,
            "max": sympy.Max,
            "min": sympy.Min,
            **{word: sympy.Function(word, real=True) for word in OPERATORS},
        },
        signs=signs,
    )
    return lower(node, table)


def to_casadi(node: Node, symbols: Mapping[str, Any], signs: Mapping[str, Any] = NONE) -> Any:
    """Return the CasADi expression; ExpressionError for operators with memory (separate.py names them)."""
    import casadi

    table = Table(
        number=float,
        name=lambda name: _known(name, symbols),
        negative=lambda a: -a,
        power=lambda base, exponent: _power(base, exponent, casadi.sqrt),
        binary=_ARITHMETIC,
        functions={
            "sin": casadi.sin,
            "cos": casadi.cos,
            "tan": casadi.tan,
            "exp": casadi.exp,
            "log": casadi.log,
            "sqrt": casadi.sqrt,
            "abs": casadi.fabs,
            "sgn": casadi.sign,
            "tanh": casadi.tanh,
            "max": casadi.fmax,
            "min": casadi.fmin,
        },
        signs=signs,
    )
    return lower(node, table)


def to_latex(node: Node) -> str:
    """Return the torque in LaTeX (the part of it that matplotlib understands too)."""
    from symbolic.language.writing import LATEX

    return str(lower(node, LATEX).text)


def to_text(node: Node) -> str:
    """Return the torque as plain text, with the fewest brackets; parsing it gives the same tree."""
    from symbolic.language.writing import TEXT

    return str(lower(node, TEXT).text)


def _known(name: str, env: Mapping[str, Any]) -> Any:
    if name in env:
        return env[name]
    if name in CONSTANTS:
        return CONSTANTS[name]
    raise ExpressionError(
        f"{name!r} has no value here", where=name, remedy="values are given for: " + ", ".join(sorted(env))
    )


def _scalar(word: str, parameter: Any) -> float:
    value = np.asarray(parameter)
    if value.ndim:
        raise ExpressionError(
            f"the second argument of {word} varies with the motion",
            where=word,
            remedy="give a number or a shape parameter",
        )
    return float(value)


def _power(base: Any, exponent: float, root: Callable[[Any], Any]) -> Any:
    """Power by multiplication: the same digits in every language, and exact signs for negative bases."""
    whole = int(abs(exponent))
    factors = [base] * whole + ([root(base)] if abs(exponent) != whole else [])
    if not factors:
        return base * 0.0 + 1.0
    product = factors[0]
    for factor in factors[1:]:
        product = product * factor
    return 1.0 / product if exponent < 0.0 else product
