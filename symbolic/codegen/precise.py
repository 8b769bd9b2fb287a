"""A CasADi function evaluated in many digits, one instruction at a time: for questions rounding must not answer."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

DIGITS = 40


def evaluate_precisely(function: Any, inputs: Sequence[Any]) -> list[Any]:
    """Return the first output (n,) of an SX `function` at `inputs` (one sequence per argument) as mpmath numbers."""
    import casadi
    import mpmath  # type: ignore[import-untyped]

    with mpmath.workdps(DIGITS):
        table = _operations(casadi, mpmath)
        work: dict[int, Any] = {}
        result: list[Any] = [mpmath.mpf(0)] * function.nnz_out(0)
        for k in range(function.n_instructions()):
            operation, output = function.instruction_id(k), function.instruction_output(k)
            given = function.instruction_input(k)
            if operation == casadi.OP_CONST:
                work[output[0]] = mpmath.mpf(function.instruction_constant(k))
            elif operation == casadi.OP_INPUT:
                work[output[0]] = mpmath.mpf(float(inputs[given[0]][given[1]]))
            elif operation == casadi.OP_OUTPUT:
                result[output[1]] = work[given[0]]
            else:
                work[output[0]] = table[operation](*(work[place] for place in given))
        return result


def in_span(columns: Sequence[Sequence[Any]], column: Sequence[Any], tolerance: float) -> bool:
    """Return whether `column` (N,) is a combination of `columns` (n of (N,)), by orthogonalisation in many digits."""
    import mpmath

    with mpmath.workdps(DIGITS):
        basis: list[list[Any]] = []
        for one in columns:
            rest, size = _reduced(mpmath, basis, one)
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


def _operations(casadi: Any, mp: Any) -> dict[int, Callable[..., Any]]:
    return {
        casadi.OP_ASSIGN: lambda a: a,
        casadi.OP_ADD: lambda a, b: a + b,
        casadi.OP_SUB: lambda a, b: a - b,
        casadi.OP_MUL: lambda a, b: a * b,
        casadi.OP_DIV: lambda a, b: a / b,
        casadi.OP_NEG: lambda a: -a,
        casadi.OP_SQ: lambda a: a * a,
        casadi.OP_TWICE: lambda a: 2 * a,
        casadi.OP_INV: lambda a: 1 / a,
        casadi.OP_SQRT: mp.sqrt,
        casadi.OP_POW: lambda a, b: a**b,
        casadi.OP_CONSTPOW: lambda a, b: a**b,
        casadi.OP_EXP: mp.exp,
        casadi.OP_LOG: mp.log,
        casadi.OP_SIN: mp.sin,
        casadi.OP_COS: mp.cos,
        casadi.OP_TAN: mp.tan,
        casadi.OP_TANH: mp.tanh,
        casadi.OP_FABS: abs,
        casadi.OP_SIGN: mp.sign,
        casadi.OP_FMIN: min,
        casadi.OP_FMAX: max,
        casadi.OP_LT: lambda a, b: mp.mpf(a < b),
        casadi.OP_LE: lambda a, b: mp.mpf(a <= b),
        casadi.OP_EQ: lambda a, b: mp.mpf(a == b),
        casadi.OP_NE: lambda a, b: mp.mpf(a != b),
        casadi.OP_NOT: lambda a: mp.mpf(not a),
        casadi.OP_AND: lambda a, b: mp.mpf(bool(a) and bool(b)),
        casadi.OP_OR: lambda a, b: mp.mpf(bool(a) or bool(b)),
        casadi.OP_IF_ELSE_ZERO: lambda condition, a: a if condition else mp.mpf(0),
    }
