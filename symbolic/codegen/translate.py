"""SymPy expression -> CasADi expression, and back; no text is generated and nothing is executed.

There by walking the tree: shared subexpressions are translated once, and CasADi merges what is equal afterwards. Back
by walking CasADi's list of instructions.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from typing import Any

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
    """Return how each SymPy function is written in CasADi."""

    def fold(combine: Callable[[Any, Any], Any]) -> Callable[..., Any]:
        return lambda *parts: reduce(combine, parts)

    return {
        "Add": fold(operator.add),
        "Mul": fold(operator.mul),
        "Pow": lambda base, exponent: casadi.sqrt(base) if _is_half(exponent) else casadi.power(base, exponent),
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

    flat = [casadi.densify(casadi.vec(casadi.SX(one).T)) for one in wanted]
    function = casadi.Function("expressions", list(inputs), flat, {"cse": False})
    table = _back(casadi)
    held: dict[int, Any] = {}
    out: list[list[Any]] = [[0] * one.numel() for one in flat]
    for step in range(function.n_instructions()):
        operation = function.instruction_id(step)
        given, made = function.instruction_input(step), function.instruction_output(step)
        if operation == casadi.OP_OUTPUT:
            out[made[0]][made[1]] = held[given[0]]
        elif operation == casadi.OP_INPUT:
            held[made[0]] = values[given[0]]
        elif operation == casadi.OP_CONST:
            held[made[0]] = _number(float(function.instruction_constant(step)))
        else:
            held[made[0]] = table[operation](*(held[place] for place in given))
    return out


def _number(value: float) -> Any:
    """Return a SymPy number: halves exactly, others as they are."""
    import sympy

    return sympy.Rational(value) if (2.0 * value).is_integer() else sympy.Float(value)


def _back(casadi: Any) -> Mapping[int, Callable[..., Any]]:
    """Return how each operation of CasADi is written in SymPy."""
    import sympy

    return {
        casadi.OP_ASSIGN: lambda a: a, casadi.OP_ADD: operator.add, casadi.OP_SUB: operator.sub,
        casadi.OP_MUL: operator.mul, casadi.OP_DIV: operator.truediv, casadi.OP_NEG: operator.neg,
        casadi.OP_SQ: lambda a: a * a, casadi.OP_TWICE: lambda a: 2 * a, casadi.OP_INV: lambda a: 1 / a,
        casadi.OP_POW: operator.pow, casadi.OP_CONSTPOW: operator.pow, casadi.OP_FABS: sympy.Abs,
        casadi.OP_FMIN: sympy.Min, casadi.OP_FMAX: sympy.Max,
        **{
            getattr(casadi, f"OP_{name.upper()}"): getattr(sympy, name)
            for name in ("sin", "cos", "tan", "exp", "log", "tanh", "sqrt", "sign")
        },
    }  # fmt: skip


def _is_half(exponent: Any) -> bool:
    return bool(exponent.is_constant() and float(exponent) == 0.5)
