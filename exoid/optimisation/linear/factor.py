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

from exoid.symbolic.motion import Float

RANK_TOLERANCE = 1e-9
"""Relative size below which a direction counts as not excited. Filtered columns are exact to about 1e-13."""

FAR = 1e3
"""Condition of columns up to which products of them tell all that reflections would, to 1e-13."""


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
        """Number of independent directions that the data determine."""
        return int(self.basis.shape[1])


class Factors:
    """Factorises one regressor after another: columns that stay what they were are orthogonalised once."""

    def __init__(self) -> None:
        self._last: Float | None = None
        self._moving = np.zeros(0, dtype=bool)
        self._still: tuple[Float, Float] | None = None

    def __call__(self, matrix: Float) -> Factor:
        """Factors as `factorise` returns them, to rounding."""
        last, self._last = self._last, matrix
        if last is None or last.shape != matrix.shape:
            self._moving, self._still = np.zeros(matrix.shape[1], dtype=bool), None
            return factorise(matrix)
        moving = self._moving | (matrix != last).any(axis=0)
        if moving.sum() > self._moving.sum():
            self._moving, self._still = moving, None
        if 2 * moving.sum() > moving.size:
            return factorise(matrix)
        length = _lengths(matrix)
        scaled = matrix / np.where(length > 0.0, length, 1.0)
        if self._still is None:
            self._still = _orthogonal(scaled[:, ~moving])
        still, triangle = self._still
        onto = still.T @ scaled[:, moving]
        rest = scaled[:, moving] - still @ onto
        again = still.T @ rest  # once more: what rounding left of the columns that stay
        basis, corner = _orthogonal(rest - still @ again)
        whole = np.zeros((moving.size, moving.size))
        whole[: len(triangle), ~moving] = triangle
        whole[: len(triangle), moving] = onto + again
        whole[len(triangle) :, moving] = corner
        return _factor(np.hstack([still, basis]), whole, length)


def factorise(matrix: Float) -> Factor:
    """Factorise a regressor `matrix` (rows, P); columns of zeros and dependent columns are allowed."""
    length = _lengths(matrix)
    return _factor(*_orthogonal(matrix / np.where(length > 0.0, length, 1.0)), length)


def _orthogonal(matrix: Float) -> tuple[Float, Float]:
    """Return `matrix` (rows, P) as an orthonormal basis (rows, P) times a triangle (P, P).

    Columns far from dependent are divided by the Cholesky factor of their products, twice, which is as exact as
    reflections and a few plain products (Yamamoto and others, Roundoff error analysis of the CholeskyQR2 algorithm,
    2015); others go through reflections.
    """
    basis, triangle = matrix, np.eye(matrix.shape[1])
    for _ in range(2):
        try:
            step = np.linalg.cholesky(basis.T @ basis).T
            back = np.linalg.inv(step)
        except np.linalg.LinAlgError:
            return np.linalg.qr(matrix)
        if not np.linalg.norm(step) * np.linalg.norm(back) <= FAR:
            return np.linalg.qr(matrix)
        basis, triangle = basis @ back, step @ triangle
    return basis, triangle


def _lengths(matrix: Float) -> Float:
    return np.asarray(np.sqrt(np.einsum("kp,kp->p", matrix, matrix)))


def _factor(basis: Float, triangle: Float, length: Float) -> Factor:
    """Return the factor of `basis` (rows, P) · `triangle` (P, P) · diag(`length`)."""
    scale = np.where(length > 0.0, length, 1.0)
    left, size, right = np.linalg.svd(triangle)
    rank = int(np.sum(size > RANK_TOLERANCE * max(1.0, size[0]))) if size.size else 0
    if rank == triangle.shape[1]:
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
