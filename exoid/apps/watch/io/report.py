"""Events as they come: lines for people, objects for programs, each with the wall clock and the device it is from."""

from __future__ import annotations

import argparse
import json
import platform
import re
import sys
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any, Protocol

from exoid.ground.plain import plain_dict
from exoid.workbench.command_line.parser import UsageError
from exoid.workbench.terminal.screen import Screen, warn

if TYPE_CHECKING:
    from exoid.apps.watch.events import Event
    from exoid.apps.watch.live import LineNote
    from exoid.apps.watch.watcher import Watcher

DEVICE = re.compile(r"[A-Za-z0-9_.-]{1,64}")
"""What a device may be called: its name is part of topics."""


class Destination(Protocol):
    """A destination of events."""

    def take(self, event: dict[str, Any]) -> None:
        """Take an event in plain types."""

    def close(self) -> None:
        """Deliver what is still under way."""


def device_of(name: str | None) -> str:
    """Return the name of the device: that given, else that of this machine. UsageError for one that is none."""
    if name is None:
        return re.sub(r"[^A-Za-z0-9_.-]", "_", platform.node())[:64] or "device"
    if not DEVICE.fullmatch(name):
        raise UsageError(f"--device {name!r} is no name", remedy="use letters, digits, _ . and -, at most 64 of them")
    return name


class Report:
    """Tells events, and now and then that the watch is alive."""

    def __init__(self, args: argparse.Namespace, watcher: Watcher, device: str) -> None:
        from exoid.apps.watch.replaying import Logbook

        self.args, self.watcher, self.device = args, watcher, device
        self.screen = Screen.of(args)
        self.alarms = 0
        self.events: list[dict[str, Any]] = []
        self.others: list[Destination] = []
        self.course = Logbook(watcher) if args.out else None
        self.stream: IO[str] | None = None
        self.own = args.json not in (None, "-")
        self.beaten = self.came = time.monotonic()
        if args.json == "-":
            self.stream = sys.stdout
        elif args.json:
            # A stream has to be readable while it grows, so it is not delivered whole at the end.
            self.stream = Path(args.json).open("w", encoding="utf-8")  # noqa: SIM115

    def all(self, events: list[Event]) -> None:
        """Tell events."""
        for event in events:
            self.alarms += event.alarm
            style = "bad" if event.alarm else "warn" if event.event in ("motion", "waiting") else ""
            self.screen.say(repr(event), style)
            self._object(event.to_json())
        if self.course is not None:
            self.course.take(events)
        sys.stdout.flush()

    def line(self, one: LineNote, t: float) -> None:
        """Tell what is to be said of a line that came after `t` s."""
        from exoid.apps.watch.events import Event

        warn(f"line {one.line}{' is passed over' if one.event == 'skipped' else ''}: {one.what}")
        self._object(Event(one.event, t, one.what, more={"line": one.line}).to_json())

    def note(self, text: str) -> None:
        """Say something that is no event."""
        self.screen.say(text, "faint")

    def beat(self, came: int) -> None:
        """Say, every --heartbeat s of the wall clock, that the watch is alive; `came` samples since the last call."""
        from exoid.apps.watch.wording import heartbeat_event

        now = time.monotonic()
        self.came = now if came else self.came
        if self.args.heartbeat and now - self.beaten >= self.args.heartbeat:
            self.beaten = now
            watcher, known = self.watcher, self.watcher.reference is not None
            lost, silent = watcher.stream.lost, now - self.came
            self._object(heartbeat_event(watcher.last, watcher.blocks, known, watcher.changed, silent, lost).to_json())

    def _object(self, found: dict[str, Any]) -> None:
        found = {**found, "at": datetime.now(UTC).isoformat(timespec="milliseconds"), "device": self.device}
        if self.course is not None:
            self.events.append(found)
        if self.stream is not None:
            self.stream.write(json.dumps(found, ensure_ascii=True, allow_nan=False) + "\n")
            self.stream.flush()
        for other in self.others:
            other.take(found)

    def close(self) -> None:
        """Deliver what is still under way."""
        for other in self.others:
            other.close()
        if self.stream is not None and self.own:
            self.stream.close()

    def write(self) -> None:
        """Write the events, and the numbers over time, into the folder of --out."""
        from exoid.diagnosis.report.material import Material, pictures_of
        from exoid.workbench.command_line.deliver import deliver_results

        assert self.course is not None
        played = self.course.played()
        told = [repr(e) for e in played.events if e.event not in ("start", "reference", "waiting")]
        streamed = argparse.Namespace(**{**vars(self.args), "json": None})  # written already, as it came
        payload = {"schema": "exoid.watch/1", "events": self.events, "numbers": played.numbers, "t": played.t}
        deliver_results(streamed, self.screen, plain_dict(payload), lambda: Material(
            title="While it ran", answer=" ".join(f"{item.rstrip('.')}." for item in told), model=self.watcher.model,
            pictures=pictures_of(played),
        ))  # fmt: skip
