"""Forward selection by the Bayesian information criterion of independent errors."""

from __future__ import annotations

import numpy as np

from benchmarks.arena.columns import Table, torque_of
from benchmarks.arena.task import Answer, Task

TITLE = "stepwise, BIC"
MOST = 6


def answer(task: Task) -> Answer:
    """Add the entry that lowers the criterion most, at its best trial value, until none does."""
    table = Table(task)

    def criterion(columns: list[int], shapes: int) -> float:
        count = table.samples
        return float(count * np.log(table.rest(columns) / count) + (len(columns) + shapes) * np.log(count))

    chosen, named = table.base, list[str]()
    best = criterion(chosen, 0)
    while len(named) < MOST:
        tried = [
            (criterion([*chosen, *node], len(named) + 1), name, node)
            for name, nodes in table.nodes.items()
            for node in nodes
            if name not in named
        ]
        value, name, node = min(tried)
        if value >= best:
            break
        chosen, best, named = [*chosen, *node], value, [*named, name]
    return Answer([(name,) for name in named], torque_of(task, named))
