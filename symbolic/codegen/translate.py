"""SymPy expression -> CasADi expression, by walking the tree; no text is generated and nothing is executed.

Shared subexpressions are translated once, and CasADi merges what is equal afterwards.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any


def casadi_from_sympy(expressions: Sequence[Any], symbols: Mapping[str, Any]) -> list[Any]:
    """Translate SymPy `expressions`; `symbols` maps each symbol name to its CasADi SX. KeyError names a
    missing one.
    """
    import casadi
    from sympy import Integer

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
        if node.is_Pow and node.exp == Integer(2):
            return _power(walk(node.base), 2)
        if node.is_Pow and node.exp.is_Integer and 0 < abs(int(node.exp)) <= 8:
            return _power(walk(node.base), int(node.exp))
        return table[type(node).__name__](*(walk(argument) for argument in node.args))

    return [casadi.SX(walk(expression)) for expression in expressions]


def _power(base: Any, exponent: int) -> Any:
    """Repeated multiplication: exact for negative bases, and cheaper than pow()."""
    product = base
    for _ in range(abs(exponent) - 1):
        product = product * base
    return product if exponent > 0 else 1 / product


def _functions(casadi: Any) -> Mapping[str, Callable[..., Any]]:
    """Return how each SymPy function is written in CasADi."""

    def fold(combine: Callable[[Any, Any], Any]) -> Callable[..., Any]:
        def apply(first: Any, *rest: Any) -> Any:
            for other in rest:
                first = combine(first, other)
            return first

        return apply

    return {
        "Add": fold(lambda a, b: a + b),
        "Mul": fold(lambda a, b: a * b),
        "Pow": lambda base, exponent: casadi.sqrt(base) if _is_half(exponent) else casadi.power(base, exponent),
        "sin": casadi.sin,
        "cos": casadi.cos,
        "tan": casadi.tan,
        "exp": casadi.exp,
        "log": casadi.log,
        "tanh": casadi.tanh,
        "Abs": casadi.fabs,
        "sign": casadi.sign,
        "Max": fold(casadi.fmax),
        "Min": fold(casadi.fmin),
    }


def _is_half(exponent: Any) -> bool:
    return bool(exponent.is_constant() and float(exponent) == 0.5)
