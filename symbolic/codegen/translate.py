"""SymPy expression -> CasADi expression, by walking the tree; no text is generated and nothing is executed.

Shared subexpressions are translated once, and CasADi merges what is equal afterwards.
"""

from __future__ import annotations

import operator
from collections.abc import Callable, Mapping, Sequence
from functools import reduce
from typing import Any

from symbolic.language.lower import power


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


def _is_half(exponent: Any) -> bool:
    return bool(exponent.is_constant() and float(exponent) == 0.5)
