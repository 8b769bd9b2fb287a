"""The matrix C as it is printed."""

from __future__ import annotations

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import FAILS, IN_PART, ItemAnswer
from exoid.symbolic.check import paper_checks, paper_coriolis
from exoid.symbolic.mechanics.mechanism import leg
from exoid.symbolic.model_equations import equations
from exoid.symbolic.writing_equations import matrix_lines

TITLE = "the Coriolis matrix"
SAYS = "C = m_sh a_th l_sh sin θ2 [[-2 θ2', -θ2'], [θ1', 0]]."


def answer(experiments: Experiments) -> ItemAnswer:
    """Compare it with Christoffel's form of Lagrange's C."""
    same, other, _ = paper_checks()
    lines = matrix_lines("C_printed", paper_coriolis(leg())) + matrix_lines("C", equations(experiments.leg).C)
    return ItemAnswer(
        f"it {'gives' if same.holds else 'does not give'} the same C θ' as Lagrange's equation.",
        IN_PART if same.holds else FAILS,
        f"it is not Christoffel's form: {other.detail}, so the passivity that controllers rely on is lost",
        text="\n".join(lines),
    )
