"""Samples as they are written: lines of CSV, or one JSON object per line, from a file that grows or a pipe.

Which columns there are is said by the lines above the first row of numbers, in the names and units a recording may
have; without names they are t, q1, ..., tau1, ... A logger that starts again says so anew, and is believed. A line that
is no sample is passed over, and why is told.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.measurement.reading import clock
from exoid.measurement.reading.columns import assign, required
from exoid.measurement.reading.mapping import StatedMapping
from exoid.measurement.reading.names import recognise
from exoid.measurement.reading.outside import CONTACT, force_columns
from exoid.measurement.reading.raw import MISSING, RawColumn, RawTable, split_unit
from exoid.measurement.reading.sniff import COMMENTS, HEAD_LINES, LONGEST_LINE, sniff, split_line
from exoid.measurement.reading.units import is_unit
from exoid.symbolic.joints import LEG, Joint
from exoid.symbolic.motion import Float

TOLD = 5
"""Lines that are no samples which are told one by one."""
CLOCK_ROWS = 20
"""Samples from which the unit of a clock is told that nobody stated."""
SLOW = 0.5
"""Step of the clock from which its unit is in question: fewer samples in a second say nothing of a motion."""


@dataclass(frozen=True)
class LineNote:
    """A note about a line: that it is no sample ("skipped"), or that it says anew what the columns are ("columns");
    `before` samples of the same portion came before it.
    """

    line: int
    what: str
    event: str = "skipped"
    before: int = 0


_Places = tuple[tuple[tuple[int | str, ...], float], ...]


@dataclass(frozen=True)
class _Layout:
    """The places of a sample's numbers: `places` are keys of a JSON object, or indices of the `width` cells of a line,
    of which the product is meant, with factors to SI; `said` is that in words.
    """

    places: _Places
    said: str
    delimiter: str = ""
    comma: bool = False
    width: int = 0
    clock_told: bool = False

    def lacking(self, found: Mapping[str, object]) -> str:
        """Return the first key of a sample that an object does not have, "" where it has all."""
        return next((str(key) for keys, _ in self.places for key in keys if key not in found), "")


@dataclass(eq=False)
class Lines:
    """Turns text into samples; `notes` are what is to be told of its lines."""

    joints: Sequence[Joint] = LEG
    told: StatedMapping = field(default_factory=StatedMapping)
    where: str = "standard input"
    forces: tuple[str, ...] = ()
    """Columns of forces that there must be."""
    outside: tuple[str, ...] | None = None
    """Columns behind the torques of a sample: all of what acts from outside that the first lines name."""
    number: int = 0
    rest: str = ""
    layout: _Layout | None = None
    lost: str = ""
    """Why no line can be read until the columns are named again."""
    above: list[tuple[int, str]] = field(default_factory=list)
    """Lines without numbers, with their own: names and units of the rows that follow, or nothing."""
    held: list[list[float]] = field(default_factory=list)
    per_second: float | None = None
    """s in one unit of the clock; None until that is known."""
    notes: list[LineNote] = field(default_factory=list)
    skipped_count: int = 0
    count: int = 0
    overlong: bool = False

    def again(self) -> None:
        """Begin another file: it says anew which columns there are."""
        self.rest, self.number, self.overlong = "", 0, False
        self.layout, self.lost, self.above, self.held, self.per_second = None, "", [], [], None

    @property
    def wanted(self) -> tuple[str, ...]:
        """The names of all numbers of a sample."""
        return (*required(self.joints), *(self.forces if self.outside is None else self.outside))

    def taken(self) -> list[LineNote]:
        """Return the notes to be told, each once."""
        notes, self.notes = self.notes, []
        return notes

    def feed(self, text: str, *, last: bool = False) -> Float:
        """Return the samples (N, C: t, q, tau, `outside`, in SI units) of whole lines; a partial one waits for its end.

        What a cell marks as missing, or as no finite number, is NaN or infinite. RecordingError where the columns do
        not tell what a sample needs, or the clock cannot be read.
        """
        lines = (self.rest + text).split("\n")
        self.rest = "" if last else lines.pop()
        if len(self.rest) > LONGEST_LINE:
            self.rest, self.overlong = "", True
        rows: list[list[float]] = []
        self.count = 0
        for line in lines:
            self.number += 1
            self.count = len(rows)
            if self.overlong:
                self.overlong = False
                self._skip("the line is too long")
                continue
            row = self._row(line.strip("\r \t\ufeff\0"))
            if row is not None:
                rows.append(row)
        if last:
            self._pass_over()
        return self._timed(rows, last)

    def _row(self, line: str) -> list[float] | None:
        if len(line) > LONGEST_LINE:
            self._skip("the line is too long")
            return None
        if not line:
            return None
        try:
            return self._json(line) if line.startswith("{") else self._csv(line)
        except (ValueError, TypeError, KeyError, IndexError, RecursionError, ArithmeticError) as error:
            why = f"{error} is missing" if isinstance(error, KeyError) else str(error) or "it cannot be read"
            self._skip(why)
            return None

    def _skip(self, why: str, line: int | None = None) -> None:
        self.skipped_count += 1
        if self.skipped_count <= TOLD:
            self.notes.append(LineNote(line or self.number, why[:120], before=self.count))

    def _pass_over(self) -> None:
        """Tell lines without numbers that named nothing."""
        for number, line in self.above:
            if not line.startswith(COMMENTS):
                self._skip("it is no sample, and names no columns", number)
        self.above = []

    # -- one JSON object per line -----------------------------------------------------------------------------

    def _json(self, line: str) -> list[float] | None:
        found = json.loads(line)
        if not isinstance(found, dict):
            raise ValueError("it is no JSON object")
        flat = _flat(found)
        own = self.layout if self.layout is not None and not self.layout.delimiter else None
        if own is None or own.lacking(flat):
            names = [k for k, v in flat.items() if v is None or (_is_number(v))]
            if not self._settle(names, [""] * len(names), _Layout((), "")):
                lacking = own.lacking(flat) if own else ""
                raise KeyError(lacking) if lacking else ValueError(self.lost or "it names no columns of a sample")
            own = self.layout
        assert own is not None
        row = []
        for keys, factor in own.places:
            for key in keys:
                value = flat[str(key)]
                if value is not None and not _is_number(value):
                    raise ValueError(f"{key} is no number")
                factor *= np.nan if value is None else float(value)  # type: ignore[arg-type]
            row.append(factor)
        return row

    # -- rows of cells ----------------------------------------------------------------------------------------

    def _csv(self, line: str) -> list[float] | None:
        own = self.layout if self.layout is not None and self.layout.delimiter else None
        comment = line.startswith(COMMENTS)
        if own is not None and not self.above and not comment:
            row = self._numbers(line, own)
            if row is not None:
                return row
        if comment or not _is_row(line):
            self._keep(line, comment)
            return None
        if own is None or self.above:
            self._begin(line)
            own = self.layout if self.layout is not None and self.layout.delimiter else None
        if own is None:
            raise ValueError(self.lost or "it names no columns of a sample")
        row = self._numbers(line, own)
        if row is None:
            cells = len(split_line(line, own.delimiter))
            differ = f"it has {cells} cells where there are {own.width} columns"
            raise ValueError(differ if cells != own.width else "a number cannot be read")
        return row

    def _keep(self, line: str, comment: bool) -> None:
        """Keep a line without numbers that may name the columns of the rows that follow."""
        known = _known(line, self.joints)
        if comment and known < 2:
            return
        cells = _most_cells(line)
        if len(cells) < len(required(self.joints)) and not known and not all(map(is_unit, cells)):
            self._skip("it is no sample, and names no columns")
            return
        self.above.append((self.number, line))
        if len(self.above) > HEAD_LINES:
            self._pass_over()

    def _begin(self, line: str) -> None:
        """Read the names above a row of numbers, as those above a table; without any, all stays as it was."""
        known = self.layout is not None or bool(self.lost)
        # A comment that names columns stands for all above it; it counts only where it is the last that does.
        naming = [text for _, text in self.above if _known(text, self.joints) >= 2]
        if naming and naming[-1].startswith(COMMENTS):
            above = naming[-1:]
        else:
            above = [text for _, text in self.above if not text.startswith(COMMENTS)]
        try:
            found = sniff("\n".join([*above, line, ""]), where=self.where)
        except RecordingError as error:
            if not known:
                raise
            self.layout, self.lost, self.above = None, str(error), []
            return
        plain = _Layout((), "", found.delimiter, found.decimal == ",", len(found.names))
        named = not all(name.isdecimal() for name in found.names)
        if named or (self.told.columns and not known):
            if self._settle(list(found.names), list(found.units), plain) or self.lost:
                self.above = []
            elif not known:
                raise ValueError("it names no columns of a sample")
        elif not known:
            wanted = self.wanted
            if len(found.names) < len(wanted):
                raise ValueError(f"{len(found.names)} numbers and no names of columns; {', '.join(wanted)} are needed")
            self.outside = self.forces
            self._become(plain, tuple(((k,), 1.0) for k in range(len(wanted))), "", told=False)
        self._pass_over()

    def _numbers(self, line: str, own: _Layout) -> list[float] | None:
        """Return the numbers of a row, None where a cell of it is something else or it has other cells."""
        cells = split_line(line, own.delimiter)
        while len(cells) > own.width and not cells[-1]:
            cells.pop()
        if len(cells) != own.width:
            return None
        row = []
        for places, factor in own.places:
            for at in places:
                value = _number(cells[int(at)], own.comma or own.delimiter != ",")
                if value is None:
                    return None
                factor *= value
            row.append(factor)
        return row

    # -- which column is which --------------------------------------------------------------------------------

    def _settle(self, names: list[str], units: list[str], plain: _Layout) -> bool:
        """Settle which column is which, as in any recording; False where these are no names of columns.

        RecordingError where they are, do not suffice, and nothing has been read before.
        """
        split = [split_unit(name) for name in names]
        columns = (
            RawColumn(n, np.array([0.0, 1.0]), unit or u) for (n, u), unit in zip(split, units, strict=True)
        )
        table = RawTable(tuple(columns), np.array([1, 2]))
        given = {id(c): k for k, c in enumerate(table.columns)}
        try:
            chosen = assign(table, self.told, where=self.where, joints=self.joints)
            self._look_outside(chosen)
        except RecordingError as error:
            meant = sum(recognise(n, tuple(self.joints)) is not None for n, _ in split) >= 2
            if self.layout is None and not self.lost and (meant or plain.delimiter):
                raise
            if meant and plain.delimiter:
                self.layout, self.lost = None, str(error)
            return False
        wanted = self.wanted
        formula = next((n for n in wanted if not chosen[n].column.factors and id(chosen[n].column) not in given), None)
        if formula:
            what = f"{formula} is a formula, and of a stream only columns and their products are read"
            raise RecordingError(what, where=self.where, remedy="write what it comes to into the stream")
        parts = {n: [given[id(c)] for c in chosen[n].column.factors or (chosen[n].column,)] for n in wanted}
        places = tuple(
            (tuple(k if plain.delimiter else names[k] for k in at), chosen[n].factor) for n, at in parts.items()
        )
        words = {n: "*".join(names[k] for k in at) for n, at in parts.items()}
        said = ", ".join(f"{n} from {words[n]!r} in {chosen[n].unit}" for n in wanted)
        self._become(plain, places, said, told=chosen["t"].told)
        return True

    def _look_outside(self, chosen: Mapping[str, object]) -> None:
        """Settle once for all which columns stand behind the torques; RecordingError where one is missing."""
        for name in self.forces if self.outside is None else self.outside:
            if name not in chosen:
                remedy = f"--map {name}=COLUMN, or leave the force out of the model file"
                raise RecordingError(f"there is no column of the force {name}", where=self.where, remedy=remedy)
        if self.outside is None:
            self.outside = tuple(name for name in (*force_columns(self.joints), CONTACT) if name in chosen)

    def _become(
        self, plain: _Layout, places: _Places, said: str, *, told: bool
    ) -> None:
        """Read by this layout from here on; tell so where another one was read by before."""
        before = self.layout
        self.layout = _Layout(places, said, plain.delimiter, plain.comma, plain.width, told)
        if self.lost or (before is not None and before != self.layout):
            self.notes.append(LineNote(self.number, f"the columns are named anew: {said}", "columns", self.count))
            self.per_second, self.held = None, []
        self.lost = ""

    # -- the clock --------------------------------------------------------------------------------------------

    def _timed(self, rows: list[list[float]], last: bool) -> Float:
        """Return samples with their time in s; they wait while the unit of the clock is in question."""
        rows = self.held + rows
        self.held = []
        out = np.array(rows) if rows else np.zeros((0, len(self.wanted)))
        if self.layout is not None and self.layout.clock_told:
            return out
        if self.per_second is None:
            usable = out[np.isfinite(out).all(axis=1)]
            step = np.abs(np.diff(usable[:, 0]))
            if step.size and step.min() < SLOW:
                self.per_second = 1.0
            elif len(usable) < CLOCK_ROWS and len(rows) < 50 * CLOCK_ROWS and not last:
                self.held = rows
                return out[:0]
            elif len(usable) > 2:
                self.per_second = self._clock(usable)
        out[:, 0] *= self.per_second or 1.0
        return out

    def _clock(self, rows: Float) -> float:
        unit, scale = clock.epoch_unit(rows[:, 0]) or clock.clock_unit(rows[:, 0], rows[:, 1 : 1 + len(self.joints)])
        if unit == "index":
            raise RecordingError(
                "the time counts 0, 1, 2, ...: milliseconds at 1 kHz or row numbers?", where=self.where,
                remedy="say what one count is: --units t=ms, or --units 't=10 ms' for a row every 10 ms",
            )  # fmt: skip
        if unit != "s":
            step = float(np.median(np.diff(rows[:, 0])))
            what = f"the time steps by {step:.4g}, impossible in seconds for these angles: it is read in {unit}"
            self.notes.append(LineNote(self.number, what, "columns", self.count))
        return scale


def _most_cells(line: str) -> list[str]:
    return max((split_line(line.lstrip(" #%/"), delimiter) for delimiter in (",", ";", "\t", "|", " ")), key=len)


def _known(line: str, joints: Sequence[Joint]) -> int:
    """Number of cells of a line that name columns a recording may have."""
    return sum(recognise(split_unit(cell)[0], tuple(joints)) is not None for cell in _most_cells(line))


def _is_row(line: str) -> bool:
    """True if most cells of a line are numbers, with any delimiter."""
    try:
        sniff(line + "\n", where="")
    except RecordingError:
        return False
    return True


def _flat(found: Mapping[str, object]) -> dict[str, object]:
    """Return a JSON object with lists taken apart: {"q": [1, 2]} becomes q1 and q2."""
    out: dict[str, object] = {}
    for key, value in found.items():
        if isinstance(value, list):
            out |= {f"{key}{k + 1}": item for k, item in enumerate(value)}
        else:
            out[str(key)] = value
    return out


def _is_number(value: object) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def _number(text: str, comma: bool) -> float | None:
    """Return a number, NaN where it is said to be missing, None where it is text; a decimal `comma` may count."""
    if comma and "," in text and "." not in text:
        text = text.replace(",", ".")
    try:
        if "_" in text or not text.isascii():
            return None
        return float(text)
    except ValueError:
        return np.nan if text.lower() in MISSING else None
