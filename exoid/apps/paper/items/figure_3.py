"""The control loop with which the data are sampled."""

from __future__ import annotations

import numpy as np

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import HOLDS, ItemAnswer, PaperPicture
from exoid.apps.paper.sketches import loop_figure
from exoid.measurement.bench.controller import Controller
from exoid.measurement.trajectories.trajectory import paper_trajectory

TITLE = "the control loop"
SAYS = "joint controllers make the leg follow the excitation while encoders, torque and force sensors are sampled."


def answer(experiments: Experiments) -> ItemAnswer:
    """Draw the loop of the bench, and measure how closely the leg follows in it."""
    run, path, control = experiments.runs[0], paper_trajectory(), Controller()
    t = run.recording.t
    wanted = path.at(t - t[0]).q
    apart = np.sqrt(np.mean((run.recording.q - wanted) ** 2, axis=0))
    shown = t - t[0] <= path.period
    figure = loop_figure(t[shown] - t[0], wanted[shown], run.recording.q[shown])
    bandwidth = " and ".join(f"{hz:g}" for hz in control.bandwidth)
    alt = "Blocks of the loop: excitation, PD control, motors, leg, encoders, recording; and one period as followed."
    return ItemAnswer(
        f"the bench closes the same loop (PD of {bandwidth} Hz): hip and knee follow to {apart[0]:.3f} and "
        f"{apart[1]:.3f} rad RMS.",
        HOLDS,
        pictures=(PaperPicture("loop", alt, figure),),
    )
