"""The two losses of a population in NumPy, which the compiled kernel is checked against."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exoid.symbolic.motion import Float


@dataclass(frozen=True, eq=False)
class PopulationFitness:
    """SSE and Huber of a whole population; `columns` (J, N, P) and `tau` (J, N) as in `LinearData`."""

    columns: Float
    tau: Float

    def residuals(self, population: Float) -> Float:
        """Return the residuals (I, J, N) of `population` (I, P), N·m."""
        joints, samples, width = self.columns.shape
        predicted = np.atleast_2d(population) @ self.columns.reshape(joints * samples, width).T
        np.subtract(self.tau.reshape(-1), predicted, out=predicted)
        return predicted.reshape(-1, joints, samples)

    def sse(self, population: Float) -> Float:
        """Return the SSE (I,) of each individual of `population` (I, P)."""
        flat = self.residuals(population).reshape(len(np.atleast_2d(population)), -1)
        return np.einsum("ik,ik->i", flat, flat)

    def huber(self, population: Float, delta: Float) -> Float:
        """Return the Huber loss (I,) of each of `population` (I, P) for thresholds `delta` (J,)."""
        size = self.residuals(population)
        np.abs(size, out=size)
        inner = np.minimum(size, np.asarray(delta, dtype=float)[None, :, None])
        size *= 2.0
        size -= inner
        return np.einsum("ijk,ijk->i", inner, size)
