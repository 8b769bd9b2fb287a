"""The condition number against determinants as a measure of a motion."""

from __future__ import annotations

import math

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import IN_PART, ItemAnswer, PaperPicture, PaperTable
from exoid.apps.paper.pictures import criteria_figure
from exoid.optimisation.excitation.design import evaluate
from exoid.optimisation.excitation.settings import CRITERION_NAMES

TITLE = "criteria of an excitation"
SAYS = "of the measures of a motion the condition number of Ȳ is taken, not a determinant of ȲᵀȲ."
MEASURES = {"condition": "cond(Ȳ)", "d_optimal": "mean standard deviation", "worst": "worst relative deviation"}
"""What each criterion is about; det F of P numbers is the mean of their deviations to the power -2P."""


def answer(experiments: Experiments) -> ItemAnswer:
    """Design a motion by each criterion and evaluate all of them, the published one too, by every criterion."""
    leg = experiments.leg
    motions = {f"designed for {MEASURES[name]}": design.trajectory for name, design in experiments.designs.items()}
    motions["the published motion"] = experiments.published().trajectory
    values = {
        name: {element: evaluate(path, leg, criterion=element).value for element in CRITERION_NAMES}
        for name, path in motions.items()
    }
    least = {item: min(each[item] for each in values.values()) for item in CRITERION_NAMES}
    half = 0.5 / len(leg.parameters)

    def factor(criterion: str, value: float) -> float:
        return math.exp(half * (value - least[criterion])) if criterion == "d_optimal" else value / least[criterion]

    scores = {
        name: {measure: factor(criterion, each[criterion]) for criterion, measure in MEASURES.items()}
        for name, each in values.items()
    }
    by_condition, by_det = (scores[f"designed for {MEASURES[entry]}"] for entry in ("condition", "d_optimal"))
    mean, worst = MEASURES["d_optimal"], MEASURES["worst"]
    rows = [(name, *(f"{score:.2f}" for score in each.values())) for name, each in scores.items()]
    caption = "Each motion by each measure, as a multiple of the best motion's:"
    alt = "Bars: how much worse than the best each of four motions is by three measures."
    return ItemAnswer(
        f"the motion designed for cond(Ȳ) knows its numbers {by_condition[mean]:.2f} times worse on average, and the "
        f"worst of them {by_condition[worst]:.2f} times worse, than one designed for that; the one for the determinant "
        f"has {by_det[MEASURES['condition']]:.2f} times the least condition number.",
        IN_PART,
        "which is best depends on what is wanted: cond(Ȳ) changes with the units of the parameters, the determinant "
        "does not, and neither asks how well the worst number is known",
        tables=(PaperTable(("motion", *MEASURES.values()), rows, caption),),
        pictures=(PaperPicture("criteria", alt, criteria_figure(scores)),),
    )
