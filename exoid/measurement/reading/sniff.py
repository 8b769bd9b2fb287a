"""The layout of a text table: encoding, delimiter, decimal mark, preamble, header, unit row."""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import zip_longest

from exoid.ground.errors import NoNumbersError, RecordingError
from exoid.measurement.finding import Finding
from exoid.measurement.reading.names import recognise
from exoid.measurement.reading.raw import split_unit, ungrouped
from exoid.measurement.reading.units import is_unit

LONGEST_LINE = 100_000
HEAD_LINES = 400
"""A preamble of instrument settings longer than this has not been seen."""
LEAST_ROWS = 20
"""Lines alike from which words with a number among them are a table."""
COMMENTS = ("#", "%", "//")
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?|[+-]?(inf|infinity|nan)|", re.IGNORECASE)
POINTS = re.compile(r"[+-]?[1-9]\d{0,2}(\.\d{3})+,\d*", re.ASCII)
"""A number with points between the thousands and a decimal comma."""
AXES = ("X", "Y", "Z")
FLEXION = "of the components X, Y and Z, X is read as flexion, as Plug-in Gait and Visual3D count them"
AXIS_OR_UNIT = re.compile(r"[XYZ]|[\[(][^\])]*[\])]", re.IGNORECASE)
"""A name that says an axis or a unit, and not of what."""
BOMS = (
    (b"\xff\xfe\x00\x00", "utf-32"),
    (b"\x00\x00\xfe\xff", "utf-32"),
    (b"\xef\xbb\xbf", "utf-8-sig"),
    (b"\xff\xfe", "utf-16"),
    (b"\xfe\xff", "utf-16"),
)


@dataclass(frozen=True)
class Layout:
    """The place of the numbers and how to cut them: `names` and `units` per column, `first_line` counted from 1."""

    delimiter: str
    decimal: str
    names: tuple[str, ...]
    units: tuple[str, ...]
    body_start: int
    first_line: int
    notes: tuple[Finding, ...] = ()


def decode(data: bytes, *, where: str) -> tuple[str, tuple[Finding, ...]]:
    """Return the text of `data` with LF line ends, and what had to be decided about its encoding."""
    if not data.strip(b"\x00 \t\r\n"):
        what = "the file is empty" if not data else "the file holds nothing but blanks"
        raise NoNumbersError(what, where=where, remedy="record again, or check that the copy was complete")
    encoding = next((name for bom, name in BOMS if data.startswith(bom)), "")
    notes: list[Finding] = []
    if not encoding:
        head = data[:4000]
        if head[1::2].count(0) > 0.3 * len(head):
            encoding = "utf-16-le"
        elif head[0::2].count(0) > 0.3 * len(head):
            encoding = "utf-16-be"
    if not encoding and data.endswith(b"\x00"):
        kept = data.rstrip(b"\x00")
        what = f"the file ends in {len(data) - len(kept)} zero bytes, as after a power cut; they are passed over"
        notes.append(Finding("cells", "repaired", what, where))
        data = kept
    try:
        text = data.decode(encoding or "utf-8")
    except UnicodeDecodeError:
        text = data.decode(encoding, "replace") if encoding else data.decode("latin-1")
    head_text = text[:4000]
    strange = sum(
        1 for c in head_text if (ord(c) < 32 and c not in "\t\r\n\f\v") or 0x7F <= ord(c) < 0xA0 or c == "\ufffd"
    )
    if strange > 0.02 * len(head_text):
        remedy = "give a CSV, TSV, NPZ, MAT, HDF5 or Parquet file under its proper suffix"
        raise RecordingError("this is not a text table: it holds binary data", where=where, remedy=remedy)
    text = text.lstrip("\ufeff")
    if "\u2212" in text:
        text = text.replace("\u2212", "-")  # the minus of typography
    if "\r" in text:
        text = text.replace("\r\n", "\n").replace("\r", "\n")
    return text.rstrip("\n \x1a") + "\n", tuple(notes)


def split_line(line: str, delimiter: str) -> list[str]:
    """Return the cells of one line, stripped, quotes resolved; a blank as delimiter means any white space."""
    if delimiter == " ":
        return line.split()
    if '"' not in line:
        return [cell.strip() for cell in line.split(delimiter)]
    try:
        return [cell.strip() for cell in next(csv.reader([line], delimiter=delimiter, skipinitialspace=True), [])]
    except csv.Error:
        return [cell.strip().strip('"') for cell in line.split(delimiter)]


def is_number(cell: str, decimal: str) -> bool:
    """True if `cell` is empty or a number written with this decimal mark."""
    if decimal == ",":
        if "." in cell and not POINTS.fullmatch(cell):
            return False
        cell = cell.replace(".", "").replace(",", ".")
    return NUMBER.fullmatch(cell) is not None or NUMBER.fullmatch(ungrouped(cell)) is not None


def sniff(text: str, *, where: str) -> Layout:
    """Return the layout of `text`; raises RecordingError when no line holds two numbers or more.

    Every delimiter is tried with both decimal marks; the one under which most of the first lines are rows of
    numbers of one and the same width wins, ties going to the usual one (comma, point).
    """
    lines = list(_lines(text))
    longest = max((len(line) for _, _, line in lines), default=0)
    if longest > LONGEST_LINE:
        what = f"one line has {longest} characters: this is not a table with one row per sample"
        remedy = "write one line per sample; if time runs across the lines, transpose the table"
        raise RecordingError(what, where=where, remedy=remedy)
    table = [entry for entry in lines if entry[2].strip() and not entry[2].lstrip().startswith(COMMENTS)]
    best: tuple[int, int, str, str] = (0, 0, "", "")
    cut: dict[str, list[list[str]]] = {}
    for delimiter, decimal in (
        (",", "."),
        (";", "."),
        ("\t", "."),
        (";", ","),
        ("\t", ","),
        (" ", "."),
        (" ", ","),
        ("|", "."),
        (",", ","),
    ):
        # A comma is both only where numbers stand in quotes.
        if (delimiter.strip() and delimiter not in text) or (delimiter == decimal and '"' not in text):
            continue
        if delimiter not in cut:
            cut[delimiter] = [split_line(entry[2], delimiter) for entry in table]
        widths = [
            len(cells)
            for cells in cut[delimiter]
            if len(cells) > 1 and (_is_full(cells, decimal) or _is_sparse(cells, decimal))
        ]
        width = max(set(widths), key=widths.count, default=0)
        if (widths.count(width), width) > best[:2]:
            best = (widths.count(width), width, delimiter, decimal)
    count, width, delimiter, decimal = best
    few = not count
    if few:
        count, width, delimiter, decimal = _mostly_words(cut, len(table))
    if not count:
        remedy = "the file needs one header line (t, q1, q2, tau1, tau2) and one row of numbers per sample"
        raise NoNumbersError("no rows of numbers were found", where=where, remedy=remedy)
    return _header(lines, table, cut[delimiter], width, delimiter, decimal, where, few)


def _mostly_words(cut: Mapping[str, list[list[str]]], count: int) -> tuple[int, int, str, str]:
    """Return (rows, width, delimiter, decimal mark) of a table with one value a row and several words beside it; none
    where lines are not alike, as those of a text.
    """
    for delimiter, decimal in ((",", "."), (";", "."), ("\t", "."), (";", ","), ("\t", ",")):
        rows = cut.get(delimiter, [])
        width = max((len(cells) for cells in rows), default=0)
        alike = [cells for cells in rows if len(cells) == width]
        if width < 3 or len(alike) < max(LEAST_ROWS, 0.9 * count):
            continue
        numbers = (sum(bool(cells[k]) and is_number(cells[k], decimal) for cells in alike) for k in range(width))
        if max(numbers) > 0.6 * len(alike):
            return len(alike), width, delimiter, decimal
    return 0, 0, "", ""


def _lines(text: str) -> Iterator[tuple[int, int, str]]:
    """Yield (line number, character offset, line) of the first lines."""
    offset = 0
    for number in range(1, HEAD_LINES + 1):
        end = text.find("\n", offset)
        if end < 0:
            return
        yield number, offset, text[offset:end]
        offset = end + 1


def _header(
    lines: list[tuple[int, int, str]],
    table: list[tuple[int, int, str]],
    cut: list[list[str]],
    width: int,
    delimiter: str,
    decimal: str,
    where: str,
    few: bool,
) -> Layout:
    """Find the first row of numbers and, above it, the unit row and the names; `cut` are the cells of `table`, `few` of
    which are numbers where that is so.
    """
    if few:
        full = (i for i, row in enumerate(cut) if len(row) == width and any(c and is_number(c, decimal) for c in row))
    else:
        full = (i for i, cells in enumerate(cut) if len(cells) >= min(width, 2) and _is_full(cells, decimal))
    first = next(full, len(cut))
    while first > 0 and len(cut[first - 1]) == width and _is_sparse(cut[first - 1], decimal):
        first -= 1  # the first rows of a channel may be empty
    above = cut[:first]
    if not above:
        # np.savetxt and MATLAB write the names as a comment
        comments = [e[2].lstrip(" \t#%/") for e in lines if e[0] < table[first][0] and e[2].strip()]
        named = [cells for cells in (split_line(c, delimiter) for c in comments) if len(cells) == width]
        named = named or [cells for cells in (re.split(r"[,;\s]+", c.strip()) for c in comments) if len(cells) == width]
        above = named[-1:]
    rows = cut[first:]
    open_end = sum(len(cells) == width and not cells[-1] for cells in rows) > len(rows) / 2
    usable = [cells for cells in above if _trimmed(cells, width, open_end) is not None]
    names = _trimmed(usable[-1], width, open_end) if usable else None
    short = above[-1] if above and names is None else []
    if sum(recognise(cell) is not None for cell in short) >= 2:
        raise RecordingError(
            f"the header has {len(short)} names, the rows have {width} cells",
            where=f"{where}, row {table[first][0]}",
            remedy="name every column (also row numbers); or is the delimiter also the decimal comma? Then export "
            "with a decimal point or with semicolons",
        )
    units = [""] * width
    if len(usable) >= 2 and names is not None and _is_unit_row(names) and not _is_unit_row(usable[-2]):
        units = [cell.strip("[]() ") for cell in names]
        names = _trimmed(usable[-2], width, open_end)
    notes: tuple[Finding, ...] = ()
    if names is None:
        names = [str(i + 1) for i in range(width)]
        what = "the file has no line of column names; its columns are called 1, 2, 3, ..."
        notes = (Finding("format", "info", what, where, remedy="say which is which: --map t=1,q1=2"),)
    else:
        names, axes = under_groups(names, [cells for cells in above if not _is_unit_row(cells)])
        if axes:
            notes = (Finding("format", "info", FLEXION, where, remedy="if it is not: --map q1=COLUMN"),)
    pairs = [split_unit(name) for name in names]
    number, offset, _ = table[first]
    return Layout(
        delimiter,
        decimal,
        tuple(name for name, _ in pairs),
        tuple(unit or given for (_, unit), given in zip(pairs, units, strict=True)),
        offset,
        number,
        notes,
    )


def _is_full(cells: list[str], decimal: str) -> bool:
    """True if most cells are numbers."""
    return sum(bool(c) and is_number(c, decimal) for c in cells) > 0.6 * len(cells)


def _is_sparse(cells: list[str], decimal: str) -> bool:
    """True if all cells that are not empty are numbers, two at least."""
    filled = [c for c in cells if c]
    return len(filled) >= 2 and all(is_number(c, decimal) for c in filled)


def under_groups(names: list[str], above: list[list[str]]) -> tuple[list[str], bool]:
    """Return `names` with those of the rows above, where they stand several times, are empty or only an axis or a unit;
    and whether there are axes. A cell that is empty there belongs to the group before it.
    """
    axes = False
    for row in reversed(above):
        weak = {i for i, name in enumerate(names) if names.count(name) > 1 or not name or AXIS_OR_UNIT.fullmatch(name)}
        if not weak or len(set(filter(None, row))) < 2 or len(row) > len(names) or row == names:
            continue
        joined, group = list(names), ""
        for i, (name, cell) in enumerate(zip_longest(names, row, fillvalue="")):
            group = cell or (group if name else "")
            if i in weak and group:
                axis = name.upper() in AXES
                axes = axes or axis
                said = name.upper() == AXES[0] or group.lower().endswith(name.lower())
                joined[i] = group if said else f"{group} {name}"
        names = joined if len(set(joined)) > len(set(names)) else names
    return names, axes


def _trimmed(cells: list[str], width: int, open_end: bool) -> list[str] | None:
    """Return `cells` cut or filled to `width` when it can be a header of that width, else None.

    A header may be one name short only when the rows end in a delimiter (`open_end`); otherwise their first
    cell may be a row name, and every column would be taken for its neighbour.
    """
    while len(cells) > width and not cells[-1]:
        cells = cells[:-1]
    if len(cells) == width - 1 and open_end:
        cells = [*cells, ""]
    return cells if len(cells) == width and any(cells) else None


def _is_unit_row(cells: list[str]) -> bool:
    """True if most cells are units of some quantity."""
    filled = [cell for cell in cells if cell]
    return bool(filled) and sum(is_unit(cell.strip("[]() ")) for cell in filled) > 0.6 * len(filled)
