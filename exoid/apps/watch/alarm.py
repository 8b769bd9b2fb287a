"""Alarms, by which a block is called unusual: thresholds from placebos, for a rate of false alarms that is stated.

What each column wants is compared with what it has wanted so far. Its variance has two parts: noise, which shifted
residuals tell (`scores.placebos`), and what the error of the model makes of other motion, which blocks tell that are
known to be quiet. The largest deviation of all columns, over the last 1, 2, 6 and 24 blocks, is compared with the
threshold that placebos of all columns together exceed as rarely as asked for; the tail beyond the placebos is that of
a normal distribution (its square falls off exponentially).
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from exoid.apps.watch.scores import Scores
from exoid.ground.thresholds import Threshold
from exoid.symbolic.motion import Float

SPANS = (1, 2, 6, 24)
"""Blocks that are looked at together: a jump, a small one, a slow one."""
REMEMBERED = 120
"""Quiet blocks that say what is usual."""
TAIL = 0.2
"""Share of the placebos from which the tail is told."""
DAY = 86400.0
LEAST_POWER: Threshold = 0.02
"""part of a column's usual information that a block must have: rest would be taken for change"""


@dataclass(frozen=True)
class Deviation:
    """The largest deviation found: in standard deviations, of which column, over how many blocks; and the limit."""

    size: float
    column: int
    span: int
    limit: float

    @property
    def alarms(self) -> bool:
        """True if it exceeds the limit."""
        return self.size > self.limit


@dataclass(eq=False)
class Pending:
    """An alarm that is still to be asked about in `wait` blocks; `age` blocks old, `asked` so often; `told` that it has
    no name yet.
    """

    found: Deviation
    wait: int
    age: int = 0
    asked: int = 0
    told: bool = False


@dataclass(eq=False)
class Detector:
    """Quiet blocks, the last ones, and the threshold; nothing grows."""

    noise: Float
    """Variance (C,) of a / √i by chance."""
    limit: float
    quiet: deque[Scores] = field(default_factory=lambda: deque(maxlen=REMEMBERED))
    recent: deque[Scores] = field(default_factory=lambda: deque(maxlen=SPANS[-1]))

    @classmethod
    def calibrated(
        cls, blocks: Sequence[Scores], chance: Sequence[Float], seconds: float, alarms_per_day: float
    ) -> Detector:
        """Return a detector from quiet blocks of `seconds` and their placebos (draws, C) each."""
        draws = np.concatenate(list(chance))
        noise = np.maximum(np.mean(draws**2, axis=0), 1e-12)
        largest = np.sort(np.max(np.abs(draws) / np.sqrt(noise), axis=1) ** 2)
        start = largest[int((1.0 - TAIL) * (len(largest) - 1))]
        beyond = float(np.mean(largest[largest >= start] - start)) or 1.0
        wanted = alarms_per_day * seconds / DAY / len(SPANS)
        limit = float(np.sqrt(start + beyond * np.log(max(TAIL / wanted, 1.0))))
        return cls(noise, limit, deque(blocks, maxlen=REMEMBERED))

    def take(self, block: Scores) -> Deviation:
        """Return the largest deviation that ends with this block."""
        if len(self.recent) == self.recent.maxlen:
            self.quiet.append(self.recent[0])
        self.recent.append(block)
        return self.deviation()

    def deviation(self) -> Deviation:
        """Return the largest deviation that ends with the last block."""
        power, middle, spread = self._usual()
        usual = power.mean(axis=0)
        best = Deviation(0.0, 0, 1, self.limit)
        count = len(self.quiet)
        # Few quiet blocks say little about how much motion matters; the limit is Student's rather than normal.
        limit = self.limit * float(np.sqrt(1.0 + self.limit**2 / (4.0 * max(count - 1, 1))))
        for span in SPANS:
            if len(self.recent) < span:
                break
            last = list(self.recent)[-span:]
            total = np.sum([s.power for s in last], axis=0)
            seen = total > LEAST_POWER * span * usual
            total = np.where(seen, total, 1.0)
            wants = np.sum([s.slope for s in last], axis=0) / total
            variance = self.noise / total + spread * (1.0 / span + 1.0 / count)
            variance = variance + self.noise / np.maximum(power.sum(axis=0), 1e-300)
            size = np.where(seen & (usual > 0.0), np.abs(wants - middle) / np.sqrt(variance), 0.0)
            column = int(np.argmax(size))
            if size[column] > best.size:
                best = Deviation(float(size[column]), column, span, limit)
        return Deviation(best.size, best.column, best.span, limit)

    def onset(self, column: int) -> int:
        """Number of the last blocks that the change of a column has lasted: the most likely split."""
        _, middle, spread = self._usual()
        gain = []
        recent = list(self.recent)
        for span in range(1, len(recent) + 1):
            last = recent[-span:]
            total = sum(float(s.power[column]) for s in last)
            wants = sum(float(s.slope[column]) for s in last) / max(total, 1e-300)
            variance = self.noise[column] / max(total, 1e-300) + spread[column] / span
            gain.append((wants - middle[column]) ** 2 / variance)
        return int(np.argmax(gain)) + 1

    def calm(self) -> None:
        """Take the last blocks as usual as well."""
        self.quiet.extend(self.recent)
        self.recent.clear()

    def _usual(self) -> tuple[Float, Float, Float]:
        """Return power (B, C), what each column usually wants (C,), and its variance beyond noise (C,)."""
        slope, power = np.array([s.slope for s in self.quiet]), np.array([s.power for s in self.quiet])
        total = np.maximum(power.sum(axis=0), 1e-300)
        middle = slope.sum(axis=0) / total
        own = slope / np.maximum(power, 1e-300)
        free = np.maximum(power, 1e-300)
        seen = power > LEAST_POWER * power.mean(axis=0)
        beyond = np.where(seen, (own - middle) ** 2 - self.noise / free, 0.0).sum(axis=0)
        return power, middle, np.maximum(beyond / np.maximum(seen.sum(axis=0), 1), 0.0)
