"""Equation (1): whom an individual of NFO leans on."""

from __future__ import annotations

import numpy as np

from exoid.apps.paper.experiments import Experiments
from exoid.apps.paper.item import IN_PART, ItemAnswer
from exoid.optimisation.optimiser import Box
from exoid.optimisation.optimisers.nfo import NFO

TITLE = "the neighbours of NFO"
SAYS = "x_k is the nearest individual with f(x_k) < f(x_i), x_w the nearest with, as printed, f(x_k) > f(x_i)."
TEXT = """\
x_k = nearest x_j with f(x_j) < f(x_i)      (itself where there is none)
x_w = nearest x_j with f(x_j) > f(x_i)      (itself where there is none)
v_i = x_i + α rand∘(x_k - x_i) + α rand∘(x_k - x_w)"""


def answer(experiments: Experiments) -> ItemAnswer:
    """Hold a step of NFO to the rule, written down anew, on a random population."""
    rng = np.random.default_rng([experiments.seed, 11])
    x, step = rng.normal(size=(40, 3)), NFO(crossover=1.0)
    f = rng.permutation(len(x)).astype(float)
    state = step.start(x, f, Box(x.min(axis=0), x.max(axis=0)), rng)
    trial = step.ask(state, np.random.default_rng(5))
    pull, push = np.random.default_rng(5).random((2, *x.shape))
    wanted = np.empty_like(x)
    for i, own in enumerate(x):
        far = np.linalg.norm(x - own, axis=1)
        better, worse = (min(np.flatnonzero(item), key=lambda j: far[j], default=i) for item in (f < f[i], f > f[i]))
        wanted[i] = own + step.alpha * (pull[i] * (x[better] - own) + push[i] * (x[better] - x[worse]))
    apart = float(np.max(np.abs(trial - wanted)))
    return ItemAnswer(
        f"with x_w in the second line our NFO takes the same step to {apart:.0e} on {len(x)} individuals.",
        IN_PART,
        "the second line must say f(x_w) > f(x_i); as printed it contradicts the first and leaves x_w undefined",
        text=TEXT,
    )
