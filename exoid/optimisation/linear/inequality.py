"""A symmetric matrix that is linear in the parameters and has to stay positive definite."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exoid.symbolic.motion import Float


@dataclass(frozen=True, eq=False)
class Inequality:
    """A matrix F(Φ) ⪰ `margin`·1 with a trace of at most `most`; `entries` (n, n, P) are what it has per unit of Φ.

    `push` (P,) added to Φ raises all its eigenvalues by one at least.
    """

    name: str
    entries: Float
    push: Float
    margin: float
    most: float = np.inf

    @property
    def size(self) -> int:
        """Number of its rows."""
        return len(self.entries)

    def matrix(self, linear: Float) -> Float:
        """Return the matrix (n, n) at `linear`, the margin taken off."""
        return np.asarray(self.entries @ linear - self.margin * np.eye(self.size))

    def room(self, linear: Float) -> float:
        """Distance of its trace from the most it may be."""
        return self.most - float(np.einsum("iip,p->", self.entries, linear))

    def holds(self, linear: Float) -> bool:
        """True if `linear` (P,) fulfils it."""
        return bool(np.linalg.eigvalsh(self.matrix(linear))[0] >= 0.0) and self.room(linear) >= 0.0

    def condition(self, v: Float) -> tuple[Float, float]:
        """Return vᵀF(Φ)v ≥ 0, linear in Φ, as a row (P,) and a constant."""
        return np.asarray(np.einsum("i,ijp,j->p", v, self.entries, v)), -self.margin * float(v @ v)

    def least(self, slope: Float) -> float:
        """Return the least that slope · Φ can be where it holds, for a `slope` (P,) that is zero wherever no entry is;
        the entries have to be independent of each other.
        """
        rows = self.entries.reshape(-1, len(slope))
        normal = (np.linalg.pinv(rows.T) @ slope).reshape(self.size, self.size)  # slope · Φ is tr(normal · F)
        lowest, least = float(np.linalg.eigvalsh(normal)[0]), self.margin * float(np.trace(normal))
        return least if lowest >= 0.0 else least + lowest * (self.most - self.size * self.margin)
