"""The noise of the angles, told while they come: what of them is faster than any motion.

The tenth difference of the samples that the torque's median looks at anyway is next to nothing of motion and all of
white noise. One in `RING` is squared, the median of as many squares is not moved by a wrong angle, and is followed.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import comb

import numpy as np

from exoid.symbolic.motion import Float

RING = 11
"""Samples of a difference, and squares of a median."""
DIFFERENCE = np.array([(-1.0) ** k * comb(RING - 1, k) for k in range(RING)])
MIDDLE = 0.5327
"""Mean of the median of eleven squares of a standard normal number."""
MEMORY = 60.0
"""s over which the noise is followed."""


def following(rate: float) -> float:
    """Return the share by which the noise follows a median, of samples at `rate` Hz."""
    return min(1.0, RING / (MEMORY * rate))


@dataclass(eq=False)
class EncoderNoise:
    """The variance (J,) of the noise of a sample of each angle so far, rad²; zero until enough has been seen."""

    variance: Float
    follow: float
    seen: int = 0
    squares: list[Float] = field(default_factory=list)

    def take(self, rows: Float) -> Float:
        """Return the variance (N, J) at each of N samples; `rows` (N + RING - 1, J) are angles from before and after
        them.
        """
        count = len(rows) - RING + 1
        out, done = np.empty((count, rows.shape[1])), 0
        for k in range(-(self.seen + 1) % RING, count, RING):
            out[done:k], done = self.variance, k
            self.squares = [*self.squares[1 - RING :], (DIFFERENCE @ rows[k : k + RING]) ** 2]
            if len(self.squares) == RING:
                now = np.median(self.squares, axis=0) / (MIDDLE * float(DIFFERENCE @ DIFFERENCE))
                fresh = not self.variance.any()
                self.variance = now if fresh else self.variance + self.follow * (now - self.variance)
        out[done:] = self.variance
        self.seen += count
        return out
