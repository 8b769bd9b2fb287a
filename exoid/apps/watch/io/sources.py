"""Sources of samples: a recording, a file that grows, a pipe, a topic of ROS 2."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from exoid.workbench.command_line.parser import UsageError
from exoid.workbench.terminal.encoding import is_closed

if TYPE_CHECKING:
    from exoid.apps.watch.live import LineNote, Lines
    from exoid.apps.watch.watcher import Watcher
    from exoid.symbolic.motion import Float

PIPE, TOPIC = "-", "ros2:"
"""What a source is called that is standard input; with what one begins that is a topic."""


def is_live(args: argparse.Namespace) -> bool:
    """True if samples come as they are measured, so that there may be none for a while."""
    return args.source == PIPE or args.source.startswith(TOPIC) or args.follow or _may_grow(args.source)


def live_samples(args: argparse.Namespace, watcher: Watcher) -> Iterator[tuple[Float, Sequence[LineNote]]]:
    """Yield samples (N, 1 + 2 J + C) as they come, now and then none, and what is to be told of lines; the watcher is
    told what stands behind their torques.
    """
    from exoid.apps.watch.io.growing import check_text, grown, piped
    from exoid.apps.watch.live import Lines
    from exoid.apps.watch.outside import stream_of
    from exoid.measurement.reading.mapping import StatedMapping
    from exoid.workbench.command_line.inputs import read
    from exoid.workbench.command_line.options import merged
    from exoid.workbench.command_line.said import say_findings

    told = StatedMapping(merged(args.map, "--map"), merged(args.units, "--units"))
    model = watcher.model

    def lines(where: str) -> Lines:
        return Lines(model.joints, told, where, model.channels)

    if args.source == PIPE:
        if sys.stdin is None or is_closed(sys.stdin):
            raise UsageError("standard input is closed", remedy="pipe samples into it, or name a file")
        yield from _lines(lines("standard input"), watcher, piped(sys.stdin.buffer))
        return
    if args.source.startswith(TOPIC):
        from exoid.apps.watch.io.joint_states import heard

        topic = args.source.removeprefix(TOPIC)
        yield from _lines(lines(topic), watcher, heard(topic))
        return
    if not Path(args.source).is_file() and not args.follow:
        from exoid.measurement.reading.sources import expand

        expand([args.source])  # says what is wrong with the name, and what is near it
    if args.follow or _may_grow(args.source):
        check_text(args.source)
        yield from _lines(lines(args.source), watcher, grown(args.source, True if args.follow else None))
        return
    found = read(args.source, told, joints=model.joints, quiet=args.quiet)
    say_findings(found, args)
    for item in found:
        rows, names = stream_of(watcher.model, item)
        watcher.measures(names)
        for first in range(0, len(rows), 1000):
            yield rows[first : first + 1000], ()


def _may_grow(source: str) -> bool:
    """True if the file is text by its name and was written to a moment ago."""
    from exoid.apps.watch.io.growing import RECENT

    path = Path(source)
    texts = (".csv", ".tsv", ".txt", ".log", ".jsonl", ".json", ".ndjson")
    young = path.is_file() and time.time() - path.stat().st_mtime < RECENT
    return path.suffix.lower() in texts[3:] or (path.suffix.lower() in texts and young)


def _lines(lines: Lines, watcher: Watcher, texts: Iterator[str | None]) -> Iterator[tuple[Float, Sequence[LineNote]]]:
    from exoid.apps.watch.live import TOLD, LineNote

    def fed(text: str | None) -> tuple[Float, Sequence[LineNote]]:
        rows = lines.feed(text or "", last=text is None)
        if lines.outside is not None:
            watcher.measures(lines.outside)
        return rows, lines.taken()

    for text in texts:
        found = fed(text)
        if text is None:
            lines.again()
        yield found
    yield fed(None)
    more = lines.skipped_count - TOLD
    if more > 0:
        yield lines.feed(""), [LineNote(lines.number, f"{more} further lines were no samples either")]
