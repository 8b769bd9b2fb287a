"""The leg: two links in the sagittal plane, hip and knee driven."""

from __future__ import annotations

import numpy as np

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import IN_PART, ItemAnswer, PaperPicture
from exoid.apps.paper.sketches import POSES, leg_figure
from exoid.measurement.trajectories.trajectory import paper_trajectory

TITLE = "the leg"
SAYS = "an exoskeleton leg whose hip and knee are driven and move in one plane; its picture is of the machine itself."


def answer(experiments: Experiments) -> ItemAnswer:
    """Draw the leg of the model along the published motion."""
    leg, motion = experiments.leg, paper_trajectory()
    q = motion.at(np.arange(POSES) * motion.period / POSES).q
    thigh = leg.thigh_length
    figure = leg_figure(q, (thigh, thigh), list(leg.motion_limits.values()))
    alt = "Thigh and shank in postures of the published motion, inside the area that the limits of Table 1 leave."
    return ItemAnswer(
        f"the standard leg, thigh {thigh:g} m, in {POSES} postures of the published motion, all inside Table 1.",
        IN_PART,
        "a planar model of two joints says nothing of what moves out of the plane, and the shank's length, drawn "
        "as long as the thigh, is in none of its numbers",
        pictures=(PaperPicture("leg", alt, figure),),
    )
