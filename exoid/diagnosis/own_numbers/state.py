"""Parts of recordings, and what is held true of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from exoid.diagnosis.evidence.gain import RecordingEvidence
from exoid.diagnosis.hypotheses import Claim
from exoid.optimisation.preparation.prepare import Prepared

Cuts = dict[int, int]
"""{recording: its kept sample from which on something may be different}, by index."""


@dataclass(frozen=True, eq=False)
class Claimed:
    """A claim that is held true, at a node; each of the `groups` of parts (indices) has a number."""

    claim: Claim
    node: float
    groups: tuple[tuple[int, ...], ...]


State = tuple[Claimed, ...]


@dataclass(frozen=True)
class Part:
    """The kept samples `start` to `stop` of a recording (index): the whole of it, or what is before or after a cut."""

    recording: int
    start: int
    stop: int
    samples: int

    @property
    def kept(self) -> slice:
        """The kept samples of the recording that belong to it."""
        return slice(self.start, self.stop)

    @property
    def whole(self) -> bool:
        """True if it is all of the recording."""
        return self.stop - self.start == self.samples

    def starts(self, block: RecordingEvidence, seconds: float) -> np.ndarray:
        """Samples of the part at which blocks begin that are compared with one another."""
        inside = block.starts(seconds) - self.start
        return np.unique([0, *inside[(inside > 0) & (inside < self.stop - self.start)]])

    def span(self, prepared: Prepared) -> tuple[float | None, float | None]:
        """From when and until when it lasts, in s of the recording's own time; None for its beginning and end."""
        times = prepared.all[self.recording].t
        start, stop = (float(times[k]) if 0 < k < self.samples else None for k in (self.start, self.stop))
        return start, stop


def parts_of(blocks: Sequence[RecordingEvidence], cuts: Cuts) -> tuple[Part, ...]:
    """Parts of all recordings, in order: two of those that are cut."""
    out = []
    for k, block in enumerate(blocks):
        many = block.residual.shape[1]
        ends = [0, *([cuts[k]] if k in cuts else []), many]
        out += [Part(k, a, b, many) for a, b in pairwise(ends)]
    return tuple(out)
