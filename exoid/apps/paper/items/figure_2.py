"""The mechanism: angles, lengths, centres of mass."""

from __future__ import annotations

from sympy import diff

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import IN_PART, ItemAnswer, PaperPicture
from exoid.apps.paper.sketches import mechanism_figure
from exoid.symbolic.mechanics.mechanism import leg

TITLE = "the mechanism"
SAYS = "θ1 from the downward vertical, θ2 relative to the thigh, a_th and l_th from the hip, l_sh “from the hip motor”."


def answer(experiments: Experiments) -> ItemAnswer:
    """Draw the symbols, and look where the formulas have the shank's centre of mass."""
    plain = leg()
    shank = plain.links[1].along
    (x, z), angle = plain.point(1, shank), plain.absolute_angle(1)
    from sympy import cos, simplify, sin

    from_knee = simplify(diff(x, shank) - sin(angle)) == 0 and simplify(diff(z, shank) + cos(angle)) == 0
    where = "the knee, along the shank" if from_knee else "elsewhere"
    alt = "Two links with the angles θ1 and θ2, the lengths a_th, l_th and l_sh, gravity and the forces at the cuffs."
    return ItemAnswer(
        f"M, C and G follow from these symbols when l_sh is counted from {where}.",
        IN_PART,
        "the text measures l_sh from the hip motor, but the printed formulas have it from the knee",
        pictures=(PaperPicture("mechanism", alt, mechanism_figure()),),
    )
