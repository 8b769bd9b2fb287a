"""Samples as they come become blocks: checked, filtered, and cut into windows of a few seconds each."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field

import numpy as np

from exoid.apps.watch.bad_samples import Gate
from exoid.apps.watch.events import clock
from exoid.apps.watch.front import CUTOFF, FrontEnd, Samples
from exoid.apps.watch.window import Window, window
from exoid.symbolic.motion import Float

LEAD = 2.0
"""s before each block in which its filters and operators with memory settle."""


@dataclass(eq=False)
class Blocks:
    """Takes samples (N, C) in any portions and gives windows of `seconds`; what it keeps does not grow.

    `channels` (C,) are the names of t, of q and tau of each of the `joints`, and of what acts from outside
    (`Outside.passed`); `first` and `last` are where in the stream one is, s.
    """

    channels: Sequence[str]
    joints: int
    seconds: float
    cutoff: float = CUTOFF
    gate: Gate = field(init=False)
    front: FrontEnd = field(init=False)
    waiting: Samples = field(init=False)
    first: float | None = None
    last: float = 0.0
    count: int = 0
    restarts: int = 0
    started: int = -1

    def __post_init__(self) -> None:
        self.gate = Gate(self.channels, self.joints)
        self.front = FrontEnd(self.joints, self.cutoff, len(self.channels) - 1 - 2 * self.joints)
        self.waiting = self.front.none

    def push(self, rows: Float) -> Iterator[Window]:
        """Yield the windows that samples complete."""
        yield from self._cut(self.front.push(self.gate.take(rows)))

    def finish(self) -> Iterator[Window]:
        """Yield the windows of a stream that ended before its rate was told."""
        yield from self._cut(self.front.finish())

    @property
    def fresh(self) -> bool:
        """True if the rate has been told since this was asked last: at the beginning, and after a jump of the clock."""
        if self.front.filters is None or self.front.restarts == self.started:
            return False
        self.started = self.front.restarts
        return True

    @property
    def lost(self) -> dict[str, int]:
        """Numbers of samples that were passed over, by reason."""
        gate, front = self.gate, self.front
        return {
            "not_finite": gate.not_finite, "not_credible": gate.not_credible, "not_later": front.late,
            "restarts": front.restarts,
        }  # fmt: skip

    def _cut(self, fresh: Samples) -> Iterator[Window]:
        filters = self.front.filters
        if self.front.restarts != self.restarts:
            self.restarts, self.waiting = self.front.restarts, self.front.none
        if not len(fresh) or filters is None:
            return
        self.first = float(fresh.t[0]) if self.first is None else self.first
        self.waiting = Samples.joined([self.waiting, fresh])
        lead = max(filters.settled, round(LEAD * filters.working))
        size = round(self.seconds * filters.working / filters.stride) * filters.stride
        while len(self.waiting) >= lead + size:
            self.count += 1
            part, self.waiting = self.waiting.part(0, lead + size), self.waiting.part(size)
            self.last = float(part.t[-1])
            yield window(clock(float(part.t[lead])), part, lead, filters)
        self.last = float(np.max(fresh.t))
