"""A machine while it runs: learn what is usual, follow the numbers, notice a change, name it.

    samples -> front end -> blocks of 5 s  -> estimator (numbers with intervals)
                                           -> scores of all columns -> detector -> before against after -> event

What is kept does not grow with time: the state of the filters and of the estimator, some dozen windows from before,
the last two dozen, and the scores of the last quiet blocks.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from diagnosis.evidence.fitted import FittedModel, fitted_model
from diagnosis.evidence.gain import RecordingEvidence
from diagnosis.rules import Rules
from diagnosis.watching.alarm import SPANS, Detector, Deviation
from diagnosis.watching.bad_samples import Gate
from diagnosis.watching.differences import MOST, QUICK, BeforeAfter
from diagnosis.watching.estimator import Estimator, Pace
from diagnosis.watching.events import Event, clock
from diagnosis.watching.front import CUTOFF, FrontEnd, Samples
from diagnosis.watching.questions import questions
from diagnosis.watching.result import Differences
from diagnosis.watching.scores import placebos, scores
from diagnosis.watching.watched import Watched
from diagnosis.watching.window import Window, joined_windows, prepared, window
from diagnosis.watching.wording import change_event, nameless_event, reference_event, start_event, summary_event
from ground.errors import ExoidError
from ground.thresholds import Threshold
from measurement.reading.columns import required
from optimisation.fitting.identify import identify
from symbolic.effect import Effect
from symbolic.model import Model, require_still_base
from symbolic.motion import Float

TOGETHER = 2
"""Quiet blocks that are kept as one recording: placebos shift within a recording, and short ones hardly move."""
LEAD = 2.0
"""s before each block in which its filters and operators with memory settle."""
JUST_BEFORE = 6
"""Windows just before a change that are compared with what is after it, beside the usual ones."""
GROWN = Threshold(
    1.5,
    "times the usual error from which a change without a name is no longer called small, and to which a name may leave "
    "it: what leaves more is the nearest entry, not the answer",
)
LEAST_SHARE = Threshold(
    0.02, "least share of the weighted unseen loss that a name explains: a burst resembles something for some seconds"
)
NOTICED = Threshold(
    1.1, "times the usual error from which what has no name is reported at all: other motion alone grows it"
)
REST = Threshold(0.1, "share of the grown squared error that a name may leave where it is above that: wrong names")


@dataclass(frozen=True)
class Settings:
    """How a watch works. `block` s are judged at a time; `learn` blocks say at first what is usual; a change is named
    when it has lasted `least` blocks and once more after `sure`; `alarms_per_day` false alarms are accepted; `placebos`
    are drawn per block for the threshold, and `draws` for a name. `estimates` says every so many blocks what the
    numbers are (0: never).
    """

    cutoff: float = CUTOFF
    block: float = 5.0
    learn: int = 24
    most_learn: int = 72
    least: int = 3
    sure: int = 12
    alarms_per_day: float = 1.0
    placebos: int = 40
    draws: int = 999
    estimates: int = 0
    pace: Pace = field(default_factory=Pace)
    seed: int = 0


@dataclass(eq=False)
class _Reference:
    """What is usual: the model fitted to windows from before, what is watched, and the detector."""

    now: FittedModel
    watched: Watched
    detector: Detector
    scale: Float
    rms: Float


@dataclass(eq=False)
class _Pending:
    """An alarm that is still to be asked about in `wait` blocks; `age` blocks old, `asked` so often; `told` that it has
    no name yet.
    """

    found: Deviation
    wait: int
    age: int = 0
    asked: int = 0
    told: bool = False


@dataclass(eq=False)
class Watcher:
    """Takes samples in any portions (`push`) and returns what is to be reported.

    Samples are rows (N, 1 + 2 J): time in s, angles in rad, torques in N·m, in the order of the joints.
    """

    model: Model
    settings: Settings = field(default_factory=Settings)
    extra: Sequence[Effect] = ()
    rules: Rules = QUICK

    def __post_init__(self) -> None:
        require_still_base(self.model, "watching")
        self.gate = Gate(required(self.model.joints))
        self.front = FrontEnd(len(self.model.joints), self.settings.cutoff)
        self.waiting = Samples.none(len(self.model.joints))
        self.rng = np.random.default_rng(self.settings.seed)
        self.kept: list[Window] = []
        self.usual: list[Window] = []
        self.leaving: list[Window] = []
        self.recent: deque[Window] = deque(maxlen=SPANS[-1])
        self.reference: _Reference | None = None
        self.estimator: Estimator | None = None
        self.pending: _Pending | None = None
        self.restarts = self.blocks = self.quiet_since = 0
        self.started = -1
        self.named: Event | None = None
        self.counts: dict[str, int] = {}
        self.found = 0
        self.first: float | None = None
        self.last = 0.0

    # -- samples ----------------------------------------------------------------------------------------------

    def push(self, samples: Float) -> list[Event]:
        """Take samples and return the events they cause."""
        rows = np.atleast_2d(np.asarray(samples, dtype=float))
        if not rows.size:
            return []
        width = 1 + 2 * len(self.model.joints)
        if rows.shape[1] != width:
            raise ExoidError(
                f"a sample has {rows.shape[1]} numbers; this machine has {width}: t, q and tau of each joint",
                remedy="give rows t, q1, ..., tau1, ...",
            )
        events = self._note(self.front.push(self.gate.take(rows)))
        if self.front.filters is not None and self.front.restarts != self.started:
            self.started = self.front.restarts
            needed = self.settings.learn * self.settings.block
            events.insert(0, start_event(self.front, self.model.joint_names, needed))
        return self._count(self.gate.told() + events)

    def finish(self) -> list[Event]:
        """Return what the end of the stream still causes, the summary last."""
        events = self.gate.finish() + self._note(self.front.finish())
        if self.named is not None:
            events += self._refined()
        self._count(events)
        seconds = 0.0 if self.first is None else self.last - self.first
        lost = {
            "not_finite": self.gate.not_finite, "not_credible": self.gate.not_credible, "not_later": self.front.late,
            "restarts": self.front.restarts,
        }  # fmt: skip
        estimates = () if self.estimator is None else self.estimator.estimates()
        summary = summary_event(self.last, seconds, self.blocks, self.looked, self.found, self.counts, lost, estimates)
        return [*events, *self._count([summary])]

    @property
    def looked(self) -> bool:
        """Whether changes were looked for: what is usual was known at some time."""
        return self.counts.get("reference", 0) > 0

    def _count(self, events: list[Event]) -> list[Event]:
        for one in events:
            self.found += one.event == "change" and one.more.get("state") == "first"
            self.counts[one.event] = self.counts.get(one.event, 0) + 1
        return events

    def _note(self, fresh: Samples) -> list[Event]:
        """Add working samples; cut blocks and judge them."""
        if self.front.restarts != self.restarts:
            self.restarts, self.waiting = self.front.restarts, Samples.none(len(self.model.joints))
        if not len(fresh) or self.front.filters is None:
            return []
        self.first = float(fresh.t[0]) if self.first is None else self.first
        self.last = float(fresh.t[-1])
        self.waiting = Samples.joined([self.waiting, fresh])
        filters = self.front.filters
        lead = max(filters.settled, round(LEAD * filters.working))
        size = round(self.settings.block * filters.working / filters.stride) * filters.stride
        events: list[Event] = []
        while len(self.waiting) >= lead + size:
            self.blocks += 1
            one = window(clock(float(self.waiting.t[lead])), self.waiting.part(0, lead + size), lead, filters)
            self.waiting = self.waiting.part(size)
            events += self._block(one)
        return events

    # -- blocks -----------------------------------------------------------------------------------------------

    def _block(self, one: Window) -> list[Event]:
        if self.reference is None:
            self.kept.append(one)
            return self._learn() if len(self.kept) >= self.settings.learn else []
        self.recent.append(one)
        reference = self.reference
        block = reference.now.block_of(one)
        self._estimate(one, block)
        events = self._told()
        if self.named is not None:
            self.quiet_since += 1
            return events + (self._refined() if self.quiet_since >= self.settings.sure else [])
        leaving = self.recent[0] if len(reference.detector.recent) == SPANS[-1] else None
        found = reference.detector.take(
            scores(reference.watched.columns(one, block.columns), block.residual, block.use, reference.scale, block)
        )
        if leaving is not None:
            self._remember(leaving)
        if self.pending is not None:
            self.pending.age += 1
            self.pending.wait -= 1
        elif found.alarms:
            self.pending = _Pending(found, self.settings.least - reference.detector.onset(found.column))
        if self.pending is not None and self.pending.wait <= 0:
            events += self._alarm(self.pending)
        return events

    def _learn(self) -> list[Event]:
        """Fit the model to what was seen, and calibrate the detector; wait on where that does not determine it."""
        settings = self.settings
        usual = joined_windows(self.kept, TOGETHER)
        question = prepared(self.model.joints, usual)
        try:
            now = fitted_model(identify(self.model, question.train, optimisers=()), question)
        except ExoidError as error:
            if len(self.kept) < settings.most_learn:
                return []
            self.kept = self.kept[settings.learn :]
            return [Event("waiting", self.last, f"the motion so far does not determine the model: {error}")]
        blocks = [now.block_of(one) for one in self.kept]
        scale = now.scale
        watched = Watched(questions(now, [b.columns for b in blocks], len(blocks), self.extra, always=False), now)
        found, chance = [], []
        for one, block in zip(self.kept, blocks, strict=True):
            columns = watched.columns(one, block.columns)
            found.append(scores(columns, block.residual, block.use, scale, block))
            chance.append(placebos(columns, block.residual, block, scale, settings.placebos, self.rng))
        detector = Detector.calibrated(found, chance, settings.block, settings.alarms_per_day)
        self.reference = _Reference(now, watched, detector, scale, now.train_rms)
        if self.estimator is None:
            spread = 10.0 * (np.abs(now.linear) + 1.0)
            rate = self.kept[0].kept_rate
            self.estimator = Estimator.start(self.model, now.linear, spread, scale, rate, settings.pace)
            for one, block in zip(self.kept, blocks, strict=True):
                self._estimate(one, block)
        self.usual, self.leaving, count = list(usual), [], len(self.kept)
        self.kept = []
        self.recent.clear()
        return [reference_event(self.last, now, detector.limit, count)]

    def _estimate(self, one: Window, block: RecordingEvidence) -> None:
        assert self.estimator is not None
        width = self.estimator.linear.size
        columns = np.moveaxis(block.columns[:, :, :width], 0, 1)
        self.estimator.steps(columns, one.torque.T, one.used.T)

    def _told(self) -> list[Event]:
        every = self.settings.estimates
        if not every or self.blocks % every or self.estimator is None:
            return []
        estimates = self.estimator.estimates()
        text = ", ".join(f"{e.name} {e.value:.3g}" for e in estimates)
        return [Event("estimates", self.last, text, estimates)]

    def _remember(self, one: Window) -> None:
        """Keep quiet windows: some dozen of all there were, each as likely as any other (reservoir sampling)."""
        self.leaving.append(one)
        if len(self.leaving) < TOGETHER:
            return
        place = int(self.rng.integers(max(self.blocks // TOGETHER, 1)))
        if place < len(self.usual):
            self.usual[place] = joined_windows(self.leaving, TOGETHER)[0]
        self.leaving = []

    # -- changes ----------------------------------------------------------------------------------------------

    def _alarm(self, pending: _Pending) -> list[Event]:
        """Ask what differs between before and after; say so, or that it is the motion, or nothing.

        What has grown and has no name yet is told, and asked again with more data.
        """
        assert self.reference is not None
        settings, detector = self.settings, self.reference.detector
        lasted = detector.onset(pending.found.column)
        if lasted < settings.least and pending.age < settings.least:
            pending.wait = 1
            return []
        # The first one may hold both.
        last = list(self.recent)[-max(lasted, settings.least) :][1:]
        answer = self._ask(last)
        if answer.found and self._explained(answer):
            self.pending, self.quiet_since = None, len(last)
            self.named = change_event(self.last, answer, pending.found, "first", last)
            return [self.named]
        if answer.found or (float(np.max(self._grown(answer.rms_after))) > NOTICED and not answer.old):
            pending.asked += 1
            pending.wait = max(1, pending.age // 2)
            events = []
            if pending.asked > 1 and not pending.told:  # a burst is over when it is asked about again
                pending.told, events = True, [self._nameless(answer)]
            if pending.age >= settings.sure:  # it stays without a name: this is what is usual from here on
                self._relearn(last)
            return events
        self.pending = None
        detector.calm()
        for one in last:
            self._remember(one)
        if answer.old:
            text = f"nothing changed; this motion shows what the model has missed all along: {', '.join(answer.old)}"
            return [Event("motion", self.last, text, differences=answer)]
        return []

    def _grown(self, rms: Sequence[float]) -> Float:
        """Return how many times the usual error (J,) an error is."""
        assert self.reference is not None
        return np.array(rms) / np.maximum(self.reference.rms, 1e-300)

    def _explained(self, answer: Differences) -> bool:
        """Whether what was found explains what has grown, at every joint."""
        grown, left = self._grown(answer.rms_after), self._grown(answer.rms_named)
        rest = (left**2 - 1.0) / np.maximum(grown**2 - 1.0, 1e-300)
        return bool(np.all((left <= GROWN) | (rest <= REST)))

    def _nameless(self, answer: Differences) -> Event:
        return nameless_event(self.last, self.model.joint_names, answer, self._grown(answer.rms_after), GROWN)

    def _relearn(self, last: Sequence[Window]) -> None:
        """Learn what is usual from `last` on."""
        self.named, self.pending, self.reference = None, None, None
        self.kept = list(last)
        self.recent.clear()

    def _ask(self, after: Sequence[Window], most: int = 1) -> Differences:
        """Return what differs, `most` things at most: on the first seconds a second one fits what the first leaves."""
        assert self.reference is not None
        now = self.reference.now
        # Those just before show whether it came slowly; the one at the seam may hold both. Where the clock was set back
        # there are none.
        recent = [one for one in self.recent if one.t[-1] < after[0].t[0]][-JUST_BEFORE - 1 : -1]
        usual = self.usual[: self.settings.learn // TOGETHER * 2 // 3]
        question = prepared(
            self.model.joints, [*usual, *joined_windows(recent, TOGETHER)], joined_windows(after, TOGETHER)
        )
        shapes = np.broadcast_to(now.shape, (len(question.train), now.shape.size))
        fit = fitted_model(replace(now.fit, shapes=shapes), question)
        rules = replace(self.rules, placebos=self.settings.draws, least_share=LEAST_SHARE)
        return BeforeAfter(fit, self.settings.seed, tuple(self.extra), rules, most).run(0.0)

    def _refined(self) -> list[Event]:
        """Name the change once more, now that it has lasted, and learn what is usual from here on."""
        assert self.named is not None
        last = list(self.recent)[-min(self.quiet_since, SPANS[-1]) :]
        answer = self._ask(last, MOST)
        if answer.found and self._explained(answer):
            event = change_event(self.last, answer, None, "refined", last)
        elif answer.found or float(np.max(self._grown(answer.rms_after))) > NOTICED:
            event = self._nameless(answer)
        else:
            text = f"over again: {self.named.names[0]} is as it was before"
            event = Event("change", self.last, text, (), answer, None, "over", {"state": "over"})
        self._relearn(last)
        return [event]
