"""The regressor Y as it is printed."""

from __future__ import annotations

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import IN_PART, ItemAnswer, PaperTable
from exoid.symbolic.mechanics.regressor import compare_with_printed
from exoid.symbolic.model_equations import equations
from exoid.symbolic.writing_equations import matrix_lines

TITLE = "the regressor Y"
SAYS = "the torque is Y Φ with this matrix of 2 × 8 entries."


def answer(experiments: Experiments) -> ItemAnswer:
    """Compare every entry with the derived one, and measure what it costs to fit with the printed one."""
    wrong = compare_with_printed()
    Y = equations(experiments.leg).Y
    cost = experiments.printed_regressor
    places = ", ".join(f"({entry.row}, {entry.column})" for entry in wrong)
    (h0, k0), (h1, k1) = cost["derived"], cost["printed"]
    rows = [(f"({e.row}, {e.column})", f"`{e.printed}`", f"`{e.derived}`", f"`{e.difference}`") for e in wrong]
    return ItemAnswer(
        f"{Y.rows * Y.cols - len(wrong)} of {Y.rows * Y.cols} entries are what Lagrange's equation gives. Fitting with "
        f"the printed Y, the true RMS error on unseen motion goes from {h0:.2f} to {h1:.2f} N·m at the hip and from "
        f"{k0:.2f} to {k1:.2f} N·m at the knee.",
        IN_PART,
        f"entry {places} is misprinted: it has velocities where accelerations belong. Φ3 of this leg is small, and the "
        "other parameters take up a part of the mistake; that is why it can go unnoticed",
        text="\n".join(matrix_lines("Y", Y)),
        tables=(PaperTable(("entry", "printed", "derived", "difference"), rows),),
    )
