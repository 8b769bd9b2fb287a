"""The regressor in coordinates in which all directions weigh the same.

    Y = Q W,   QᵀQ = 1,   z = W Φ      so that |YΦ| = |z|

With full rank W is the triangle R of the QR of Y (columns scaled to length one first, so that units cannot
spoil the arithmetic). Where columns depend on each other, W keeps only the directions the data determine,
and Φ is the smallest (scaled) of all that fit equally well; `undetermined` says which parameters that
concerns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symbolic.motion import Float

RANK_TOLERANCE = 1e-9
"""Relative size below which a direction counts as not excited. Filtered columns are exact to about 1e-13."""


@dataclass(frozen=True, eq=False)
class Factor:
    """`basis` Q (rows, rank), `forward` W (rank, P), `backward` W⁺ (P, rank), what is undetermined."""

    basis: Float
    forward: Float
    backward: Float
    condition: float
    undetermined: tuple[int, ...]
    unexcited: tuple[int, ...]

    @property
    def rank(self) -> int:
        """How many independent directions the data determine."""
        return int(self.basis.shape[1])


def factorise(matrix: Float) -> Factor:
    """Factorise a regressor `matrix` (rows, P); columns of zeros and dependent columns are allowed."""
    length = np.sqrt(np.einsum("kp,kp->p", matrix, matrix))
    scale = np.where(length > 0.0, length, 1.0)
    basis, triangle = np.linalg.qr(matrix / scale)
    left, size, right = np.linalg.svd(triangle)
    rank = int(np.sum(size > RANK_TOLERANCE * max(1.0, size[0]))) if size.size else 0
    if rank == matrix.shape[1]:
        forward = triangle * scale
        backward = np.linalg.inv(triangle) / scale[:, None]
        return Factor(basis, forward, backward, float(size[0] / size[-1]), (), ())
    forward = size[:rank, None] * right[:rank] * scale
    backward = right[:rank].T / size[:rank] / scale[:, None]
    backward[length == 0.0] = 0.0  # exactly, without what rounding adds
    free = np.abs(right[rank:]).max(axis=0) > np.sqrt(RANK_TOLERANCE)
    return Factor(
        basis=basis @ left[:, :rank],
        forward=forward,
        backward=backward,
        condition=float("inf"),
        undetermined=tuple(int(p) for p in np.flatnonzero(free)),
        unexcited=tuple(int(p) for p in np.flatnonzero(length == 0.0)),
    )
