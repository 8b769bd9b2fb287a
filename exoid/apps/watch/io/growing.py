"""Text as it is written: from a pipe, or from a file that grows and may be rotated, in any of the usual encodings."""

from __future__ import annotations

import codecs
import io
import os
import select
import time
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Protocol

from exoid.ground.errors import RecordingError
from exoid.measurement.reading.sniff import BOMS

POLL = 0.05
"""s between looks at a file that may grow."""
AT_ONCE = 1 << 16
"""Bytes read at a time."""
RECENT = 5.0
"""A file written to within so many seconds may still grow."""
HEAD = 4
"""Bytes from which the encoding is told."""


class _Decoder(Protocol):
    def decode(self, data: bytes, /) -> str: ...


class Text:
    """Bytes that come in pieces, as text with LF line ends; a mark at the beginning, or zero bytes, tell UTF-16."""

    def __init__(self) -> None:
        self.head = b""
        self.decoder: _Decoder | None = None

    def decode(self, data: bytes) -> str:
        """Return the text that `data` completes."""
        if self.decoder is None:
            self.head += data
            if len(self.head) < HEAD:
                return ""
            data = self.head
            inner = codecs.getincrementaldecoder(encoding(data))("replace")
            self.decoder = io.IncrementalNewlineDecoder(inner, translate=True)
        return self.decoder.decode(data)


def encoding(head: bytes) -> str:
    """Return the encoding of a text that begins with `head`."""
    for mark, name in BOMS:
        if head.startswith(mark):
            return name
    if len(head) >= HEAD and 0 not in head[:HEAD:2] and not any(head[1:HEAD:2]):
        return "utf-16-le"
    if len(head) >= HEAD and 0 not in head[1:HEAD:2] and not any(head[:HEAD:2]):
        return "utf-16-be"
    return "utf-8"


def piped(stream: IO[bytes]) -> Iterator[str]:
    """Yield the text of an open pipe as it comes, until it is closed; "" now and then while nothing comes."""
    descriptor = stream.fileno()
    text = Text()
    while True:
        if not select.select([descriptor], [], [], 0.5)[0]:
            yield ""
            continue
        found = os.read(descriptor, AT_ONCE)
        if not found:
            return
        yield text.decode(found)


def grown(path: str | Path, follow: bool | None = None, idle: float = 2.0) -> Iterator[str | None]:
    """Yield the text of a file, and what is added to it; None where another file has taken its name (rotation).

    `follow` True goes on for ever, False ends at the end of the file, None where it has not grown for `idle` s and was
    not written to lately.
    """
    target = Path(path)
    text = Text()
    stream: IO[bytes] = target.open("rb")
    try:
        last = time.monotonic()
        recent = time.time() - target.stat().st_mtime < RECENT
        while True:
            found = stream.read(AT_ONCE)
            if found:
                last = time.monotonic()
                yield text.decode(found)
                continue
            if follow is False or (follow is None and (not recent or time.monotonic() - last > idle)):
                return
            fresh = _other(target, stream)
            if fresh is not None:
                stream.close()
                stream, text, last = fresh, Text(), time.monotonic()
                yield None
                continue
            time.sleep(POLL)
            yield ""
    finally:
        stream.close()


def _other(path: Path, stream: IO[bytes]) -> IO[bytes] | None:
    """Return the file that has taken the place of `stream`, None where it is still the same and no shorter."""
    try:
        there, open_ = path.stat(), os.fstat(stream.fileno())
    except OSError:
        return None  # between two files; the next look will tell
    if (there.st_dev, there.st_ino) == (open_.st_dev, open_.st_ino) and there.st_size >= stream.tell():
        return None
    try:
        return path.open("rb")
    except OSError:
        return None


def check_text(path: str | Path) -> None:
    """Refuse what cannot be followed line by line; RecordingError."""
    with Path(path).open("rb") as stream:
        head = stream.read(4096)
        if encoding(head).startswith("utf-8") and b"\0" in head.rstrip(b"\0"):
            what = "this is no text, so it cannot be followed line by line"
            raise RecordingError(what, where=str(path), remedy="leave --follow out")
