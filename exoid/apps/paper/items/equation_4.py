"""Equation (4): the motion of the leg."""

from __future__ import annotations

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import FAILS, HOLDS, ItemAnswer
from exoid.symbolic.check import check_equations, paper_checks
from exoid.symbolic.model_equations import equations
from exoid.symbolic.writing_equations import matrix_lines

TITLE = "the equation of motion"
SAYS = "M(θ) θ'' + C(θ, θ') θ' + G(θ) + τ_f(θ') = τ + J(θ)ᵀ F_dis, friction τ_f = k1 sgn θ' + k2 θ'."


def answer(experiments: Experiments) -> ItemAnswer:
    """Derive M, C, G and J by Lagrange, and prove what must hold of them."""
    leg = experiments.leg
    printed = {check.name for check in paper_checks()}
    checks = [check for check in check_equations(leg) if check.name not in printed]
    broken = [check.name for check in checks if not check.holds]
    found = equations(leg)
    lines = [line for letter in "MCGJ" for line in matrix_lines(letter, found.matrices[letter])]
    return ItemAnswer(
        f"derived by Lagrange; {len(checks) - len(broken)} of {len(checks)} properties hold, among them symmetry, "
        "positive definiteness and the energy balance, by proof.",
        FAILS if broken else HOLDS,
        ", ".join(broken),
        text="\n".join(lines),
    )
