"""The published excitation between the limits of Table 1."""

from __future__ import annotations

import math

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import FAILS, IN_PART, ItemAnswer, PaperPicture
from exoid.measurement.trajectories.extremes import shortest_period
from exoid.measurement.trajectories.trajectory import paper_trajectory

TITLE = "the excitation"
SAYS = "angle, velocity and acceleration of both joints stay inside Table 1 with the published coefficients."


def answer(experiments: Experiments) -> ItemAnswer:
    """Draw the published motion with a period of 10 s, and find the shortest that keeps the limits."""
    found = experiments.published()
    shortest = math.ceil(100 * shortest_period(paper_trajectory(), experiments.leg.motion_limits)) / 100
    inside = found.feasible
    alt = "Angle, velocity and acceleration of hip and knee over one period, between dashed lines for Table 1."
    return ItemAnswer(
        f"read as degrees, with a period of 10 s, cond(Ȳ) = {found.condition:.1f} and every limit "
        f"{'holds' if inside else 'does not hold'}; it does from {shortest:.2f} s on.",
        IN_PART if inside else FAILS,
        "neither the unit of the coefficients nor the period is printed: as radians they would swing a joint by tens "
        "of radians, and with a shorter period the knee is too fast",
        pictures=(PaperPicture("excitation", alt, found.plot()),),
    )
