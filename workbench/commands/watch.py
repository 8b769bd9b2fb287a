"""`exoid watch`: follow a machine while it runs, and say when something changed."""

from __future__ import annotations

import argparse
import contextlib
import json
import signal
import sys
import threading
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import IO, TYPE_CHECKING, Any

from ground.errors import ExoidError
from ground.plain import plain_dict
from workbench.command_line.options import add_columns, add_common, positive_number, whole_number
from workbench.terminal.screen import Screen, warn

if TYPE_CHECKING:
    from diagnosis.watching.events import Event
    from diagnosis.watching.watcher import Watcher
    from measurement.reading.live import LineNote, Lines
    from symbolic.model import Model
    from symbolic.motion import Float

GROUP = "measure"
HELP = """follow a machine while it runs: numbers with intervals, and what changed, named

exoid watch leg.toml run.csv                a recording, or a file that is still being written
exoid watch leg.toml --follow log.csv       until Ctrl-C; log rotation is noticed
my_logger | exoid watch leg.toml -          CSV or one JSON object per line on standard input
exoid watch standard log.csv --json -       one JSON object per event"""

STANDARD = "standard"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("model", metavar="MODEL", help=f"model file (TOML), or {STANDARD} for the standard leg")
    parser.add_argument("source", metavar="SOURCE", help="a recording, a file that grows, or - for standard input")
    parser.add_argument("--follow", action="store_true", help="wait for further lines of the file until Ctrl-C")
    group = parser.add_argument_group("reading the samples")
    add_columns(group)
    group.add_argument("--cutoff", metavar="HZ", type=positive_number, default=None, help="cut-off of the filters (4)")
    group = parser.add_argument_group("watching")
    group.add_argument(
        "--learn", metavar="S", type=positive_number, default=120.0, help="first seconds, which say what is usual (120)"
    )
    group.add_argument(
        "--false-alarms", metavar="N", type=positive_number, default=1.0,
        help="false alarms accepted in 24 h of operation (1)",
    )  # fmt: skip
    group.add_argument(
        "--estimates", metavar="BLOCKS", type=whole_number, default=0,
        help="report the model's numbers every so many blocks of 5 s (0: only at the end)",
    )  # fmt: skip
    add_common(parser)


def run(args: argparse.Namespace) -> int:
    """Watch until the source ends; 1 when something changed."""
    from diagnosis.watching.front import CUTOFF
    from diagnosis.watching.settings import Settings
    from diagnosis.watching.watcher import Watcher
    from workbench.command_line.inputs import load_model
    from workbench.command_line.parser import UsageError

    given = None if args.model == STANDARD and not Path(STANDARD).exists() else args.model
    model = load_model(given)
    block = Settings().block
    if args.learn < 4 * block:
        raise UsageError(f"--learn {args.learn:g} is too short", remedy=f"give at least {4 * block:g} s")
    settings = Settings(
        cutoff=args.cutoff or CUTOFF, learn=round(args.learn / block), alarms_per_day=args.false_alarms,
        estimates=args.estimates, seed=args.seed, most_learn=3 * round(args.learn / block),
    )  # fmt: skip
    watcher = Watcher(model, settings, model.custom)
    report = _Report(args, watcher)
    if given is not None:
        from symbolic.model_file import read_numbers

        if read_numbers(given) is not None:
            report.note(f"the numbers in {given} are not used: the first {args.learn:g} s say what is usual")
    try:
        try:
            with _stopped_by_signals() as stopped:
                for samples, notes in _samples(args, model):
                    for one in notes:
                        report.line(one, watcher.last)
                    report.all(watcher.push(samples))
                    if stopped:
                        report.note("interrupted")
                        break
        except ExoidError:
            if watcher.blocks:  # what was seen is summed up, whatever ends it
                report.all(watcher.finish())
            raise
        report.all(watcher.finish())
    finally:
        report.close()
    if args.out:
        report.write(watcher)
    if not watcher.looked:
        warn("nothing was looked for: what is usual takes two minutes of motion (--learn S for less)")
        return 2
    return 1 if report.alarms else 0


@contextlib.contextmanager
def _stopped_by_signals() -> Iterator[list[int]]:
    """Yield what Ctrl-C, SIGTERM and SIGHUP that come write themselves into; the second one ends at once.

    A signal that whoever started this process has set to be ignored stays ignored (nohup, jobs in the background).
    """
    got: list[int] = []

    def stop(number: int, _: object) -> None:
        if got:
            raise KeyboardInterrupt
        got.append(number)

    before = {}
    if threading.current_thread() is threading.main_thread():  # elsewhere, whoever runs it decides about signals
        for name in ("SIGINT", "SIGTERM", "SIGHUP"):
            number = getattr(signal, name, None)
            if number is not None and signal.getsignal(number) is not signal.SIG_IGN:
                before[number] = signal.signal(number, stop)
    try:
        yield got
    finally:
        for number, handler in before.items():
            signal.signal(number, signal.SIG_DFL if handler is None else handler)


class _Report:
    """Tells events as they come: lines for people, objects for programs."""

    def __init__(self, args: argparse.Namespace, watcher: Watcher) -> None:
        from diagnosis.watching.replay import Logbook

        self.args = args
        self.screen = Screen.of(args)
        self.alarms = 0
        self.events: list[dict[str, Any]] = []
        self.course = Logbook(watcher) if args.out else None
        self.stream: IO[str] | None = None
        self.own = args.json not in (None, "-")
        if args.json == "-":
            self.stream = sys.stdout
        elif args.json:
            # A stream has to be readable while it grows, so it is not delivered whole at the end.
            self.stream = Path(args.json).open("w", encoding="utf-8")  # noqa: SIM115

    def all(self, events: list[Event]) -> None:
        for one in events:
            self.alarms += one.alarm
            style = "bad" if one.alarm else "warn" if one.event in ("motion", "waiting") else ""
            self.screen.say(repr(one), style)
            self._object(one.to_json())
        if self.course is not None:
            self.course.take(events)
        sys.stdout.flush()

    def line(self, one: LineNote, t: float) -> None:
        """Tell what is to be said of a line that came after `t` s."""
        from diagnosis.watching.events import Event

        warn(f"line {one.line}{' is passed over' if one.event == 'skipped' else ''}: {one.what}")
        self._object(Event(one.event, t, one.what, more={"line": one.line}).to_json())

    def note(self, text: str) -> None:
        self.screen.say(text, "faint")

    def _object(self, found: dict[str, Any]) -> None:
        if self.course is not None:
            self.events.append(found)
        if self.stream is not None:
            self.stream.write(json.dumps(found, ensure_ascii=True, allow_nan=False) + "\n")
            self.stream.flush()

    def close(self) -> None:
        if self.stream is not None and self.own:
            self.stream.close()

    def write(self, watcher: Watcher) -> None:
        """Write the events, and the numbers over time, into the folder of --out."""
        from workbench.command_line.deliver import deliver_results
        from workbench.report.material import Material, pictures_of

        assert self.course is not None
        played = self.course.played()
        told = [repr(e) for e in played.events if e.event not in ("start", "reference", "waiting")]
        streamed = argparse.Namespace(**{**vars(self.args), "json": None})  # written already, as it came
        payload = {"schema": "exoid.watch/1", "events": self.events, "numbers": played.numbers, "t": played.t}
        deliver_results(streamed, self.screen, plain_dict(payload), lambda: Material(
            title="While it ran", answer=" ".join(f"{one.rstrip('.')}." for one in told), model=watcher.model,
            pictures=pictures_of(played),
        ))  # fmt: skip


def _samples(args: argparse.Namespace, model: Model) -> Iterator[tuple[Float, Sequence[LineNote]]]:
    """Yield samples (N, 1 + 2 J) as they come, now and then none, and what is to be told of lines."""
    import numpy as np

    from measurement.reading.growing import check_text, grown, piped
    from measurement.reading.live import Lines
    from measurement.reading.mapping import StatedMapping
    from workbench.command_line.inputs import read
    from workbench.command_line.options import merged
    from workbench.command_line.parser import UsageError

    told = StatedMapping(merged(args.map, "--map"), merged(args.units, "--units"))
    if args.source == "-":
        if sys.stdin is None:
            raise UsageError("standard input is closed", remedy="pipe samples into it, or name a file")
        yield from _lines(Lines(model.joints, told), piped(sys.stdin.buffer))
        return
    if not Path(args.source).is_file() and not args.follow:
        from measurement.reading.sources import expand

        expand([args.source])  # says what is wrong with the name, and what is near it
    if args.follow or _may_grow(args.source):
        check_text(args.source)
        lines = Lines(model.joints, told, where=args.source)
        yield from _lines(lines, grown(args.source, True if args.follow else None))
        return
    for one in read(args.source, told, quiet=args.quiet):
        rows = np.column_stack([one.t, one.q, one.tau])[one.complete]
        for first in range(0, len(rows), 1000):
            yield rows[first : first + 1000], ()


def _may_grow(source: str) -> bool:
    """Whether the file is text by its name and was written to a moment ago."""
    from measurement.reading.growing import RECENT

    path = Path(source)
    texts = (".csv", ".tsv", ".txt", ".log", ".jsonl", ".json", ".ndjson")
    young = path.is_file() and time.time() - path.stat().st_mtime < RECENT
    return path.suffix.lower() in texts[3:] or (path.suffix.lower() in texts and young)


def _lines(lines: Lines, texts: Iterator[str | None]) -> Iterator[tuple[Float, Sequence[LineNote]]]:
    from measurement.reading.live import TOLD, LineNote

    for text in texts:
        rows = lines.feed(text or "", last=text is None)
        if text is None:
            lines.again()
        yield rows, lines.taken()
    yield lines.feed("", last=True), lines.taken()
    more = lines.skipped_count - TOLD
    if more > 0:
        yield lines.none, [LineNote(lines.number, f"{more} further lines were no samples either")]
