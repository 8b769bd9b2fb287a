"""The columns of all that is watched: of every change that is asked about, at few values of its shapes, on a block."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exoid.apps.watch.window import Window
from exoid.diagnosis.against.questions import Asked
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.symbolic.motion import Float

NODES = 1
"""Values of the shapes of a change that are watched: an alarm only has to see it, a name is searched finely."""


class Watched:
    """Every change that is `asked` about, beside the model as it is `now`."""

    def __init__(self, asked: Sequence[Asked], now: FittedModel) -> None:
        self.now = now
        self.asked = [(item, _some(item.nodes)) for item in asked]

    def columns(self, window: Window, base: Float) -> Float:
        """Return the columns (C, J, K) on a window, on which those of the model are `base` (J, K, P)."""
        return np.concatenate([self._of(item, nodes, window, base) for item, nodes in self.asked])

    def _of(self, one: Asked, nodes: Float, window: Window, base: Float) -> Float:
        found = one.columns(nodes, window, base, self.now)
        whole = np.concatenate([np.moveaxis(found.full(v, len(base)), 2, 0) for v in range(len(nodes))])
        return whole if np.isfinite(whole).all() else np.zeros_like(whole)  # what has no value is never chosen


def _some(nodes: Float) -> Float:
    return nodes[np.unique(np.linspace(0, len(nodes) - 1, NODES + 2).round().astype(int)[1:-1])]
