"""A recording played through a watch: what it reported, and the model's numbers over time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from exoid.apps.watch.events import Event
from exoid.apps.watch.outside import stream_of
from exoid.apps.watch.plots import numbers_figure
from exoid.apps.watch.settings import Settings
from exoid.apps.watch.watcher import Watcher
from exoid.ground.errors import RecordingError
from exoid.ground.html import bullets, picture
from exoid.ground.plain import AsJson
from exoid.measurement.reading.given import Given, machine_of, model_of, one_recording
from exoid.symbolic.effect import Effect
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float
from exoid.symbolic.quantity import Estimate

if TYPE_CHECKING:
    from matplotlib.figure import Figure

LONGEST = 2000
"""Moments of which the numbers are kept at most."""
LEAST = 4
"""Blocks at least that say what is usual."""
SHARE = 0.33
"""Part of a short recording that says what is usual."""


@dataclass(frozen=True, eq=False)
class Replay(AsJson):
    """The report of a watch on a recording: its `events`, and from when on it knew each number of the model.

    `values`, `low` and `high` (K, P) are the numbers and their 95 % intervals at times `t` (K,) s.
    """

    events: tuple[Event, ...]
    names: tuple[str, ...]
    units: tuple[str, ...]
    t: Float
    values: Float
    low: Float
    high: Float
    until: float

    def __repr__(self) -> str:
        return "\n".join(map(repr, self.events))

    def _repr_html_(self) -> str:
        return bullets([repr(item) for item in self.events]) + "".join(picture(f, alt) for _, alt, f in self.figures())

    @property
    def numbers(self) -> dict[str, dict[str, Any]]:
        """Unit, values and interval over time of every number."""
        rows = zip(self.names, self.units, self.values.T, self.low.T, self.high.T, strict=True)
        return {name: dict(zip(("unit", "value", "low", "high"), row, strict=True)) for name, *row in rows}

    def figures(self) -> list[tuple[str, str, Figure]]:
        """Return (title, alternative text, figure); none before any number was known."""
        if not self.t.size:
            return []
        changes = "; ".join(repr(e) for e in self.events if e.alarm) or "No change."
        return [("The numbers over time", changes, self.plot())]

    def plot(self) -> Figure:
        """Draw every number over time with its interval, and when something changed."""
        marks = [(event.since.low, event.since.high, event.t) for event in self.events if event.since is not None]
        return numbers_figure(self.t, self.names, self.units, self.values, self.low, self.high, marks)

    def _json(self) -> dict[str, Any]:
        return {"events": self.events, "t": self.t, "numbers": self.numbers, "until": self.until}


@dataclass(eq=False)
class Logbook:
    """Keeps what a watcher reports and its numbers over time; of a long time every second, fourth, ... block."""

    watcher: Watcher
    events: list[Event] = field(default_factory=list)
    known: list[tuple[float, tuple[Estimate, ...]]] = field(default_factory=list)
    blocks: int = 0
    every: int = 1

    def take(self, fresh: Sequence[Event]) -> None:
        """Keep what was reported, and what the numbers are."""
        self.events += [e for e in fresh if e.event != "estimates"]
        watcher = self.watcher
        if watcher.numbers is None or watcher.blocks < self.blocks + self.every:
            return
        self.blocks = watcher.blocks
        self.known.append((watcher.last, watcher.numbers.estimates()[: len(watcher.model.parameters)]))
        if len(self.known) > LONGEST:
            self.known, self.every = self.known[::2], 2 * self.every

    def played(self) -> Replay:
        """Return the replay that was kept."""
        first = self.watcher.model.parameters
        values, low, high = (
            np.array([[getattr(e, side) for e in each] for _, each in self.known]).reshape(-1, len(first))
            for side in ("value", "low", "high")
        )
        return Replay(
            tuple(self.events), tuple(p.name for p in first), tuple(p.unit for p in first),
            np.array([t for t, _ in self.known]), values, low, high, self.watcher.last,
        )  # fmt: skip


def replay(
    model: Model, recording: Given, settings: Settings | None = None,
    *, extra: Sequence[Effect] = (), progress: Callable[[Replay], object] | None = None,
) -> Replay:  # fmt: skip
    """Return the report of a watch on a recording; `progress` hears of it after every block.

    Without `settings` the first third says what is usual, two minutes at most. RecordingError for one that is too
    short.
    """
    model = machine_of(model_of(model))
    recording = one_recording(recording, model.joints)
    rows, names = stream_of(model, recording)
    usual = settings or Settings()
    if settings is None:
        learn = int(min(max(LEAST, SHARE * recording.duration / usual.block), usual.learn))
        usual = Settings(learn=learn, most_learn=3 * learn)
    shortest = LEAST * usual.block
    if recording.duration < 2.0 * shortest:
        raise RecordingError(
            f"{recording.duration:.3g} s are too short to be watched", where=recording.name,
            remedy=f"give at least {2.0 * shortest:g} s: the first {shortest:g} s say what is usual",
        )  # fmt: skip
    watcher = Watcher(model, usual, tuple(extra))
    watcher.measures(names)
    course = Logbook(watcher)
    size = max(1, round(usual.block * recording.rate))
    for k in range(0, len(rows), size):
        course.take(watcher.push(rows[k : k + size]))
        if progress is not None:
            progress(course.played())
    course.take(watcher.finish())
    return course.played()
