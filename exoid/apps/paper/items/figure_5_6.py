"""The fits on the motion they were identified on."""

from __future__ import annotations

import numpy as np

from exoid.apps.paper.experiments import ONE_SIDED, USUAL, Experiments
from exoid.apps.paper.item import FAILS, HOLDS, ItemAnswer, PaperPicture
from exoid.apps.paper.pictures import torque_figure
from exoid.apps.paper.printed import RATE

TITLE = "the fit on the identification motion"
SAYS = "the torques of the identified models follow the measured ones of hip and knee on the identification motion."
SHOWN = slice(500, 1500)
"""Ten seconds, one period."""
ENOUGH = 0.9
"""Share of the variance that a model explains whose torque follows the measured one to the eye."""


def answer(experiments: Experiments) -> ItemAnswer:
    """Draw what both fits make of the recording they come from, with sensors of two kinds."""
    pictures, explained = [], {}
    for word, name in (("usual", USUAL), ("rough", ONE_SIDED)):
        fit, run = experiments.fits[name][0], experiments.runs[0]
        data = fit.data
        t = np.arange(data.tau.shape[1])[SHOWN] / RATE
        predicted = {"SSE": fit.sse, "Huber": fit.huber}
        torques = {kind: (data.columns @ linear)[:, SHOWN] for kind, linear in predicted.items()}
        figure = torque_figure(t, data.tau[:, SHOWN], run.torque.T[:, SHOWN], torques)
        alt = f"Torque of hip and knee in ten seconds of the fitted motion: measured, true, SSE, Huber. Errors: {name}."
        pictures.append(PaperPicture(f"fit_{word}", alt, figure))
        explained[name] = 1.0 - data.rms(fit.sse) ** 2 / np.var(data.tau, axis=1)
    said = {name: " and ".join(f"{100 * share:.0f} %" for share in item) for name, item in explained.items()}
    holds = bool(np.min(explained[USUAL]) >= ENOUGH)
    return ItemAnswer(
        f"SSE explains {said[USUAL]} of the measured torque's variance at hip and knee with the bench's instruments, "
        f"{said[ONE_SIDED]} with errors as large as the paper's δ.",
        HOLDS if holds else FAILS,
        "" if holds else f"less than {100 * ENOUGH:.0f} % is explained at a joint",
        pictures=tuple(pictures),
    )
