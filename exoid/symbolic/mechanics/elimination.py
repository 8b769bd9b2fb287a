"""Base parameters by elimination: which combinations of masses and lengths a motion can show, and no others.

The torque is a sum of (known coefficient) × (function of the motion) × (monomial of unknown inertial
quantities). Each function is a row over the monomials; rows that depend on earlier ones bring nothing new.
The rows that remain are the base parameters. Source: Gautier, Khalil, IEEE Trans. Robotics and Automation
6(3), 1990, done here symbolically.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from sympy import Expr, Matrix, Symbol

    from exoid.symbolic.mechanics.mechanism import Mechanism

Row = dict["Expr", "Expr"]
"""One function of the motion: coefficient of every monomial of the unknowns."""


@dataclass(frozen=True, eq=False)
class Base:
    """`parameters` (P,) in terms of the physical quantities, `matrix` (J, P), and the `known` torque (J,
    1).
    """

    parameters: tuple[Expr, ...]
    matrix: Matrix
    known: Matrix


def terms(torque: Matrix, unknowns: Sequence[Symbol], motion: Sequence[Symbol]) -> dict[tuple[int, Expr], Row]:
    """Split an expanded torque (J, 1) into {(joint, function of the motion): {monomial: coefficient}}."""
    from sympy import Add, Integer

    rows: dict[tuple[int, Expr], Row] = {}
    for joint, expression in enumerate(torque):
        for term in Add.make_args(expression):
            rest, monomial = term.as_independent(*unknowns, as_Add=False)
            coefficient, function = rest.as_independent(*motion, as_Add=False)
            row = rows.setdefault((joint, function), {})
            row[monomial] = row.get(monomial, Integer(0)) + coefficient
    return rows


def eliminate(mechanism: Mechanism, torque: Matrix) -> Base:
    """Return base parameters, their columns, and the part of the torque (J, 1) that holds no unknown.

    Rows are taken as they stand in the equation of motion: acceleration before velocity before gravity, hip
    before knee; bare masses are eliminated first, since they weigh in inertia and in gravity alike. A row
    that was reduced is scaled by the factor it was reduced with, so that all parameters share the unit of
    an inertia. For the plain leg this gives Φ1 to Φ4 of the paper, and e = g / a_th is that factor.
    """
    from sympy import Integer, Matrix, cancel

    motion = (*mechanism.angle, *mechanism.velocity, *mechanism.acceleration, mechanism.time)
    rows = terms(torque, mechanism.unknowns, motion)
    order = pivot_order(mechanism)
    pivots: list[tuple[Expr, Row]] = []
    size = len(mechanism.angle)
    known = [Integer(0)] * size
    columns: list[list[Expr]] = []
    for (joint, function), row in sorted(rows.items(), key=lambda item: row_order(mechanism, *item[0])):
        known[joint] += row.pop(Integer(1), Integer(0)) * function
        factors, rest = reduce(row, pivots)
        if rest:
            scale = scale_of(rest, factors)
            pivots.append((min(rest, key=order), {m: cancel(c / scale) for m, c in rest.items()}))
            columns.append([Integer(0)] * size)
            factors.append(scale)
        for column, factor in zip(columns, factors, strict=True):
            column[joint] += factor * function
    parameters = tuple(sum(c * m for m, c in row.items()) for _, row in pivots)
    return Base(parameters, Matrix(columns).T, Matrix(known))


def reduce(row: Row, pivots: Sequence[tuple[Expr, Row]]) -> tuple[list[Expr], Row]:
    """Subtract multiples of the pivot rows from `row`; return the multiples and what remains."""
    from sympy import Integer, cancel

    rest, factors = dict(row), []
    for monomial, pivot in pivots:
        factor = cancel(rest.get(monomial, Integer(0)) / pivot[monomial])
        factors.append(factor)
        if factor != 0:
            merged = {m: cancel(rest.get(m, 0) - factor * pivot.get(m, 0)) for m in {**rest, **pivot}}
            rest = {m: c for m, c in merged.items() if c != 0}
    return factors, rest


def scale_of(row: Row, factors: Sequence[Expr]) -> Expr:
    """Divisor of a new row: the first factor it was reduced with, else its numeric content."""
    from sympy import Integer, gcd_list

    for factor in factors:
        if factor != 0:
            return factor
    numbers = [abs(c.as_coeff_Mul()[0]) for c in row.values()]
    return gcd_list(numbers) if numbers else Integer(1)


def pivot_order(mechanism: Mechanism) -> Callable[[Expr], tuple[int, int, str]]:
    """Return the key by which pivot monomials are chosen: bare masses, then inertias, then the rest; far
    links first.
    """
    masses = [link.mass for link in reversed(mechanism.links)]
    inertias = [link.inertia for link in reversed(mechanism.links)]

    def key(monomial: Expr) -> tuple[int, int, str]:
        for rank, group in enumerate((masses, inertias)):
            if monomial in group:
                return rank, group.index(monomial), ""
        return 2, 0, str(monomial)

    return key


def row_order(mechanism: Mechanism, joint: int, function: Expr) -> tuple[int, int, int, int, str]:
    """Return the sorting key of a row: acceleration, velocity, gravity; hip, knee; plain before
    trigonometric.
    """
    symbols = function.free_symbols
    kind = 2
    axis = 0
    for k, acceleration in enumerate(mechanism.acceleration):
        if acceleration in symbols:
            kind, axis = 0, k
    if kind and symbols & set(mechanism.velocity):
        kind = 1
    return kind, joint, len(symbols & set(mechanism.angle)), axis, str(function)
