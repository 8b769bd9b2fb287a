"""A CasADi function evaluated in many digits, one instruction at a time: for questions rounding must not answer."""

from __future__ import annotations

import operator
from collections.abc import Callable, Sequence
from typing import Any

from exoid.symbolic.codegen.instructions import ARITHMETIC, evaluated

DIGITS = 40


def evaluate_precisely(function: Any, inputs: Sequence[Any]) -> list[Any]:
    """Return the first output (n,) of an SX `function` at `inputs` (one sequence per argument) as mpmath numbers."""
    import mpmath  # type: ignore[import-untyped]

    with mpmath.workdps(DIGITS):
        exact = [[mpmath.mpf(float(value)) for value in part] for part in inputs]
        return evaluated(function, exact, _operations(mpmath), mpmath.mpf)[0]


def in_span(columns: Sequence[Sequence[Any]], column: Sequence[Any], tolerance: float) -> bool:
    """True if `column` (N,) is a combination of `columns` (n of (N,)), by orthogonalisation in many digits."""
    import mpmath

    with mpmath.workdps(DIGITS):
        basis: list[list[Any]] = []
        for item in columns:
            rest, size = _reduced(mpmath, basis, item)
            if size > tolerance:
                basis.append([value / size for value in rest])
        _, size = _reduced(mpmath, basis, column)
        return bool(size <= tolerance)


def _reduced(mpmath: Any, basis: list[list[Any]], column: Sequence[Any]) -> tuple[list[Any], Any]:
    """Return the unit column without its part in the basis, and the length of what remains."""
    length = mpmath.sqrt(mpmath.fsum(value**2 for value in column))
    rest = [value / length if length else value for value in column]
    for direction in basis:
        share = mpmath.fdot(direction, rest)
        rest = [value - share * unit for value, unit in zip(rest, direction, strict=True)]
    return rest, mpmath.sqrt(mpmath.fsum(value**2 for value in rest))


def _operations(mp: Any) -> dict[str, Callable[..., Any]]:
    return {
        **ARITHMETIC, "FABS": abs, "FMIN": min, "FMAX": max,
        **{name.upper(): getattr(mp, name) for name in ("sqrt", "exp", "log", "sin", "cos", "tan", "tanh", "sign")},
        **{
            name: lambda a, b, does=does: mp.mpf(bool(does(a, b)))
            for name, does in (("LT", operator.lt), ("LE", operator.le), ("EQ", operator.eq), ("NE", operator.ne))
        },
        "NOT": lambda a: mp.mpf(not a), "AND": lambda a, b: mp.mpf(bool(a) and bool(b)),
        "OR": lambda a, b: mp.mpf(bool(a) or bool(b)), "IF_ELSE_ZERO": lambda true, a: a if true else mp.mpf(0),
    }  # fmt: skip
