"""The columns of a candidate on one recording, filtered like the torque: what the evidence weighs."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from exoid.symbolic.joints import LEG
from exoid.symbolic.motion import Float

AT_ONCE = 100_000
"""Values of columns that are looked at in one piece: so many stay in a processor's cache."""


@dataclass(frozen=True, eq=False)
class Columns:
    """Filtered columns (V, A, K, m) of a candidate on one recording: V nodes, A = its joints."""

    joints: tuple[int, ...]
    values: Float

    @classmethod
    def absent(cls, joints: tuple[int, ...], shape: tuple[int, ...]) -> Columns:
        """Return the columns of a candidate that does not act on a recording; one zero stands for all."""
        return cls(joints, np.broadcast_to(0.0, shape))

    @property
    def pieces(self) -> list[slice]:
        """The nodes in pieces that are worth having at once."""
        some = max(1, AT_ONCE // max(1, self.values[0].size))
        return [slice(at, at + some) for at in range(0, len(self.values), some)]

    @property
    def is_absent(self) -> bool:
        """True if it is known not to act on this recording, so that nothing need be computed."""
        return not any(self.values.strides)

    @property
    def flat(self) -> Float:
        """The columns (V, m, A·K), samples of all joints in one line; a view where there is one column a node."""
        return self.within(slice(None))

    def within(self, samples: slice) -> Float:
        """Return the same of some samples only."""
        values = self.values[:, :, samples]
        return values.transpose(0, 3, 1, 2).reshape(len(values), values.shape[3], -1)

    def full(self, node: int, joints: int = len(LEG)) -> Float:
        """Return the columns (J, K, m) of one node, zero at those of the `joints` that it does not act on."""
        values = self.node(node).values[0]
        out = np.zeros((joints, *values.shape[1:]))
        out[list(self.joints)] = values
        return out

    def products(self, weights: Float, signals: Float) -> tuple[Float, Float]:
        """Return the sums over samples of products of columns with `signals` (A, K, Q), (V, m, Q), and with each other,
        weighted by `weights` (A, K), (V, m, m).
        """
        flat = self.flat
        return flat @ signals.reshape(-1, signals.shape[2]), (flat * weights.ravel()) @ np.swapaxes(flat, 1, 2)

    def node(self, index: int) -> Columns:
        """Return the columns of one node alone."""
        return self.some(slice(index, index + 1))

    def some(self, nodes: slice | np.ndarray) -> Columns:
        """Return the columns of some nodes."""
        return Columns(self.joints, self.values[nodes])


def stacked(parts: Sequence[Sequence[Columns]], joints: int) -> list[Columns]:
    """Return for every recording the columns of several candidates as those of one on all `joints`.

    `parts` are each candidate's columns (one node) on the recordings. They are scaled to one size: a ridge is relative
    to the largest column, and would take those of a candidate that counts in other units for nothing.
    """
    counts = [max(1, sum(item.values.size for item in part)) for part in parts]
    squares = [sum(float(np.sum(item.values**2)) for item in part) for part in parts]
    sizes = [np.sqrt(square / count) or 1.0 for square, count in zip(squares, counts, strict=True)]
    each = zip(*parts, strict=True)
    full = [[item.full(0, joints) / size for item, size in zip(some, sizes, strict=True)] for some in each]
    return [Columns(tuple(range(joints)), np.concatenate(some, axis=2)[None]) for some in full]
