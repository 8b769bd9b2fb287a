"""Named columns as they stand in a file, before anybody has decided what they mean."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from datetime import datetime, timedelta
from typing import Any

import numpy as np
from numpy.typing import NDArray

from exoid.ground.errors import NoNumbersError
from exoid.measurement.finding import Finding
from exoid.measurement.reading.names import FILLERS, FOREIGN, SIDE_WORDS, words_in
from exoid.measurement.reading.stamps import seconds, since_first
from exoid.measurement.reading.units import is_unit
from exoid.symbolic.motion import Float


@dataclass(frozen=True, eq=False)
class RawColumn:
    """One column: `values` (N,) with NaN where the cell is empty or not a number.

    `texts` are the cells that hold something else than a number: {index: cell}, at most the first twenty;
    `text_count` is how many there are. `unit` comes from the header, a unit row or an attribute ("" if
    unsaid).
    """

    name: str
    values: Float
    unit: str = ""
    texts: Mapping[int, str] = field(default_factory=dict)
    text_count: int = 0
    rank: int = 0
    """Where several columns could be the same quantity, the one of smaller rank is taken."""
    factors: tuple[RawColumn, ...] = ()
    """The columns of the file of which this one is the product, where it is one."""
    labels: Sequence[str] = ()
    """Every cell, where they are the names of what stands in the rows."""


@dataclass(frozen=True, eq=False)
class RawTable:
    """The columns of one file; `row` (N,) is where each sample stands in it, `notes` what the reader had to
    decide, `others` what the file holds that is no column of numbers."""

    columns: tuple[RawColumn, ...]
    row: NDArray[np.int64]
    notes: tuple[Finding, ...] = ()
    others: tuple[str, ...] = ()

    @property
    def names(self) -> list[str]:
        """Column names in the order of the file."""
        return [column.name for column in self.columns]


def column_from_cells(name: str, cells: Any, unit: str = "") -> RawColumn:
    """Return a column from an array (N,) of numbers or of cells of any kind; what is not a number becomes
    NaN.

    A column of dates, clock times or durations becomes seconds since its first stamp.
    """
    if not isinstance(cells, np.ndarray):
        cells = np.fromiter(cells, dtype=object, count=len(cells))
    if cells.dtype.kind in "iuf":
        return RawColumn(name, np.asarray(cells, dtype=float), unit)
    if cells.dtype.kind in "mM":
        return RawColumn(name, since_first(cells), "s")
    there = [cell for cell in cells if cell is not None and cell == cell]
    if there and all(isinstance(cell, NUMERIC) and not isinstance(cell, bool) for cell in there):
        return RawColumn(name, np.array([np.nan if cell is None else cell for cell in cells], dtype=float), unit)
    if there and all(isinstance(cell, (datetime, timedelta, np.datetime64, np.timedelta64)) for cell in there):
        return RawColumn(name, since_first(cells), "s")
    texts = ["" if cell is None or cell != cell else str(cell).strip() for cell in cells]
    values = _all_numbers(texts)
    if values is not None:
        return RawColumn(name, values, unit)
    stamps = seconds(texts)
    if stamps is not None:
        return RawColumn(name, stamps, "s")
    values = np.array([_number(text) for text in texts], dtype=float)
    wrong = [i for i in np.flatnonzero(np.isnan(values)).tolist() if texts[i].lower() not in MISSING]
    labels = tuple(texts) if len(wrong) == len(texts) and len(set(texts)) <= MOST_KEYS else ()
    return RawColumn(name, values, unit, {i: texts[i][:40] for i in wrong[:20]}, len(wrong), labels=labels)


MOST_KEYS = 1000
"""Different words at most of a column that may say what stands in the rows."""
NUMERIC = (int, float, np.integer, np.floating)
MISSING = frozenset(
    ("", "nan", "-nan", "na", "<na>", "n/a", "#n/a", "#na", "null", "none", "nat", "1.#ind", "-1.#ind", "1.#qnan")
)
"""What programs write where there is no number."""


def _all_numbers(texts: Sequence[str]) -> Float | None:
    """Return the numbers (N,) of cells that are all plain numbers or empty, read at once; None for any others."""
    together = "".join(texts)
    if not together.isascii() or "_" in together or max(map(len, texts), default=0) > LONGEST:
        return None  # Python takes for numbers what no instrument writes
    try:
        return np.array([text or "nan" for text in texts], dtype=object).astype(float)
    except ValueError:
        return None


GROUPS = re.compile(r"([+-]?[1-9]\d{0,2})((?:,\d{3})+(?=[.])|(?:[ '’\u00a0\u2009\u202f]\d{3})+)([.]\d*)?", re.ASCII)
"""A number with thousands separators. Commas need a decimal point behind them: "1,234" alone may be a decimal comma."""
LONGEST = 60
"""Characters of a number at most."""
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eEdD][+-]?\d+)?|[+-]?inf(inity)?", re.ASCII | re.IGNORECASE)


def _number(text: str) -> float:
    """Return the number written in `text`, NaN unless it is a plain ASCII decimal number ("1_000" is not)."""
    if len(text) > LONGEST:
        return float("nan")
    text = ungrouped(text)
    if not NUMBER.fullmatch(text):
        return float("nan")
    return float(text if "inf" in text.lower() else text.replace("d", "e").replace("D", "e"))


def ungrouped(text: str) -> str:
    """Return the text of a number without its thousands separators; any other text as it is."""
    found = GROUPS.fullmatch(text)
    return found[1] + re.sub(r"\D", "", found[2]) + (found[3] or "") if found else text


def table_from_arrays(
    arrays: Mapping[str, Any],
    *,
    where: str,
    units: Mapping[str, str] | None = None,
    notes: tuple[Finding, ...] = (),
) -> RawTable:
    """Return the columns held by named `arrays`: (N,), (N, 2) and (2, N) become one and two columns.

    N is the length most arrays share; arrays of another length (settings, other channels) are left out and
    said so. Raises RecordingError when there is no array of two samples or more.
    """
    units = units or {}
    flat = {name: np.squeeze(np.asarray(array)) for name, array in arrays.items()}
    lengths = [max(a.shape) for a in flat.values() if 1 <= a.ndim <= 2 and a.size]
    if not lengths or max(lengths) < 2:
        raise NoNumbersError(
            "no column of numbers was found in the file",
            where=where,
            remedy="store t, q1, q2, tau1, tau2 as arrays of equal length "
            f"(found: {', '.join(list(arrays)[:20]) or 'nothing'})",
        )
    count = max(set(lengths), key=lambda length: (lengths.count(length), length))
    columns: list[RawColumn] = []
    skipped: list[str] = []
    for name, array in flat.items():
        parts = _split(name, array, count)
        if not parts and array.size > 1:
            skipped.append(f"{name} {array.shape}")
        columns += [named_column(part, cells, units.get(name, "")) for part, cells in parts.items()]
    if skipped:
        text = f"{len(skipped)} entries are not columns of {count} samples: {', '.join(skipped[:8])}"
        notes = (*notes, Finding("format", "info", text, where))
    return RawTable(tuple(columns), np.arange(1, count + 1), notes, tuple(skipped))


def split_unit(name: str) -> tuple[str, str]:
    """Return (name, unit) of a header like "q1 [deg]" or "q1 (deg)"; the unit is "" when there is none."""
    # Names end up in messages on a terminal, where control characters could do anything.
    name = "".join(c if c.isprintable() else "?" for c in name.strip().strip("\"'").strip())
    found = UNIT_IN_NAME.match(name)
    if INDEX.fullmatch(name):  # position[0] of an array is no unit
        return re.sub(r"[\[\]()]", "", name), ""
    if not found or not found["name"].strip() or not _may_be_unit(found["unit"]):
        return name, ""
    return found["name"].strip(), found["unit"].strip()


def _may_be_unit(text: str) -> bool:
    """Bracketed text may be a unit, also one that nobody knows; a side, and words as "(filtered)", are none."""
    words = words_in(text)
    return is_unit(text.strip()) or not words or not words <= {*FILLERS, *SIDE_WORDS, *FOREIGN}


def named_column(name: str, cells: Any, unit: str) -> RawColumn:
    """Return a column whose name may say its unit, which counts where `unit` is empty."""
    name, written = split_unit(name)
    return column_from_cells(name, cells, unit or written)


INDEX = re.compile(r".*[^\W\d][\[(]\d{1,2}[\])]")
UNIT_IN_NAME = re.compile(r"^(?P<name>.*?)\s*[\[(](?P<unit>[^\[\]()]*)[\])]\s*$")


def of_lists(name: str, unit: str, elements: Iterable[Any]) -> Iterator[RawColumn]:
    """Yield the columns of one whose cells are lists of equal length, given element by element: state_0, state_1."""
    return (column_from_cells(f"{name}_{k}", cells, unit) for k, cells in enumerate(elements))


def _split(name: str, array: Any, count: int) -> dict[str, Any]:
    """Return {column name: (N,) cells} of one array, empty when its shape does not fit N = `count`
    samples."""
    if array.dtype.names:
        return {f"{name}.{key}": array[key] for key in array.dtype.names if array[key].shape == (count,)}
    if array.ndim == 1 and array.shape[0] == count:
        return {name: array}
    if array.ndim == 2 and count in array.shape and min(array.shape) <= 64:
        tall = array if array.shape[0] == count else array.T
        return {f"{name}{k + 1}": tall[:, k] for k in range(tall.shape[1])}
    return {}


def label_matrices(arrays: Mapping[str, Any], labels: Mapping[str, list[str]]) -> dict[str, Any]:
    """Return `arrays` with each matrix (N, C) cut into columns when a list of C texts beside it names them.

    Beside means in the same struct or group; this is how a timetable saved as an array keeps its names.
    """
    out: dict[str, Any] = {}
    for name, array in arrays.items():
        folder = name.rpartition(".")[0]
        matrix = np.squeeze(np.asarray(array))
        fitting = [
            texts
            for key, texts in labels.items()
            if key.rpartition(".")[0] == folder and len(texts) > 1 and matrix.ndim == 2 and len(texts) in matrix.shape
        ]
        if len(fitting) != 1:
            out[name] = array
            continue
        tall = matrix if matrix.shape[1] == len(fitting[0]) else matrix.T
        names = [f"{folder}.{text}" if folder else text for text in fitting[0]]
        if len(set(names)) == len(names):
            out.update({text: tall[:, k] for k, text in enumerate(names)})
        else:
            out[name] = array
    return out
