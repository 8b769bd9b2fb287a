"""The torque as a product τ = Y(θ, θ', θ'') Φ, derived, and compared with the matrix the paper prints.

    Φ1 = I_th + I_sh + m_th l_th² + m_sh a_th² + m_sh l_sh²     Φ2 = I_sh + m_sh l_sh²
    Φ3 = m_sh a_th l_sh                                         Φ4 = m_th a_th l_th - I_th - m_th l_th²

The derivation knows none of this; it finds it, and finds that entry (1, 3) of the printed matrix has first
derivatives where Lagrange's equation has second ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING

from exoid.symbolic.mechanics.elimination import eliminate
from exoid.symbolic.mechanics.lagrange import mechanics
from exoid.symbolic.mechanics.mechanism import leg

if TYPE_CHECKING:
    from sympy import Expr, Matrix

    from exoid.symbolic.mechanics.mechanism import Mechanism


@dataclass(frozen=True, eq=False)
class Regressor:
    """`matrix` (J, P) times the base `parameters` (P,) plus the `known` torque (J, 1) is the rigid-body
    torque.

    `names` belong to the parameters.
    """

    names: tuple[str, ...]
    parameters: tuple[Expr, ...]
    matrix: Matrix
    known: Matrix


@dataclass(frozen=True)
class PrintedEntry:
    """An entry of the printed matrix that the derivation contradicts; `row` and `column` count from one."""

    row: int
    column: int
    printed: str
    derived: str
    difference: str

    def __str__(self) -> str:
        return (
            f"entry ({self.row}, {self.column}) of the printed Y reads {self.printed}; "
            f"Lagrange's equation gives {self.derived}; they differ by {self.difference}"
        )


@lru_cache(maxsize=32)
def derive_regressor(mechanism: Mechanism) -> Regressor:
    """Derive the regressor of `mechanism`: base parameters Φ1.., their columns."""
    base = eliminate(mechanism, mechanics(mechanism).torque)
    names = tuple(f"Phi{k + 1}" for k in range(len(base.parameters)))
    return Regressor(
        names=names,
        parameters=base.parameters,
        matrix=base.matrix,
        known=base.known,
    )


def printed_matrix(mechanism: Mechanism) -> Matrix:
    """Return the first four columns of Y as the paper prints them, error included, with e = g / a_th."""
    from sympy import Matrix, cos, sin

    (q1, q2), (v1, v2), (a1, a2) = mechanism.angle, mechanism.velocity, mechanism.acceleration
    e = mechanism.gravity / mechanism.links[0].length
    s1, s12 = e * sin(q1), e * sin(q1 + q2)
    y13 = 2 * cos(q2) * v1 + cos(q2) * v2 - sin(q2) * (2 * v1 * v2 + v2**2) + s12
    y23 = cos(q2) * a1 + sin(q2) * v1**2 + s12
    return Matrix([[a1 + s1, a2 - s1, y13, s1], [0, a1 + a2, y23, 0]])


def compare_with_printed(mechanism: Mechanism | None = None) -> tuple[PrintedEntry, ...]:
    """Return every entry of the paper's printed Y that differs from the derived one, in readable form."""
    from sympy import factor_terms, simplify

    plain = mechanism or leg()
    derived, printed = derive_regressor(plain).matrix, printed_matrix(plain)
    found = []
    for row in range(printed.rows):
        for column in range(printed.cols):
            difference = simplify(printed[row, column] - derived[row, column])
            if difference != 0:
                texts = (printed[row, column], derived[row, column], factor_terms(difference))
                found.append(PrintedEntry(row + 1, column + 1, *(str(text) for text in texts)))
    return tuple(found)
