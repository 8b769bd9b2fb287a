"""CasADi function -> C statements on plain scalars, which a compiler can inline into a loop and vectorise.

CasADi's own C passes arrays and checks pointers; here its list of instructions is walked instead, through its
documented interface, so that no text has to be searched and replaced.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from types import MappingProxyType
from typing import Any

from exoid.symbolic.codegen.compiler import CompilerError

FORMS: Mapping[str, str] = MappingProxyType(
    {
        "ASSIGN": "{a}", "ADD": "{a} + {b}", "SUB": "{a} - {b}", "MUL": "{a} * {b}", "DIV": "{a} / {b}",
        "NEG": "-{a}", "SQ": "{a} * {a}", "TWICE": "{a} + {a}", "INV": "1.0 / {a}", "SQRT": "sqrt({a})",
        "SIN": "exoid_sin({a})", "COS": "exoid_sin({a} + 1.57079632679489661923)", "TAN": "tan({a})",
        "EXP": "exp({a})", "LOG": "log({a})", "POW": "pow({a}, {b})", "CONSTPOW": "pow({a}, {b})",
        "TANH": "tanh({a})", "FABS": "fabs({a})", "SIGN": "(double)(({a} > 0.0) - ({a} < 0.0))",
        "FMIN": "({a} < {b} ? {a} : {b})", "FMAX": "({a} > {b} ? {a} : {b})", "FLOOR": "floor({a})",
        "CEIL": "ceil({a})", "LT": "(double)({a} < {b})", "LE": "(double)({a} <= {b})",
        "EQ": "(double)({a} == {b})", "NE": "(double)({a} != {b})", "NOT": "(double)({a} == 0.0)",
        "AND": "(double)({a} != 0.0 && {b} != 0.0)", "OR": "(double)({a} != 0.0 || {b} != 0.0)",
        "IF_ELSE_ZERO": "({a} != 0.0 ? {b} : 0.0)",
    }
)  # fmt: skip
"""CasADi's operation -> C."""


@cache
def template(name: str) -> str:
    """Return a file of this folder that is C, with @KEY@ where `exoid.ground.text.filled` puts what a model needs."""
    return Path(__file__).with_name(name).read_text("utf-8")


@dataclass(frozen=True)
class Language:
    """Spelling of statements: `forms` of the operations, a `line` with {place} and {value}, and the indent."""

    forms: Mapping[str, str]
    line: str
    indent: str = "    "


VECTORISED = Language(FORMS, "const double {place} = {value};")
"""C in which loops over samples vectorise: the sine is our own."""
PLAIN = Language(
    MappingProxyType({**FORMS, "SIN": "sin({a})", "COS": "cos({a})"}), "const double {place} = {value};", "  "
)
"""C99 with nothing but math.h."""


@cache
def _names() -> Mapping[int, str]:
    import casadi

    return MappingProxyType({getattr(casadi, f"OP_{name}"): name for name in FORMS})


def scalar_c(function: Any, inputs: Sequence[Sequence[str]], store: str, language: Language = VECTORISED) -> str:
    """Return statements that compute an SX `function`; `inputs` are the expressions of its arguments' entries.

    `store` is a format for what happens to an output, with {k} its place and {value}. CompilerError where the function
    holds an operation that is not known here.
    """
    import casadi

    names = _names()
    held: dict[int, str] = {}
    lines: list[str] = []
    for step in range(function.n_instructions()):
        operation = function.instruction_id(step)
        given, made = function.instruction_input(step), function.instruction_output(step)
        if operation == casadi.OP_OUTPUT:
            lines.append(store.format(k=made[1], value=held[given[0]]))
            continue
        if operation == casadi.OP_INPUT:
            held[made[0]] = inputs[given[0]][given[1]]
            continue
        if operation == casadi.OP_CONST:
            constant = float(function.instruction_constant(step))
            if not math.isfinite(constant):
                raise CompilerError(f"a number became {constant!r}, which has no literal in C")
            held[made[0]] = f"({constant!r})"
            continue
        if operation not in names:
            raise CompilerError(f"CasADi's operation {operation} has no scalar form")
        arguments = dict(zip("ab", (held[place] for place in given), strict=False))
        value = language.forms[names[operation]].format(**arguments)
        lines.append(language.line.format(place=f"v{step}", value=value))
        held[made[0]] = f"v{step}"
    return "\n".join(f"{language.indent}{line}" for line in lines)


ARITHMETIC: Mapping[str, Callable[..., Any]] = MappingProxyType(
    {
        "ASSIGN": lambda a: a, "ADD": operator.add, "SUB": operator.sub, "MUL": operator.mul, "DIV": operator.truediv,
        "NEG": operator.neg, "SQ": lambda a: a * a, "TWICE": lambda a: 2 * a, "INV": lambda a: 1 / a,
        "POW": operator.pow, "CONSTPOW": operator.pow,
    }
)  # fmt: skip
"""CasADi's operation in any kind of number that Python can reckon with."""


def evaluated(
    function: Any, inputs: Sequence[Any], operations: Mapping[str, Callable[..., Any]], number: Callable[[float], Any]
) -> list[list[Any]]:
    """Return the entries of every output of an SX `function` at `inputs`, one sequence for each argument, in the kind
    of number that `operations`, by CasADi's names, and `number` make. KeyError for an operation that is not there.
    """
    import casadi

    known = {getattr(casadi, f"OP_{name}"): does for name, does in operations.items()}
    held: dict[int, Any] = {}
    out: list[list[Any]] = [[number(0.0)] * function.nnz_out(k) for k in range(function.n_out())]
    for step in range(function.n_instructions()):
        operation = function.instruction_id(step)
        given, made = function.instruction_input(step), function.instruction_output(step)
        if operation == casadi.OP_OUTPUT:
            out[made[0]][made[1]] = held[given[0]]
        elif operation == casadi.OP_INPUT:
            held[made[0]] = inputs[given[0]][given[1]]
        elif operation == casadi.OP_CONST:
            held[made[0]] = number(float(function.instruction_constant(step)))
        else:
            held[made[0]] = known[operation](*(held[place] for place in given))
    return out
