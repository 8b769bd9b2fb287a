"""Equations written out: as plain text, as LaTeX, and as Python for SymPy or CasADi."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from functools import cache
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from exoid.ground.text import in_comment
from exoid.symbolic.equations import EquationError, Equations

if TYPE_CHECKING:
    from sympy import Expr, Matrix, Symbol

DOTS = {"ddtheta": r"\ddot{\theta}", "dtheta": r"\dot{\theta}", "theta": r"\theta"}


def equations_text(found: Equations, format: str = "text") -> str:
    """Return the equations as "text", "latex", "sympy" or "casadi"; the last two are Python to be run without
    exoid. EquationError for any other format.
    """
    if format not in FORMATS:
        raise EquationError(f"there is no format {format!r}", remedy=f"one of: {', '.join(FORMATS)}")
    return FORMATS[format](found)


def _text(found: Equations) -> str:
    """Write every entry that is not zero on a line of its own."""
    model = found.model
    lines = [
        f"{in_comment(model.name)}: M θ'' + C θ' + G + effects = τ + Jᵀ F, and the left side is Y Φ",
        "joints: " + ", ".join(f"{k + 1} {name}" for k, name in enumerate(model.joint_names)),
        "theta, dtheta, ddtheta: angles, velocities, accelerations; reach: a point down the last link, m",
    ]
    if not model.chain:
        lines.append(f"a_th = {model.thigh_length:g} m, g = {model.gravity:g} m/s²")
    for name, matrix in found.matrices.items():
        lines += ["", *matrix_lines(name, matrix)]
    lines += ["", "Φ, one for each column of Y"]
    lines += [f"  {k + 1:>2}  {_meaning(found, k)}" for k in range(len(model.parameters))]
    if model.shapes:
        lines += ["", "numbers the torque is not linear in"]
        lines += [f"      {s.name} [{s.shape.unit}]: {s.shape.explains or 'shape'}" for s in model.shapes]
    for name, torque in found.added.items():
        lines += ["", f"{name} has no column; it adds to the torque"]
        lines += [f"  [{j + 1}] {entry}" for j, entry in enumerate(torque) if entry != 0]
    for symbol, (operator, argument, parameter) in found.memories.items():
        more = "" if parameter is None else f", {parameter}"
        lines += ["", f"{symbol} = {operator}({argument}{more}), which depends on the past"]
    return "\n".join(lines) + "\n"


def matrix_lines(name: str, matrix: Matrix) -> list[str]:
    """Return every entry of a matrix that is not zero on a line of its own, below its name."""
    lines = [f"{name} ({matrix.rows} x {matrix.cols}), every other entry is 0" if 0 in matrix else name]
    for i in range(matrix.rows):
        for j in range(matrix.cols):
            place = f"{name}[{i + 1}]" if matrix.cols == 1 else f"{name}[{i + 1},{j + 1}]"
            lines += [f"  {place} = {matrix[i, j]}"] if matrix[i, j] != 0 else []
    return lines


def _meaning(found: Equations, k: int) -> str:
    parameter = found.parameters[k]
    made = found.base.get(parameter.name)
    return f"{parameter.name} [{parameter.unit}]" + (f": {parameter.label}" if made is None else f" = {made}")


def _latex(found: Equations) -> str:
    """Write displayed equations for a document with amsmath."""
    from sympy import latex

    made_of = {symbol for made in found.base.values() for symbol in made.free_symbols}
    names = {symbol: _latex_name(symbol.name) for symbol in (*found.symbols, *found.memories, *made_of)}

    def write(expression: Any) -> str:
        return str(latex(expression, symbol_names=names, mat_delim="[", mat_str="matrix"))

    pieces = [f"{name} = {write(matrix)}" for name, matrix in found.matrices.items()]
    columns = r" & ".join(_latex_name(p.name) for p in found.parameters)
    pieces.append(rf"\Phi = \begin{{bmatrix}} {columns} \end{{bmatrix}}^{{\mathsf T}}")
    pieces += [f"{_latex_name(name)} = {write(made)}" for name, made in found.base.items()]
    pieces += [rf"\tau_{{{_latex_name(name)}}} = {write(torque)}" for name, torque in found.added.items()]
    for symbol, (operator, argument, parameter) in found.memories.items():
        more = "" if parameter is None else f", {write(parameter)}"
        pieces.append(rf"{names[symbol]} = \operatorname{{{operator}}}\left({write(argument)}{more}\right)")
    return "".join(f"\\[\n{piece}\n\\]\n" for piece in pieces)


def _latex_name(name: str) -> str:
    """Return a symbol as it is set: dtheta1 as a dotted θ with an index, long names upright."""
    read = re.fullmatch(r"(ddtheta|dtheta|theta|Phi|memory)(\d+)", name)
    if read and read[1] != "memory":
        return f"{DOTS.get(read[1], chr(92) + 'Phi')}_{{{read[2]}}}"
    if re.fullmatch(r"[a-zA-Z]", name):
        return name
    if short := re.fullmatch(r"([a-zA-Z])_([a-z]+)", name):
        return rf"{short[1]}_{{\mathrm{{{short[2]}}}}}"
    return rf"\mathrm{{{name.replace('_', chr(92) + '_')}}}"


def _sympy(found: Equations) -> str:
    from sympy import sstr

    names = _identifiers(found)
    symbols = "\n".join(f'{own} = Symbol("{symbol.name}", real=True)' for symbol, own in names.items())
    return _python(
        found,
        "from sympy import Abs, Function, Matrix, Max, Min, Symbol, cos, exp, log, sign, sin, sqrt, tan, tanh\n",
        symbols,
        lambda expression: str(sstr(expression)),
        lambda rows: "Matrix([\n" + "".join(f"    [{', '.join(row)}],\n" for row in rows) + "])",
        lambda word, arguments: f'Function("{word}")({", ".join(arguments)})',
    )


def _casadi(found: Equations) -> str:
    names = _identifiers(found) | {symbol: symbol.name for symbol in found.memories}
    symbols = "\n".join(f'{own} = ca.SX.sym("{own}")' for own in names.values())
    return _python(
        found,
        "import casadi as ca\n",
        symbols,
        lambda expression: str(_printer().doprint(expression)),
        lambda rows: "ca.vertcat(\n" + "".join(f"    ca.horzcat({', '.join(row)}),\n" for row in rows) + ")",
        lambda word, arguments: f'("{word}", {", ".join(arguments)})',
        "_feeds",
    )


def _python(
    found: Equations, head: str, symbols: str, write: Callable[[Expr], str], matrix: Callable[[list[list[str]]], str],
    call: Callable[[str, list[str]], str], suffix: str = "",
) -> str:  # fmt: skip
    """Return a Python module that defines M, C, G, J, Y and Phi."""
    names = _identifiers(found)

    def plainly(expression: Expr) -> str:
        return write(expression.xreplace(_renamed(names)))

    def rows(of: Matrix) -> list[list[str]]:
        return [[plainly(entry) for entry in of.row(i)] for i in range(of.rows)]

    lines = [f'"""{in_comment(found.model.name)}: M, C, G, J of the rigid machine and Y of all of it."""', "", head]
    lines.append(symbols)
    for symbol, (operator, argument, parameter) in found.memories.items():
        given = [plainly(argument)] + ([] if parameter is None else [plainly(parameter)])
        lines.append(f"{symbol.name}{suffix} = {call(operator, given)}")
    lines += [f"{name} = {matrix(rows(one))}" for name, one in found.matrices.items()]
    comments = "".join(f"#   {in_comment(_meaning(found, k))}\n" for k in range(len(found.parameters)))
    lines.append("# The columns of Y belong to\n" + comments.rstrip())
    for name, torque in found.added.items():
        lines.append(f"# {name} has no column; it adds to the torque\nadded_{_word(name)} = {matrix(rows(torque))}")
    return "\n".join(lines) + "\n"


def _word(name: str) -> str:
    return re.sub(r"\W", "_", name)


def _identifiers(found: Equations) -> dict[Symbol, str]:
    """Return {symbol: a name that Python takes}."""
    return {symbol: _word(symbol.name) for symbol in found.symbols}


def _renamed(names: Mapping[Symbol, str]) -> dict[Symbol, Symbol]:
    from sympy import Symbol

    return {symbol: Symbol(own, real=True) for symbol, own in names.items()}


@cache
def _printer() -> Any:
    """Return what writes a SymPy expression in CasADi's words."""
    from sympy.printing.str import StrPrinter

    words = {"Abs": "fabs", "sign": "sign"}

    class CasadiPrinter(StrPrinter):
        def _print_Function(self, expr: Any) -> str:
            word = expr.func.__name__
            return f"ca.{words.get(word, word)}({self.stringify(expr.args, ', ')})"

        _print_Abs = _print_sign = _print_Function

        def _print_Max(self, expr: Any) -> str:
            return self._folded("ca.fmax", expr.args)

        def _print_Min(self, expr: Any) -> str:
            return self._folded("ca.fmin", expr.args)

        def _print_Pow(self, expr: Any, rational: bool = False) -> str:
            return str(super()._print_Pow(expr, rational)).replace("sqrt(", "ca.sqrt(")

        def _folded(self, word: str, parts: Any) -> str:
            text = self._print(parts[0])
            for part in parts[1:]:
                text = f"{word}({text}, {self._print(part)})"
            return str(text)

    return CasadiPrinter()


FORMATS: Mapping[str, Callable[[Equations], str]] = MappingProxyType(
    {"text": _text, "latex": _latex, "sympy": _sympy, "casadi": _casadi}
)
"""Name of a format -> what writes it."""
