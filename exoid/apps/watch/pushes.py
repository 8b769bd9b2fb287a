"""A push: a torque that the model does not expect, for a second or two, and then no more. Nothing of it is usual, and
nothing has changed: its samples are left out.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from exoid.apps.watch.events import Event, clock
from exoid.apps.watch.usual import Usual
from exoid.apps.watch.window import Window
from exoid.diagnosis.evidence.gain import RecordingEvidence
from exoid.ground.thresholds import Threshold
from exoid.symbolic.joints import Joint

STRONG: Threshold = 15.0
"""times the usual error from which a torque can be a push: bursts of a torque sensor would be"""
BEYOND: Threshold = 2.0
"""times the largest usual error from which it can be one: what usually is missed would be"""
SHORTEST: Threshold = 0.1
"""s that a push lasts at least: a burst of a torque sensor, or a reversal, would be one"""
LONGEST: Threshold = 3.0
"""s that a push lasts at most: a change would be one"""
AROUND = 0.5
"""s on either side of a push in which the filters still show it."""
SETTLED = 10.0
"""s after which a push that raised no alarm will not do so any more."""
APART = 60.0
"""s within which an alarm after a push is no other push: what comes again may be a change that some postures show."""
KEPT = 250
SEVERAL = 4
"""Pushes at once from which they are told as one thing."""
"""Pushes whose samples are left out; they are those of the last windows."""


@dataclass(frozen=True)
class Push:
    """From `since` to `until` s a torque of up to `size` N·m (N) that nothing explains, most of all at `joint`."""

    joint: int
    since: float
    until: float
    size: float

    @property
    def lasts(self) -> bool:
        """True if it lasts as long as pushes do."""
        return SHORTEST <= self.until - self.since <= LONGEST

    def event(self, t: float, joints: Sequence[Joint]) -> Event:
        """Return the event that reports it."""
        at = joints[self.joint]
        unit = at.unit("tau")
        text = f"pushed at {at.name} from {clock(self.since)} to {clock(self.until)}: up to {self.size:.2g} {unit} "
        text += "that nothing explains and that are over; nothing has changed"
        when = {"since": {"t": self.since}, "until": {"t": self.until}}
        return Event("push", t, text, more={"joint": at.name, "size": self.size, "unit": unit, **when})


def again_and_again(several: Sequence[Push], t: float, joints: Sequence[Joint]) -> Event:
    """Return the event of several pushes, one soon after the other."""
    last = max(several, key=lambda push: push.size)
    event = replace(last, since=several[0].since, until=several[-1].until).event(t, joints)
    at, count = joints[last.joint], len(several)
    text = f"pushed {count} times from {clock(several[0].since)} to {clock(several[-1].until)}, most of all at "
    text += f"{at.name}: up to {last.size:.2g} {at.unit('tau')} that nothing explains and that come and go; "
    text += "nothing has changed. A person, or the ground under a foot?"
    return replace(event, sentence=text, more={**event.more, "count": count})


@dataclass(eq=False)
class Pushes:
    """Those that were `seen` and are not told yet, and those that were `told`: their samples are left out."""

    joints: Sequence[Joint]
    seen: list[Push] = field(default_factory=list)
    told: deque[Push] = field(default_factory=lambda: deque(maxlen=KEPT))

    def take(self, one: Window, block: RecordingEvidence, usual: Usual) -> None:
        """Look for pushes in a window, which as evidence is `block`."""
        residual = np.where(block.use, np.abs(block.residual), 0.0)
        limit = np.maximum(STRONG * usual.rms, BEYOND * usual.largest)
        for k in np.flatnonzero((residual > limit[:, None]).any(axis=0)):
            t, joint = float(one.t[k]), int(np.argmax(residual[:, k] / np.maximum(limit, 1e-300)))
            now = Push(joint, t, t, float(residual[joint, k]))
            if self.seen and t - self.seen[-1].until < AROUND:
                last = self.seen.pop()
                now = replace(now if now.size > last.size else last, since=last.since, until=t)
            self.seen.append(now)

    def events(self, t: float) -> list[Event]:
        """Return the events at `t` s of pushes that raised no alarm."""
        found = self._over(t - SETTLED)
        self.told.extend(found)
        return self._said(found, t)

    def explain(self, usual: Usual, t: float, rescore: Callable[[], None]) -> list[Event]:
        """Return the events of the pushes that the alarm of `t` s was, which without them is none; nothing where it was
        something else, or pushes were told shortly before: what comes again may be a change that some postures show.

        `rescore` judges the last windows anew.
        """
        found = self._over(t)
        if not found:
            return []
        if self.told and found[0].since - self.told[-1].until < APART:
            self.told.clear()
            rescore()
            return []
        before = tuple(self.told)
        self.told.extend(found)
        rescore()
        if usual.detector.deviation().alarms:
            self.told.clear()
            self.told.extend(before)
            rescore()
            return []
        return self._said(found, t)

    def _over(self, t: float) -> list[Push]:
        """Return those seen that are over at `t` s; what lasts longer than a push, or not as long, is forgotten."""
        self.seen = [item for item in self.seen if item.until >= t - AROUND or item.lasts]
        return [entry for entry in self.seen if entry.until < t - AROUND]

    def _said(self, found: Sequence[Push], t: float) -> list[Event]:
        self.seen = [item for item in self.seen if item not in found]
        if len(found) >= SEVERAL:
            return [again_and_again(found, t, self.joints)]
        return [entry.event(t, self.joints) for entry in found]

    def since(self, t: float) -> int:
        """Number of events since `t` s, told or not."""
        return sum(item.since >= t and item.lasts for item in (*self.told, *self.seen))

    def left_out(self, one: Window) -> Window:
        """Return a window whose samples during told pushes are not used."""
        used = one.used
        for push in self.told:
            if one.t[-1] > push.since - AROUND and one.t[0] < push.until + AROUND:
                used = used & ~((one.t > push.since - AROUND) & (one.t < push.until + AROUND))
        return one if used is one.used else replace(one, used=used)
