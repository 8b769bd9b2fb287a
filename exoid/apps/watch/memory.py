"""The windows that a watch keeps: those that said what is usual, some dozen quiet ones, and the last two dozen."""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from exoid.apps.watch.alarm import SPANS
from exoid.apps.watch.window import Window, joined_windows

JUST_BEFORE = 6
"""Windows just before a change that are compared with what is after it, beside the usual ones."""
TOGETHER = 2
"""Quiet blocks that are kept as one recording: placebos shift within a recording, and short ones hardly move."""


@dataclass(eq=False)
class Memory:
    """`first` said what is usual, block by block; `usual` are quiet ones of all times, joined; `recent` the last."""

    rng: np.random.Generator
    first: tuple[Window, ...] = ()
    usual: list[Window] = field(default_factory=list)
    recent: deque[Window] = field(default_factory=lambda: deque(maxlen=SPANS[-1]))
    leaving: list[Window] = field(default_factory=list)

    def learnt(self, first: Sequence[Window], usual: Sequence[Window]) -> None:
        """Begin anew with the windows that said what is usual, as they came and joined."""
        self.first, self.usual, self.leaving = tuple(first), list(usual), []
        self.recent.clear()

    def just_before(self, after: Sequence[Window]) -> list[Window]:
        """Return the last windows before those `after`, without the one at the seam, which may hold both; none where
        the clock was set back.
        """
        return [sample for sample in self.recent if sample.t[-1] < after[0].t[0]][-JUST_BEFORE - 1 : -1]

    def begin_at(self, one: Window) -> None:
        """Forget the last windows before `one`: what was so while they lasted is over."""
        while self.recent and self.recent[0].t[-1] < one.t[0]:
            self.recent.popleft()

    def remember(self, one: Window, blocks: int) -> None:
        """Keep a quiet window: of all that there were in so many `blocks`, each as likely as any other (reservoir
        sampling).
        """
        self.leaving.append(one)
        if len(self.leaving) < TOGETHER:
            return
        place = int(self.rng.integers(max(blocks // TOGETHER, 1)))
        if place < len(self.usual):
            self.usual[place] = joined_windows(self.leaving, TOGETHER)[0]
        self.leaving = []
