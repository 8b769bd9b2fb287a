"""The rigid-body part of a model: Φ1.. and the numbers of effects that change the mechanism itself.

An effect with `derive` returns a changed mechanism, from which everything is derived again; or a pair of
torques. Its shape symbols stay in the columns. A coefficient k enters as ∂τ/∂k: by itself where it is a
lumped parameter, times the other parameters (the *reference*) where it multiplies them, as the amplitude of
a moving base multiplies masses.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from exoid.ground.errors import EffectError
from exoid.symbolic.mechanics.mechanism import Mechanism, leg, real
from exoid.symbolic.mechanics.regressor import derive_regressor

if TYPE_CHECKING:
    from sympy import Matrix, Symbol

    from exoid.symbolic.term import Term


def symbols_of(term: Term) -> dict[str, Symbol]:
    """Return {name in the effect: SymPy symbol of the full name} of a term's coefficients and shapes."""
    return {key: real(f"{term.name}.{key}") for key in (*term.effect.coefficients, *term.effect.shape)}


def changed(mechanism: Mechanism, derived: Sequence[Term]) -> tuple[Mechanism, Matrix, list[Symbol]]:
    """Return a mechanism with the changes of the `derived` terms, the torques (J, 1) they add, and their coefficients;
    EffectError where one of them does neither.
    """
    from sympy import Matrix

    added = Matrix([0] * len(mechanism.links))
    coefficients: list[Symbol] = []
    for term in derived:
        symbols = symbols_of(term)
        coefficients += [symbols[key] for key in term.effect.coefficients]
        own = len(mechanism.links) - 1 if term.joint is None else term.first
        outcome = _call(term, replace(mechanism, own=own), symbols)
        if isinstance(outcome, Mechanism):
            mechanism = replace(outcome, own=0)
        else:
            added += Matrix(outcome)
    return mechanism, added, coefficients


def leg_columns(derived: Sequence[Term]) -> tuple[tuple[str, ...], Matrix]:
    """Return the names (n,) of the linear parameters of the leg changed by the `derived` terms, and the matrix (2, n)
    that makes its rigid-body torque of them; EffectError where that fails.

    Its symbols are the motion, `g` and `a_th`, shapes and linear parameters under their full names.
    """
    from sympy import Matrix

    mechanism, added, coefficients = changed(leg(), derived)
    form = derive_regressor(mechanism)
    phi = [real(name) for name in form.names]
    torque = form.matrix * Matrix(phi) + form.known + added
    columns = [form.matrix.subs(dict.fromkeys(coefficients, 0))]
    columns += [_slope(torque, k, coefficients) for k in range(len(coefficients))]
    return form.names + tuple(symbol.name for symbol in coefficients), Matrix.hstack(*columns)


def _call(term: Term, mechanism: Mechanism, symbols: Mapping[str, Symbol]) -> Any:
    """Run the effect's derive(); whatever it returns must be a Mechanism or a pair of torques."""
    derive = term.effect.derive
    outcome = derive(mechanism, symbols) if derive is not None else None
    if isinstance(outcome, Mechanism) or (isinstance(outcome, (tuple, list)) and len(outcome) == len(mechanism.links)):
        return outcome
    remedy = "return the changed Mechanism, or a SymPy torque for every joint"
    raise EffectError(f"derive() returned {type(outcome).__name__}", where=term.effect.id, remedy=remedy)


def _slope(torque: Matrix, k: int, coefficients: Sequence[Symbol]) -> Matrix:
    """Return ∂τ/∂k (J, 1) with later coefficients at zero: products of two then count once, in the later
    one.
    """
    from sympy import expand

    later = dict.fromkeys(coefficients[k + 1 :], 0)
    slope: Matrix = torque.subs(later).diff(coefficients[k]).applyfunc(expand)
    if slope.has(coefficients[k]):
        what = f"the torque is not linear in {coefficients[k].name}"
        remedy = "declare it as a shape with bounds instead of a coefficient"
        raise EffectError(what, where=coefficients[k].name.partition(".")[0], remedy=remedy)
    return slope
