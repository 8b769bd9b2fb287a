"""Samples as they are written: lines of CSV, or one JSON object per line, from a file that grows or a pipe.

The first line says which columns there are, in the names and units a recording may have; without names the columns are
t, q1, ..., tau1, ... A line that is no sample is passed over, and why is told.
"""

from __future__ import annotations

import codecs
import json
import math
import os
import select
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import IO

import numpy as np

from ground.errors import RecordingError
from measurement.reading.columns import assign, required
from measurement.reading.mapping import StatedMapping
from measurement.reading.raw import RawColumn, RawTable, split_unit
from symbolic.joints import LEG, Joint
from symbolic.motion import Float

LONGEST_LINE = 100_000
"""Characters; a longer line is no sample."""
POLL = 0.05
"""s between looks at a file that may grow."""
AT_ONCE = 1 << 16
"""Bytes read at a time."""
RECENT = 5.0
"""A file written to within so many seconds may still grow."""
TOLD = 5
"""Lines that are no samples which are told one by one."""


@dataclass(frozen=True)
class Skipped:
    """A line that is no sample: its number, and why."""

    line: int
    why: str


@dataclass(eq=False)
class Lines:
    """Turns text into samples; the columns are known from its first line on."""

    joints: Sequence[Joint] = LEG
    told: StatedMapping = field(default_factory=StatedMapping)
    where: str = "standard input"
    number: int = 0
    rest: str = ""
    separator: str = ""
    places: list[tuple[int | str, float]] = field(default_factory=list)
    as_json: bool | None = None
    skipped: list[Skipped] = field(default_factory=list)
    skipped_count: int = 0
    overlong: bool = False

    def again(self) -> None:
        """Begin another file: its first line says anew which columns there are."""
        self.rest, self.places, self.as_json, self.number, self.overlong = "", [], None, 0, False

    def feed(self, text: str, *, last: bool = False) -> Float:
        """Return the samples (N, 1 + 2 J: t, q, tau in SI units) of whole lines; a partial one waits for its end.

        RecordingError where the columns do not tell what a sample needs.
        """
        whole = self.rest + text
        lines = whole.split("\n")
        self.rest = "" if last else lines.pop()
        if len(self.rest) > LONGEST_LINE:
            self.rest, self.overlong = "", True
        rows = []
        for line in lines:
            self.number += 1
            if self.overlong:
                self.overlong = False
                self._skip("the line is too long")
                continue
            row = self._row(line.strip("\r \t\ufeff\0"))
            if row is not None:
                rows.append(row)
        return np.array(rows) if rows else np.zeros((0, 1 + 2 * len(self.joints)))

    def _row(self, line: str) -> list[float] | None:
        if not line or line.startswith(("#", "//")):
            return None
        if len(line) > LONGEST_LINE:
            self._skip("the line is too long")
            return None
        if self.as_json is None:
            self.as_json = line.startswith("{")
        try:
            return self._json(line) if self.as_json else self._csv(line)
        except (ValueError, TypeError, KeyError, IndexError, RecursionError) as error:
            why = f"{error} is missing" if isinstance(error, KeyError) else str(error) or "it cannot be read"
            self._skip(why)
            return None

    def _skip(self, why: str) -> None:
        self.skipped_count += 1
        if len(self.skipped) < TOLD:
            self.skipped.append(Skipped(self.number, why[:120]))

    def _json(self, line: str) -> list[float] | None:
        found = json.loads(line)
        if not isinstance(found, dict):
            raise ValueError("it is no JSON object")
        if not self.places:
            numbers = {k: v for k, v in _flat(found).items() if isinstance(v, (int, float)) and not isinstance(v, bool)}
            self._columns(list(numbers), [float(v) for v in numbers.values()])
        flat = _flat(found)
        return self._finite([(flat[str(at)], factor) for at, factor in self.places])

    def _csv(self, line: str) -> list[float] | None:
        if not self.separator or not self.places:
            self.separator = next((s for s in (";", "\t", ",") if s in line), " ")
        cells = [c.strip().strip('"') for c in (line.split() if self.separator == " " else line.split(self.separator))]
        if not self.places:
            values = [_number(cell, self.separator) for cell in cells]
            if any(v is not None for v in values):
                names = list(required(self.joints))
                if len(cells) < len(names):
                    raise ValueError(f"{len(cells)} numbers and no names of columns; {', '.join(names)} are needed")
                self.places = [(k, 1.0) for k in range(len(names))]
            else:
                self._columns(cells, [0.0] * len(cells))
                return None
        if len(cells) <= max(int(at) for at, _ in self.places):
            raise ValueError(f"it has {len(cells)} cells")
        return self._finite([(_number(cells[int(at)], self.separator), factor) for at, factor in self.places])

    def _columns(self, names: list[str], values: list[float]) -> None:
        """Settle which column is which, as in any recording."""
        by_json = bool(self.as_json)
        split = [split_unit(name) for name in names]
        table = RawTable(
            tuple(RawColumn(n, np.array([v, v + 1.0]), u) for (n, u), v in zip(split, values, strict=True)),
            np.array([1, 2]),
        )
        given = {c.name: k for k, c in enumerate(table.columns)}
        chosen = assign(table, self.told, where=self.where, joints=self.joints)
        self.places = [
            (names[given[chosen[n].column.name]] if by_json else given[chosen[n].column.name], chosen[n].factor)
            for n in required(self.joints)
        ]

    def _finite(self, cells: list[tuple[object, float]]) -> list[float]:
        row = []
        for cell, factor in cells:
            if not isinstance(cell, (int, float)) or isinstance(cell, bool) or not math.isfinite(cell):
                raise ValueError("a number is missing or not finite")
            row.append(float(cell) * factor)
        return row


def _flat(found: Mapping[str, object]) -> dict[str, object]:
    """Return a JSON object with lists taken apart: {"q": [1, 2]} becomes q1 and q2."""
    out: dict[str, object] = {}
    for key, value in found.items():
        if isinstance(value, list):
            out |= {f"{key}{k + 1}": item for k, item in enumerate(value)}
        else:
            out[str(key)] = value
    return out


def _number(text: str, separator: str) -> float | None:
    """Return a plain number, None where the text is none; a decimal comma counts where it separates nothing."""
    if separator != "," and "," in text and "." not in text:
        text = text.replace(",", ".")
    if "_" in text or not text.isascii():
        return None
    try:
        return float(text)
    except ValueError:
        return None


def piped(stream: IO[bytes]) -> Iterator[str]:
    """Yield the text of an open pipe as it comes, until it is closed; "" now and then while nothing comes."""
    descriptor = stream.fileno()
    decode = _decoder()
    while True:
        if not select.select([descriptor], [], [], 0.5)[0]:
            yield ""
            continue
        found = os.read(descriptor, AT_ONCE)
        if not found:
            return
        yield decode(found)


def grown(path: str | Path, follow: bool | None = None, idle: float = 2.0) -> Iterator[str | None]:
    """Yield the text of a file, and what is added to it; None where another file has taken its name (rotation).

    `follow` True goes on for ever, False ends at the end of the file, None where it has not grown for `idle` s and was
    not written to lately.
    """
    target = Path(path)
    decode = _decoder()
    stream: IO[bytes] = target.open("rb")
    try:
        last = time.monotonic()
        recent = time.time() - target.stat().st_mtime < RECENT
        while True:
            found = stream.read(AT_ONCE)
            if found:
                last = time.monotonic()
                yield decode(found)
                continue
            if follow is False or (follow is None and (not recent or time.monotonic() - last > idle)):
                return
            fresh = _other(target, stream)
            if fresh is not None:
                stream.close()
                stream, decode, last = fresh, _decoder(), time.monotonic()
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


def _decoder() -> Callable[[bytes], str]:
    return codecs.getincrementaldecoder("utf-8")("replace").decode


def check_text(path: str | Path) -> None:
    """Refuse what cannot be followed line by line; RecordingError."""
    with Path(path).open("rb") as stream:
        if b"\0" in stream.read(4096):
            raise RecordingError(
                "this is no text, so it cannot be followed line by line", where=str(path), remedy="leave --follow out"
            )
