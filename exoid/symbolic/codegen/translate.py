"""SymPy expression -> CasADi expression, and back; no text is generated and nothing is executed.

There by walking the tree: shared subexpressions are translated once, and CasADi merges what is equal afterwards. Back
by walking CasADi's list of instructions.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from typing import Any

from exoid.symbolic.codegen.instructions import ARITHMETIC, evaluated
from exoid.symbolic.language.lower import power


def casadi_from_sympy(expressions: Sequence[Any], symbols: Mapping[str, Any]) -> list[Any]:
    """Translate SymPy `expressions`; `symbols` maps each symbol name to its CasADi SX. KeyError names a
    missing one.
    """
    import casadi

    table = _functions(casadi)
    done: dict[Any, Any] = {}

    def walk(node: Any) -> Any:
        if node not in done:
            done[node] = visit(node)
        return done[node]

    def visit(node: Any) -> Any:
        if node.is_Symbol:
            return symbols[node.name]
        if node.is_number and not node.free_symbols:
            return casadi.SX(float(node))
        if node.is_Pow and node.exp.is_Integer and 0 < abs(int(node.exp)) <= 8:
            return power(walk(node.base), int(node.exp), casadi.sqrt)
        return table[type(node).__name__](*(walk(argument) for argument in node.args))

    return [casadi.SX(walk(expression)) for expression in expressions]


def _functions(casadi: Any) -> Mapping[str, Callable[..., Any]]:
    """CasADi's spelling of each SymPy function."""

    def fold(combine: Callable[[Any, Any], Any]) -> Callable[..., Any]:
        return lambda *parts: reduce(combine, parts)

    return {
        "Add": fold(operator.add),
        "Mul": fold(operator.mul),
        "Pow": lambda base, exponent: (
            casadi.sqrt(base) if exponent.is_constant() and float(exponent) == 0.5 else casadi.power(base, exponent)
        ),
        "Abs": casadi.fabs,
        "Max": fold(casadi.fmax),
        "Min": fold(casadi.fmin),
        **{name: getattr(casadi, name) for name in ("sin", "cos", "tan", "exp", "log", "tanh", "sign")},
    }


def sympy_from_casadi(wanted: Sequence[Any], inputs: Sequence[Any], values: Sequence[Any]) -> list[list[Any]]:
    """Return the entries of each CasADi SX in `wanted`, row by row, in SymPy; `values` stand for the SX `inputs`.

    KeyError where an operation has no form in SymPy.
    """
    import casadi

    flat = [casadi.densify(casadi.vec(casadi.SX(item).T)) for item in wanted]
    function = casadi.Function("expressions", list(inputs), flat, {"cse": False})
    return evaluated(function, [[value] for value in values], _back(), _number)


def _number(value: float) -> Any:
    """Return a SymPy number: halves exactly, others as they are."""
    import sympy

    return sympy.Rational(value) if (2.0 * value).is_integer() else sympy.Float(value)


def _back() -> Mapping[str, Callable[..., Any]]:
    """SymPy's spelling of each operation of CasADi."""
    import sympy

    names = ("sin", "cos", "tan", "exp", "log", "tanh", "sqrt", "sign")
    own = {"FABS": sympy.Abs, "FMIN": sympy.Min, "FMAX": sympy.Max}
    return {**ARITHMETIC, **own, **{name.upper(): getattr(sympy, name) for name in names}}
