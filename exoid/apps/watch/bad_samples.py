"""Samples that no sensor can have measured: they are passed over, and named, before anything is made of them.

The limits are those of files (`exoid.measurement.reading.limits`). Beyond them, a stamp that leaves the clock must be
followed by others that go on from it, or it is the stamp that is wrong.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from exoid.apps.watch.events import Event, clock
from exoid.apps.watch.front import LONGEST_HOLE, STEPPED_BACK
from exoid.ground.errors import RecordingError
from exoid.ground.thresholds import Threshold
from exoid.measurement.reading.limits import FASTEST, LASTING, credible
from exoid.symbolic.motion import Float

CONFIRMED: Threshold = 5.0
"""samples that go on from a jump of the clock before it is believed: one wrong stamp is none"""
OVER = 5.0
"""s without a bad sample after which bad samples are over."""
ASTRAY = 50
"""Stamps, one after the other, of which none goes on from the one before, until the clock is no clock in s."""


@dataclass(eq=False)
class Episode:
    """Bad samples one soon after the other: how many, when the first and the last came, and of which channels."""

    first: float
    last: float
    count: int = 0
    channels: dict[str, float] = field(default_factory=dict)
    """{channel: a value that it had}."""

    def event(self, over: bool) -> Event:
        """Return the event of its beginning, or of its end when it is `over`."""
        what = "; ".join(f"{name} reads {value:.6g}" for name, value in self.channels.items())
        if over:
            when = f"from {clock(self.first)} to {clock(self.last)}"
            text = f"bad samples {when} are over, {self.count} were passed over: {what}"
        else:
            text = f"bad samples are passed over: {what}"
        more = {
            "state": "over" if over else "first", "count": self.count, "channels": list(self.channels),
            "since": {"t": self.first}, "until": {"t": self.last},
        }  # fmt: skip
        return Event("bad_samples", self.last if over else self.first, text, more=more)


@dataclass(eq=False)
class Gate:
    """Passes samples (N, 1 + 2 J, and more) on whose numbers can be true; counts the others and tells of them."""

    channels: Sequence[str]
    """Names of t, q and tau of each joint, and of whatever stands behind them."""
    joints: int
    last: Float | None = None
    """The last sample that was passed on."""
    refused: Float | None = None
    """The last sample after it that was not, if its stamp is good."""
    held: list[Float] = field(default_factory=list)
    """Samples after a jump of the clock that is not confirmed yet."""
    episode: Episode | None = None
    not_finite: int = 0
    not_credible: int = 0
    events: list[Event] = field(default_factory=list)

    astray: int = 0

    def take(self, samples: Float) -> Float:
        """Return the samples that can be true, in order; `told` has what is to be said of the others."""
        sure = credible(samples)
        sure[:, 0] = credible(samples[:, 0], time=True)
        whole = sure.all(axis=1)
        if whole.all() and not self.held and self.refused is None and self._smooth(samples):
            passed = samples
        else:
            passed = self._one_by_one(samples, sure)
        if len(passed):
            self.last = passed[-1]
            self._calm(float(passed[-1, 0]))
        return passed

    def told(self) -> list[Event]:
        """Return the events to be told, each once."""
        events, self.events = self.events, []
        return events

    def finish(self) -> list[Event]:
        """Return the events still to be told at the end; a jump of the clock that nothing confirmed is none."""
        self._drop()
        if self.episode is not None:
            self.events.append(self.episode.event(over=True))
            self.episode = None
        return self.told()

    def _smooth(self, samples: Float) -> bool:
        rows = samples if self.last is None else np.concatenate([self.last[None], samples])
        step = np.diff(rows[:, : 1 + self.joints], axis=0)
        later = step[step[:, 0] > 0.0]
        near = (step[:, 0] <= LONGEST_HOLE) & (step[:, 0] >= -STEPPED_BACK)
        return bool(near.all() and (np.abs(later[:, 1:]) <= FASTEST * later[:, :1]).all())

    def _one_by_one(self, samples: Float, sure: np.ndarray) -> Float:
        passed: list[Float] = []
        for row, right in zip(samples, sure, strict=True):
            if not right.all():
                self.not_finite += not np.isfinite(row).all()
                self.not_credible += bool(np.isfinite(row).all())
                on_clock = bool(right[0]) and 0.0 < row[0] - self._now() <= LONGEST_HOLE
                self.refused = row if on_clock else self.refused
                self._tell(row, np.flatnonzero(~right), float(row[0]) if on_clock else self._now())
                continue
            last = self.last
            step = 0.0 if last is None else float(row[0] - last[0])
            if last is not None and not -STEPPED_BACK <= step <= LONGEST_HOLE:
                self._jumped(row, passed)
                continue
            self._drop()  # the clock goes on as before: those stamps were wrong
            self.astray = 0
            fast = self._too_fast(row, step)
            if fast:
                self.refused = row
                self._refuse(row, fast, float(row[0]))
                continue
            passed.append(row)
            self.last, self.refused = row, None
        return np.array(passed) if passed else np.zeros((0, samples.shape[1]))

    def _too_fast(self, row: Float, elapsed: float) -> list[int]:
        """Return the columns of the angles that no joint reaches in the s `elapsed` since the last good sample."""
        if self.last is None or elapsed <= 0.0:
            return []
        before = self.last if self.refused is None else self.refused
        reach = FASTEST * (max(float(row[0] - before[0]), 0.0) + LASTING * elapsed)
        return [k for k in range(1, 1 + self.joints) if abs(row[k] - self.last[k]) > reach]

    def _jumped(self, row: Float, passed: list[Float]) -> None:
        """Hold a sample that leaves the clock until others confirm it."""
        if self.held and abs(row[0] - self.held[-1][0]) > LONGEST_HOLE:
            self.astray += 1
            if self.astray >= ASTRAY:
                raise RecordingError(
                    f"the time goes on by {abs(row[0] - self.held[-1][0]):.4g} s from one sample to the next",
                    where="column t", remedy="if it is not in s, say so: --units t=ms (in Python, give s)",
                )  # fmt: skip
            self._drop()
        self.held.append(row)
        if len(self.held) >= CONFIRMED:
            passed += self.held
            self.last, self.refused, self.held, self.astray = row, None, [], 0

    def _drop(self) -> None:
        """Refuse the stamps that nothing confirmed."""
        for row in self.held:
            self._refuse(row, [0], self._now())
        self.held = []

    def _refuse(self, row: Float, columns: Sequence[int], t: float) -> None:
        self.not_credible += 1
        self._tell(row, columns, t)

    def _tell(self, row: Float, columns: Sequence[int] | np.ndarray, t: float) -> None:
        known = self.episode or Episode(t, t)
        known.count += 1
        known.last = t
        for column in columns:
            known.channels.setdefault(self.channels[int(column)], float(row[int(column)]))
        if self.episode is None:
            self.episode = known
            self.events.append(known.event(over=False))

    def _calm(self, t: float) -> None:
        """End the episode when nothing bad has come for a while, or the clock is another one."""
        if self.episode is not None and abs(t - self.episode.last) >= OVER:
            self.events.append(self.episode.event(over=True))
            self.episode = None

    def _now(self) -> float:
        return 0.0 if self.last is None else float(self.last[0])
