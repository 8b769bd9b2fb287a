"""Events that a watch reports: one event after the other, each a sentence and one JSON object.

`event` is one of
    "start"        the rate is known; the delay of the filters is stated
    "reference"    enough has been seen: what the model's numbers are, and from now on changes are looked for
    "estimates"    the numbers as they are now
    "suspected"    something may have changed; what follows names it, or says that it is over
    "change"       something differs from before: `differences`, `since`, `kind`
    "motion"       another motion shows an error that the model has had all along; nothing changed
    "unexplained"  the error grew, and nothing that is known explains it
    "push"         a torque that nothing explains, for a second or two; nothing has changed
    "bad_samples"  samples that no sensor can have measured are passed over; or they are over
    "skipped"      a line that is no sample
    "columns"      a logger that began again says anew which column is which
    "heartbeat"    the watch is alive
    "summary"      the end
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from exoid.apps.watch.course import Onset
from exoid.diagnosis.against.result import Differences
from exoid.ground.plain import plain_dict
from exoid.symbolic.quantity import Estimate

SCHEMA = "exoid.watch/1"
ALARMS = ("change", "unexplained")
"""Events that say something is not as it was."""


@dataclass(frozen=True, eq=False)
class Event:
    """Something to report at time `t` of the stream, s. `more` are further fields of its JSON."""

    event: str
    t: float
    sentence: str
    estimates: tuple[Estimate, ...] = ()
    differences: Differences | None = None
    since: Onset | None = None
    kind: str = ""
    more: Mapping[str, Any] = field(default_factory=dict)

    @property
    def alarm(self) -> bool:
        """True if it says that something is not as it was."""
        return self.event in ALARMS

    @property
    def names(self) -> tuple[str, ...]:
        """Names of what differs, largest first."""
        return () if self.differences is None else tuple(d.name for d in self.differences.found)

    def __repr__(self) -> str:
        return f"{clock(self.t)}  {self.sentence}"

    def to_json(self) -> dict[str, Any]:
        """Return the event in plain types, one object of the stream."""
        out: dict[str, Any] = {"schema": SCHEMA, "event": self.event, "t": self.t, "sentence": self.sentence}
        if self.kind:
            out["kind"] = self.kind
        if self.since is not None:
            out["since"] = {"t": self.since.t, "low": self.since.low, "high": self.since.high}
        if self.differences is not None:
            out["differences"] = self.differences.found
            out["missing_all_along"] = self.differences.old
        if self.estimates:
            out["parameters"] = {e.name: e for e in self.estimates}
        return plain_dict(out | dict(self.more))


def clock(t: float) -> str:
    """Return a time of the stream as minutes and seconds, with hours where there are some."""
    sign, t = ("-" if t < -0.5 else ""), abs(t)
    minutes, seconds = divmod(round(t), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{sign}{hours}:{minutes:02d}:{seconds:02d}" if hours else f"{sign}{minutes:02d}:{seconds:02d}"
