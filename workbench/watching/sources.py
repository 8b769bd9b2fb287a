"""Where samples come from: a recording, a file that grows, a pipe, a topic of ROS 2."""

from __future__ import annotations

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from exoid.workbench.command_line.parser import UsageError

if TYPE_CHECKING:
    from exoid.measurement.reading.live import LineNote, Lines
    from exoid.symbolic.model import Model
    from exoid.symbolic.motion import Float

PIPE, TOPIC = "-", "ros2:"
"""What a source is called that is standard input; with what one begins that is a topic."""


def is_live(args: argparse.Namespace) -> bool:
    """Return whether samples come as they are measured, so that there may be none for a while."""
    return args.source == PIPE or args.source.startswith(TOPIC) or args.follow or _may_grow(args.source)


def live_samples(args: argparse.Namespace, model: Model) -> Iterator[tuple[Float, Sequence[LineNote]]]:
    """Yield samples (N, 1 + 2 J) as they come, now and then none, and what is to be told of lines."""
    import numpy as np

    from exoid.measurement.reading.growing import check_text, grown, piped
    from exoid.measurement.reading.live import Lines
    from exoid.measurement.reading.mapping import StatedMapping
    from exoid.workbench.command_line.inputs import read
    from exoid.workbench.command_line.options import merged

    told = StatedMapping(merged(args.map, "--map"), merged(args.units, "--units"))
    if args.source == PIPE:
        if sys.stdin is None:
            raise UsageError("standard input is closed", remedy="pipe samples into it, or name a file")
        yield from _lines(Lines(model.joints, told), piped(sys.stdin.buffer))
        return
    if args.source.startswith(TOPIC):
        from exoid.workbench.watching.joint_states import heard

        topic = args.source.removeprefix(TOPIC)
        yield from _lines(Lines(model.joints, told, where=topic), heard(topic))
        return
    if not Path(args.source).is_file() and not args.follow:
        from exoid.measurement.reading.sources import expand

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
    from exoid.measurement.reading.growing import RECENT

    path = Path(source)
    texts = (".csv", ".tsv", ".txt", ".log", ".jsonl", ".json", ".ndjson")
    young = path.is_file() and time.time() - path.stat().st_mtime < RECENT
    return path.suffix.lower() in texts[3:] or (path.suffix.lower() in texts and young)


def _lines(lines: Lines, texts: Iterator[str | None]) -> Iterator[tuple[Float, Sequence[LineNote]]]:
    from exoid.measurement.reading.live import TOLD, LineNote

    for text in texts:
        rows = lines.feed(text or "", last=text is None)
        if text is None:
            lines.again()
        yield rows, lines.taken()
    yield lines.feed("", last=True), lines.taken()
    more = lines.skipped_count - TOLD
    if more > 0:
        yield lines.none, [LineNote(lines.number, f"{more} further lines were no samples either")]
