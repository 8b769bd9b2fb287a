"""Equations in SymPy, and written out: as plain text, as LaTeX, and as Python for SymPy or CasADi."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cache, cached_property
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

from exoid.ground.errors import ExoidError
from exoid.ground.text import in_comment
from exoid.symbolic.codegen.layout import BASE_STATE

if TYPE_CHECKING:
    from sympy import Expr, Matrix, Symbol

    from exoid.symbolic.model_structure import ModelStructure
    from exoid.symbolic.term import Parameter

DOTS = {"ddtheta": r"\ddot{\theta}", "dtheta": r"\dot{\theta}", "theta": r"\theta"}


class EquationError(ExoidError):
    """Equations that cannot be given: of what is no model, or in no known format."""


@dataclass(frozen=True, eq=False)
class Equations:
    """The equations of `model` in SymPy, for J joints and P linear parameters.

    `M`, `C` (J, J) and `G` (J, 1) are those of the rigid machine in its base parameters, `C` in Christoffel's form; `J`
    (2, J) leads from joint velocities to that of a point `reach` m down the last link. `Y` (J, P) has a column for each
    of `parameters`; `base` says what Φ1.. are made of. What has no column stands in `added`: {term: torque (J, 1)}.
    `memories` are signals with a past, {symbol: (operator, what feeds it, its parameter or None)}.
    """

    model: ModelStructure
    M: Matrix = field(repr=False)
    C: Matrix = field(repr=False)
    G: Matrix = field(repr=False)
    J: Matrix = field(repr=False)
    Y: Matrix = field(repr=False)
    base: Mapping[str, Expr] = field(repr=False)
    added: Mapping[str, Matrix] = field(repr=False)
    memories: Mapping[Symbol, tuple[str, Expr, Expr | None]] = field(repr=False)

    @property
    def parameters(self) -> tuple[Parameter, ...]:
        """The linear parameters (P,), in the order of the columns of `Y`."""
        return self.model.parameters

    @cached_property
    def symbols(self) -> tuple[Symbol, ...]:
        """Every symbol that the equations hold, motion first."""
        found: set[Symbol] = set()
        for item in (self.M, self.C, self.G, self.J, self.Y, *self.added.values()):
            found |= item.free_symbols
        for _, argument, parameter in self.memories.values():
            found |= argument.free_symbols | (set() if parameter is None else parameter.free_symbols)
        numbers = [p.name for p in self.model.parameters] + [s.name for s in self.model.shapes]
        stems = ("t", "theta", "dtheta", "ddtheta", *BASE_STATE, "a_th", "g", "reach")
        place = {name: k for k, name in enumerate(numbers, len(stems))}
        place |= {name: k for k, name in enumerate(stems)}

        def order(symbol: Symbol) -> tuple[int, str]:
            return place.get(symbol.name, place.get(symbol.name.rstrip("0123456789"), len(place))), symbol.name

        return tuple(sorted(found - set(self.memories), key=order))

    @property
    def matrices(self) -> Mapping[str, Matrix]:
        """{letter: matrix}, in the order in which they are read."""
        return {"M": self.M, "C": self.C, "G": self.G, "J": self.J, "Y": self.Y}

    def text(self, format: str = "text") -> str:
        """Return the equations as "text", "latex", "sympy" or "casadi"; the last two are Python to be run without
        exoid. EquationError for any other format.
        """
        if format not in FORMATS:
            raise EquationError(f"there is no format {format!r}", remedy=f"one of: {', '.join(FORMATS)}")
        return FORMATS[format](self)

    def _repr_latex_(self) -> str:
        return self.text("latex")

    def __str__(self) -> str:
        return self.text()


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
    lines += [f"{name} = {matrix(rows(item))}" for name, item in found.matrices.items()]
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
    """Printer of a SymPy expression in CasADi's words."""
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
