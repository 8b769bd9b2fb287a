"""Sparse regression with care: the base is never penalised, the number of terms is chosen by leaving recordings out."""

from __future__ import annotations

import numpy as np

from benchmarks.arena.columns import Table, torque_of
from benchmarks.arena.task import Answer, Task

TITLE = "sparse regression, with care"
MOST = 6


def answer(task: Task) -> Answer:
    """Drop, one by one, what costs least; take the smallest set within a standard error of the best left-out error."""
    table = Table(task)
    alone = {name: table.rest([*table.base, *node]) for name, node in table.best.items()}
    kept, path = sorted(alone, key=alone.__getitem__)[: 3 * MOST], []

    def columns(names: list[str]) -> list[int]:
        return [*table.base, *(k for name in names for k in table.best[name])]

    while True:
        if len(kept) <= MOST:
            path.append((list(kept), table.unseen(columns(kept))))
        if not kept:
            break
        without = {name: table.rest(columns([other for other in kept if other != name])) for name in kept}
        kept.remove(min(without, key=without.__getitem__))
    best = min((error for _, error in path), key=np.sum)
    tied = [s for s, e in path if np.sum(e - best) <= max(np.std(e - best) * len(e) ** 0.5, 0.01 * best.sum())]
    named = min(tied, key=len)
    return Answer([(name,) for name in named], torque_of(task, named))
