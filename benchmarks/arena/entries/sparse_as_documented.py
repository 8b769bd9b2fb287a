"""Sparse regression as its documentation shows it: PySINDy's thresholded least squares, all columns scaled alike."""

from __future__ import annotations

import importlib.util

import numpy as np

from benchmarks.arena.columns import Table, torque_of
from benchmarks.arena.task import Answer, Left, Task

TITLE = "sparse regression, as documented"


def answer(task: Task) -> Answer:
    """Name what keeps a coefficient above PySINDy's usual threshold, base columns among the others."""
    if importlib.util.find_spec("pysindy") is None:
        raise Left("PySINDy is not installed; pip install 'exoid[peers]'")
    from pysindy import STLSQ

    table = Table(task)
    owner = {k: name for name, node in table.best.items() for k in node}
    index = [*table.base, *owner]
    size, axes = np.linalg.eigh(table.gram.sum(axis=0)[np.ix_([*index, -1], [*index, -1])])
    rows = np.sqrt(np.maximum(size, 0.0))[:, None] * axes.T  # as many rows as columns say the same
    scale = np.maximum(np.linalg.norm(rows, axis=0), 1e-12)
    model = STLSQ(threshold=0.1, alpha=0.05)
    model.fit(rows[:, :-1] / scale[:-1], rows[:, -1:] / scale[-1])
    kept = [k for k, size in zip(index, model.coef_.ravel(), strict=True) if size and k in owner]
    named = sorted({owner[k] for k in kept})
    return Answer([(name,) for name in named], torque_of(task, named[:6]))
