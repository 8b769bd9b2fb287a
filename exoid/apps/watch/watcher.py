"""A machine while it runs: learn what is usual, follow the numbers, notice a change, name it.

    samples -> front end -> blocks of 5 s  -> estimator (numbers with intervals)
                                           -> scores of all columns -> detector -> before against after -> event

What is kept does not grow with time: the state of the filters and of the estimator, some dozen windows from before,
the last two dozen, and the scores of the last quiet blocks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from exoid.apps.watch import wording
from exoid.apps.watch.acting import Applied, already, as_usual
from exoid.apps.watch.alarm import SPANS, Pending
from exoid.apps.watch.asking import asked_of, differences_of
from exoid.apps.watch.course import Onset
from exoid.apps.watch.events import Event
from exoid.apps.watch.memory import TOGETHER, Memory
from exoid.apps.watch.numbers import FollowedNumbers
from exoid.apps.watch.outside import Outside
from exoid.apps.watch.pushes import Pushes
from exoid.apps.watch.settings import Settings
from exoid.apps.watch.state import WatchState
from exoid.apps.watch.usual import GROWN, Usual, learned
from exoid.apps.watch.window import Window, joined_windows
from exoid.diagnosis.against.differences import MOST
from exoid.diagnosis.against.result import Differences
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.errors import ExoidError
from exoid.ground.thresholds import Threshold
from exoid.symbolic.effect import Effect
from exoid.symbolic.model import Model
from exoid.symbolic.model_structure import require_still_base
from exoid.symbolic.motion import Float

NOTICED: Threshold = 1.1
"""times the usual error from which what has no name is reported at all: other motion alone grows it"""


@dataclass(eq=False)
class Watcher:
    """Takes samples in any portions (`push`) and returns what is to be reported.

    Samples are rows (N, 1 + 2 J + C): time in s, angles in rad, torques in N·m, and the model's forces, N, or what
    `measures` says.
    """

    model: Model
    settings: Settings = field(default_factory=Settings)
    extra: Sequence[Effect] = ()
    rules: Rules = RULES
    restored: WatchState | None = None
    """What an earlier watch has learnt; taken over with the first block."""

    def __post_init__(self) -> None:
        require_still_base(self.model, "watching")
        self.outside = Outside.of(self.model)
        self.stream = self.outside.blocks(self.settings)
        self.rng = np.random.default_rng(self.settings.seed)
        self.kept: list[Window] = []
        self.memory = Memory(self.rng)
        self.reference: Usual | None = None
        self.numbers: FollowedNumbers | None = None
        self.pending: Pending | None = None
        self.applied, self.lasting = list[Applied](), list[Applied]()
        self.pushes = Pushes(self.model.joints)
        self.counts: dict[str, int] = {}
        self.found, self.begun = 0, -np.inf

    # -- samples ----------------------------------------------------------------------------------------------

    def measures(self, names: Sequence[str]) -> None:
        """Say before the first sample which columns (C,) stand behind the torques; ExoidError where one is lacking."""
        if tuple(names) != self.outside.names:
            self.outside = Outside.of(self.model, names)
            self.model, self.stream = self.outside.model, self.outside.blocks(self.settings)

    def push(self, samples: Float) -> list[Event]:
        """Take samples and return the events they cause."""
        rows = np.atleast_2d(np.asarray(samples, dtype=float))
        if not rows.size:
            return []
        events = [event for item in self.stream.push(self.outside.arranged(rows)) for event in self._block(item)]
        if self.stream.fresh:
            needed = self.settings.learn * self.settings.block
            events.insert(0, wording.start_event(self.stream.front, self.model.joint_names, needed))
        return self._count(self.stream.gate.told() + events)

    def finish(self) -> list[Event]:
        """Return the events that the end of the stream still causes, the summary last."""
        events = self.stream.gate.finish()
        events += [event for item in self.stream.finish() for event in self._block(item)]
        for element in [entry for entry in self.applied if not entry.refined]:
            events += self._refine(element)
        self._count(events)
        seconds = 0.0 if self.stream.first is None else self.last - self.stream.first
        estimates = () if self.numbers is None else self.numbers.estimates()
        summary = wording.summary_event(
            self.last, seconds, self.blocks, self.looked, self.found, self.counts, self.stream.lost, estimates
        )
        return [*events, *self._count([summary])]

    @property
    def last(self) -> float:
        """The time reached in the stream, s."""
        return self.stream.last

    @property
    def blocks(self) -> int:
        """Number of blocks that have been judged."""
        return self.stream.count

    @property
    def changed(self) -> tuple[str, ...]:
        """Names of what differs now from what is usual."""
        return tuple(dict.fromkeys(item.name for c in (*self.lasting, *self.applied) for item in c.found))

    @property
    def looked(self) -> bool:
        """True if changes were looked for: what is usual was known at some time."""
        return self.counts.get("reference", 0) > 0

    def state(self) -> WatchState | None:
        """Return the state that has been learnt, None before anything has."""
        if self.reference is None or self.numbers is None:
            return None
        changes = [*self.lasting, *self.applied]
        return WatchState.of(self.model, self.settings, self.memory.first, changes, self.numbers)

    def _count(self, events: list[Event]) -> list[Event]:
        for event in events:
            self.found += event.event == "change" and event.more.get("state") == "first"
            self.counts[event.event] = self.counts.get(event.event, 0) + 1
        return events

    # -- blocks -----------------------------------------------------------------------------------------------

    def _block(self, item: Window) -> list[Event]:
        if self.restored is not None:
            return self._restore(self.restored, item) + self._block(item)
        if self.reference is None:
            if self.numbers is not None:
                self.numbers.take(item)
                item = as_usual(item, self.numbers.now, self.lasting)
            self.kept.append(item)
            return self._learn() if len(self.kept) >= self.settings.learn else []
        if self.outside.awake(self.reference.now.model, item):
            self._relearn([item], anew=True)
            return []
        usual = self._as_usual(item)
        block = self.reference.now.block_of(usual)
        if self.numbers is not None:
            self.numbers.take(item, block.columns)
        events = self._told()
        detector = self.reference.detector
        leaving = self.memory.recent[0] if len(detector.recent) == SPANS[-1] else None
        self.memory.recent.append(item)
        found = detector.take(self.reference.scores(usual, block))
        self.pushes.take(item, block, self.reference)
        if leaving is not None:
            self.memory.remember(self._as_usual(leaving), self.blocks)
        if self.pending is not None:
            self.pending.age += 1
            self.pending.wait -= 1
        elif found.alarms and not any(change.since.slow for change in self.applied):
            self.pending = Pending(found, self.settings.least - detector.onset(found.column))
            names, grown = self.model.joint_names, self.reference.grown_in(usual)
            events.append(wording.suspected_event(self.last, names, grown, found))
        if self.pending is not None and self.pending.wait <= 0:
            events += self._alarm(self.pending)
        for change in self.applied:
            change.age += 1
        due = [c for c in self.applied if not c.refined and c.age + self.settings.least >= self.settings.sure]
        if due and self.pending is None:
            events += self._refine(due[0])
        if self.pending is None:
            events += self.pushes.events(self.last)
        return events + self._renewed()

    def _as_usual(self, one: Window, but: Applied | None = None) -> Window:
        """Return a window without what has changed, `but` one of the changes."""
        assert self.reference is not None
        changes = [c for c in (*self.lasting, *self.applied) if c is not but]
        return self.pushes.left_out(as_usual(one, self.reference.now, changes))

    def _renewed(self) -> list[Event]:
        """Learn what is usual anew when what changed has lasted as long as that takes; until then, go on watching."""
        if not self.applied or self.pending is not None or not all(c.refined for c in self.applied):
            return []
        since = max(c.since.high for c in self.applied)
        last = [sample for sample in self.memory.recent if sample.t[0] > since]
        if len(last) < min(self.settings.learn, SPANS[-1]):
            return []
        self._relearn(last)
        return self._learn()

    def _learn(self) -> list[Event]:
        """Fit the model to what was seen, and calibrate the detector; wait on where that does not determine it."""
        settings = self.settings
        usual = joined_windows(self.kept, TOGETHER)
        try:
            model = self.outside.learnt_from(self.kept)
            self.reference = learned(model, self.kept, usual, settings, self.extra, self.rng)
        except ExoidError as error:
            if len(self.kept) < settings.most_learn:
                return []
            self.kept = self.kept[settings.learn :]
            return [Event("waiting", self.last, f"the motion so far does not determine the model: {error}")]
        now = self.reference.now
        if self.numbers is None:
            self.numbers = FollowedNumbers.started(now, self.reference.scale, self.kept[0].kept_rate, settings.pace)
            for item in self.kept:
                self.numbers.take(item)
        self.numbers.now = now
        self.memory.learnt(self.kept, usual)
        count, self.kept = len(self.kept), []
        limit = self.reference.detector.limit
        return [wording.reference_event(self.last, now, self.numbers.estimates(), limit, count)]

    def _restore(self, state: WatchState, one: Window) -> list[Event]:
        """Go on with what was learnt by an earlier watch; `one` is the first window of this one."""
        self.restored, self.begun = None, float(one.t[0])
        known = state.taken_over(self.outside, self.settings, self.extra, self.rng, one)
        first, self.reference, self.lasting, self.numbers = known
        self.memory.learnt(first, joined_windows(first, TOGETHER))
        now, numbers, limit = self.reference.now, self.numbers.estimates(), self.reference.detector.limit
        return [wording.reference_event(self.begun, now, numbers, limit, len(first), self.changed, restored=True)]

    def _told(self) -> list[Event]:
        every = self.settings.estimates
        if not every or self.blocks % every or self.numbers is None:
            return []
        return [wording.estimates_event(self.last, self.numbers.estimates())]

    # -- changes ----------------------------------------------------------------------------------------------

    def _alarm(self, pending: Pending) -> list[Event]:
        """Ask what differs between before and after; say so, or that it is the motion, or nothing.

        What has grown and has no name yet is told, and asked again with more data.
        """
        assert self.reference is not None
        settings, detector = self.settings, self.reference.detector
        lasted = detector.onset(pending.found.column)
        if lasted < settings.least and pending.age < settings.least:
            pending.wait = 1
            return []
        if not pending.asked and self._resized(lasted) and not detector.deviation().alarms:
            self.pending = None
            return [wording.calm_event(self.last)]
        # The first one may hold both.
        last = list(self.memory.recent)[-max(lasted, settings.least) :][1:]
        if over := self._ended():
            return over
        answer = self._ask(last)
        since = wording.onset_of(answer, last, self.begun) if answer.found else None
        if since is not None and not since.slow and since.t > last[0].t[0] + 0.5 * settings.block:
            # What was taken for after holds some of before.
            last = [entry for entry in last if entry.t[0] > since.t - 0.5 * settings.block]
            if len(last) < settings.least - 1:
                pending.wait = 1
                return []
            answer = self._ask(last)
        if answer.found and self.reference.explains(answer):
            return self._named(answer, pending, last)
        if pushes := self.pushes.explain(self.reference, self.last, self._rescore):
            self.pending = None
            return pushes
        grown = float(np.max(self.reference.grown(answer.rms_after))) > NOTICED and not answer.old
        # What no longer stands out when it is asked about again was a burst.
        if (answer.found or grown) and (not pending.asked or detector.deviation().alarms):
            pending.asked += 1
            pending.wait = max(1, pending.age // 2)
            events = []
            # What was named on few seconds may be larger or smaller.
            sure = pending.age >= settings.sure or all(c.refined for c in self.applied)
            if pending.asked > 2 and not pending.told and sure:
                pending.told, events = True, [self._nameless(answer)]
            if pending.age >= settings.sure:  # it stays without a name: this is what is usual from here on
                self._relearn(last)
            return events
        self.pending = None
        detector.calm()
        for item in last:
            self.memory.remember(self._as_usual(item), self.blocks)
        return [wording.calm_event(self.last, answer)]

    def _named(self, answer: Differences, pending: Pending, last: Sequence[Window]) -> list[Event]:
        """Say what has changed, forget it, and go on watching for what else changes."""
        assert self.reference is not None and self.numbers is not None
        self.pending = None
        again = next((c for c in self.applied if c.labels & {item.name for item in answer.found}), None)
        if again is not None and again.age < SPANS[-1] // 2:
            return self._refine(again)  # the first seconds said little of how large it is
        when = wording.onset_of(answer, last, self.begun)
        event = wording.change_event(self.last, answer, pending.found, "first", when)
        since = event.since or Onset.at(float(last[0].t[0]))
        self.applied.append(Applied(answer.found, since))
        self.pushes.seen.clear()
        self.numbers.changed(answer.found, since)
        self._rescore()
        return [event]

    def _ended(self) -> list[Event]:
        """Say which change is over: the one without which the last window is as usual, and with which it is not."""
        assert self.reference is not None and self.numbers is not None
        if not self.memory.recent:
            return []
        last = self.memory.recent[-1]
        for change, among in [(change, some) for some in (self.applied, self.lasting) for change in some]:
            left, without = (np.max(self.reference.grown_in(self._as_usual(last, but))) for but in (None, change))
            if without <= min(GROWN, 0.5 * left):
                self.pending = None
                among.remove(change)
                self.memory.begin_at(last)
                self._rescore()
                self.numbers.changed(change.found, Onset.at(float(last.t[0])))
                return [wording.over_event(self.last, change.found[0].name)]
        return []

    def _resized(self, lasted: int) -> bool:
        """Say anew how large is what was named on few seconds, before the last blocks are taken for another change."""
        assert self.reference is not None
        fresh = [c for c in self.applied if not c.refined]
        for change in fresh:
            since = change.since.t - 0.5 * self.settings.block
            last = [sample for sample in self.memory.recent if sample.t[0] > since]
            if len(last) - lasted >= self.settings.least:  # else what lasts began with the change itself
                last = last[:-lasted]
            if len(last) >= self.settings.least:
                answer = self._ask(last, MOST, change)
                if change.labels & {item.name for item in answer.found} and self.reference.explains(answer):
                    change.found = answer.found
        if fresh:
            self._rescore()
        return bool(fresh)

    def _rescore(self) -> None:
        """Judge the last windows as what is known by now makes them."""
        assert self.reference is not None
        recent = self.reference.detector.recent
        last = list(self.memory.recent)[len(self.memory.recent) - len(recent) :]
        recent.clear()
        recent.extend(self.reference.scores(self._as_usual(item)) for item in last)

    def _nameless(self, answer: Differences) -> Event:
        assert self.reference is not None
        pushes, names = self.pushes.since(self.memory.recent[0].t[0]), self.model.joint_names
        return wording.nameless_event(self.last, names, answer, self.reference.grown(answer.rms_after), GROWN, pushes)

    def _relearn(self, last: Sequence[Window], anew: bool = False) -> None:
        """Learn what is usual from `last` on, the numbers too where it is all learnt `anew`."""
        self.lasting += [part for c in self.applied if (part := c.lasting) is not None]
        assert self.reference is not None
        self.numbers = None if anew else self.numbers
        self.kept = [as_usual(item, self.reference.now, self.lasting) for item in last]
        self.applied, self.pending, self.reference = [], None, None
        self.memory.recent.clear()

    def _ask(self, after: Sequence[Window], most: int = 1, but: Applied | None = None) -> Differences:
        """Return the differences, `most` at most: on the first seconds a second one fits what the first leaves. What is
        known to have changed is taken out of all windows, `but` one change.
        """
        assert self.reference is not None
        recent = self.memory.just_before(after)  # they show whether it came slowly
        recent, after = ([self._as_usual(item, but) for item in some] for some in (recent, after))
        usual = self.memory.usual[: self.settings.learn // TOGETHER * 2 // 3]
        question = asked_of(self.reference.now, [*usual, *joined_windows(recent, TOGETHER)], after)
        known = already([c for c in (*self.lasting, *self.applied) if c is not but])
        rules = replace(self.rules, placebos=self.settings.draws)
        return differences_of(question, self.settings.seed, self.extra, rules, most, known)

    def _refine(self, change: Applied) -> list[Event]:
        """Name a change once more, now that it has lasted."""
        assert self.reference is not None and self.numbers is not None
        last = [sample for sample in self.memory.recent if sample.t[0] > change.since.t - 0.5 * self.settings.block]
        if (few := len(last) < self.settings.least - 1) or (over := self._ended()):
            return [] if few else over
        again, change.refined = change.refined, True
        answer = self._ask(last, MOST, change)
        if answer.found and self.reference.explains(answer):
            other = {item.name for item in answer.found} != change.labels
            change.found = answer.found
            event = wording.change_event(self.last, answer, None, "refined", wording.onset_of(answer, last, self.begun))
            if other:
                self.numbers.changed(answer.found, event.since or change.since)
            if change.since.slow:  # it may still go on: what is usual is learnt from here on
                self._relearn(last)
                return [event]
        elif answer.found or float(np.max(self.reference.grown(answer.rms_after))) > NOTICED:
            event = self._nameless(answer)
            self.applied.remove(change)
            self._relearn(last)
            return [event]
        else:
            event = wording.over_event(self.last, change.found[0].name, answer)
            self.applied.remove(change)
        self._rescore()
        return [] if again else [event]
