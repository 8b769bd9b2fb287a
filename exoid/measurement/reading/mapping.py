"""Statements of a user about columns: one by its name, or a formula of several ("duty*volts", "12*(target-actual)"). It
is kept as `exoid.toml` beside the recordings, and used for every file with the same columns.

    [[recordings]]
    header = ["Zeit", "A1", "A2", "M1", "M2"]
    columns = { t = "Zeit", q1 = "A1", q2 = "A2", tau1 = "M1", tau2 = "M2" }
    units = { q = "deg" }
    leg = "left"

Whoever reads says so every time. What is given by hand comes before it; the file is only written when somebody asks.
"""

from __future__ import annotations

import re
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from exoid.ground.errors import ExpressionError, RecordingError, refused
from exoid.ground.files import write_whole
from exoid.ground.inside import refuse_links
from exoid.ground.suggest import nearest
from exoid.ground.toml_reader import Table, read_toml
from exoid.measurement.reading.raw import RawColumn, RawTable
from exoid.measurement.reading.units import MOST_FACTORS
from exoid.symbolic.language.parser import parse
from exoid.symbolic.language.tree import Binary, Name, Node, Number, Unary
from exoid.symbolic.mechanics.payload import Payload
from exoid.symbolic.motion import Float

FILE = "exoid.toml"
DIMENSIONLESS = ("", "-", "1")
MOST_BYTES = 1_000_000
FIRST_LINE = "# Which column is what. Made by exoid map.\n"


@dataclass(frozen=True)
class StatedMapping:
    """Statements of the user about a file: `columns` {canonical: column}, `units` {name: unit}, `leg` ("" if unsaid).

    And of this one recording, never kept: its `convention` ("a,b"), files to `join` to it with the lag in s of their
    clocks (None: physics says), its `passive` joints, which have no drive, `payloads`, known masses on it, which
    rows `only` are explained ("contact == 0", `exoid.measurement.selection`), its `rate` in Hz where it has no clock.
    """

    columns: Mapping[str, str] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    leg: str = ""
    convention: str = ""
    join: tuple[tuple[str, float | None], ...] = ()
    passive: tuple[str, ...] = ()
    payloads: tuple[Payload, ...] = ()
    only: str = ""
    rate: float = 0.0

    @property
    def options(self) -> dict[str, Any]:
        """Arguments of `read_recordings`, as far as they are stated."""
        names = ("columns", "units", "leg", "convention", "join", "passive", "only", "rate")
        return {name: value for name in names if (value := getattr(self, name))}

    def over(self, other: StatedMapping) -> StatedMapping:
        """Return the statements of both about the columns; those of `self` come first."""
        columns, units = {**other.columns, **self.columns}, {**other.units, **self.units}
        return replace(self, columns=columns, units=units, leg=self.leg or other.leg)

    def __str__(self) -> str:
        parts = [f"{name}={value}" for name, value in (*self.columns.items(), *self.units.items())]
        return ", ".join([*parts, *([f"leg {self.leg}"] if self.leg else [])])

    def __bool__(self) -> bool:
        return bool(self.columns or self.units or self.leg)


def remembered(folder: Path, names: Sequence[str]) -> StatedMapping | None:
    """Return the statements of `exoid.toml` in `folder` about files with exactly the columns `names`, None where it
    says nothing.

    RecordingError when there is such a file and it cannot be understood.
    """
    found = [mapping for header, mapping in entries(folder / FILE) if header == list(names)]
    return found[-1] if found else None


def entries(path: Path) -> list[tuple[list[str], StatedMapping]]:
    """Return (header, mapping) of every entry of the file `path`; empty where there is no such file."""
    if not path.exists():
        return []
    remedy = "mend it, or move it elsewhere; exoid map FILE makes one"
    top = read_toml(path, MOST_BYTES, RecordingError, what="mapping", remedy=remedy, remember=False)
    top.only("recordings")
    return [_entry(table) for table in top.tables("recordings")]


def _entry(table: Table) -> tuple[list[str], StatedMapping]:
    table.only("header", "columns", "units", "leg")
    header = table.values.get("header")
    if not isinstance(header, list) or not all(isinstance(name, str) for name in header) or len(header) > 10_000:
        raise table.error("header", "header is not a list of texts", 'write header = ["t", "A1", ...]')
    columns, units = (_texts(table, key) for key in ("columns", "units"))
    leg = table.text("leg", "")
    if leg not in ("", "left", "right", "ipsi", "contra", "both"):
        raise table.error("leg", f"leg is {leg[:20]!r}", "write left, right or both")
    return list(header), StatedMapping(columns, units, leg)


def _texts(table: Table, key: str) -> dict[str, str]:
    if key not in table.values:
        return {}
    inner = table.table(key)
    return {name: inner.text(name) for name in inner.values}


def remember(folder: Path, names: Sequence[str], mapping: StatedMapping, *, replacing: bool = False) -> Path:
    """Add `mapping` for files with the columns `names` to `exoid.toml` in `folder` and return its path.

    Another mapping for the same columns is only replaced with `replacing`; everything else in the file stays as it is,
    comments included. RecordingError otherwise, or when the file cannot be written.
    """
    import tomli_w

    path = folder / FILE
    mapping = StatedMapping(mapping.columns, mapping.units, mapping.leg)
    known = entries(path)
    old = [item for header, item in known if header == list(names)]
    if old and old[-1] == mapping:
        return path
    if old and not replacing:
        what = f"another mapping for the same columns is kept there ({old[-1]})"
        raise RecordingError(what, where=str(path), remedy="--replace puts the new one in its place")
    elsewhere = "--out DIR keeps it elsewhere, beside a copy of the recordings"
    with refused(RecordingError, "the mapping cannot be written ({})", path, elsewhere):
        refuse_links(path, folder)
        before = path.read_text(encoding="utf-8-sig") if path.exists() else FIRST_LINE
        added = tomli_w.dumps({"recordings": [{"header": list(names), **mapping.options}]})
        # The last entry for a header counts, so nothing that stands there is touched.
        return write_whole(path, before.rstrip("\n") + "\n\n" + added, inside=folder)


def mapped(table: RawTable, mapping: Mapping[str, str], where: str) -> dict[str, RawColumn]:
    """Return {canonical name: column} of what a user maps by hand; RecordingError for what is not in the table."""
    chosen: dict[str, RawColumn] = {}
    for name, wanted in mapping.items():
        names = numbered(table.names)
        called = factors_of(wanted, names)
        if is_formula(wanted, names):
            of = dict(zip(called, (_called(table, entry, name, where) for entry in called), strict=True))
            found = _formula(wanted, of, f"{where}, --map {name}")
        else:
            factors = tuple(_called(table, item, name, where) for item in called)
            found = factors[0] if len(factors) == 1 else _product(wanted, factors)
        double = [other for other, column in chosen.items() if column is found]
        if double:
            what = f"column {wanted!r} is mapped to both {double[0]} and {name}"
            raise RecordingError(what, where=where, remedy="map each column once")
        chosen[name] = found
    return chosen


def is_formula(text: str, names: Collection[str]) -> bool:
    """True if `text` in a mapping is more than one of the `names` or a product of them: "12*(target-actual)".

    Only one whose every column is there counts: hyphens and brackets stand in names too.
    """
    if text in names or not re.search(r"[-+/()]|\d", text):
        return False
    placed, found = _with_places(text, names)
    return bool(found) and not _are_names(text, names) and bool(FORMULA.fullmatch(placed))


FORMULA = re.compile(r"(?:c\d+\b|[\d.]+(?:[eE][+-]?\d+)?\b\.?|[-+*/() ])+", re.ASCII)
"""What is left of a formula when each column has been given a place: c0, c1, ..., numbers and signs."""


def _are_names(text: str, names: Collection[str]) -> bool:
    return all(part.strip() in names for part in re.split(r"[*·×]", text))


def _with_places(text: str, names: Collection[str]) -> tuple[str, list[str]]:
    """Return `text` with c0, c1, ... for the columns that it names, and these."""
    found: list[str] = []

    def placed(match: re.Match[str]) -> str:
        if match[0] not in found:
            found.append(match[0])
        return f"c{found.index(match[0])}"

    longest = sorted((name for name in names if re.search(r"[^\W\d]", name)), key=len, reverse=True)
    pattern = "|".join(rf"(?<!\w){re.escape(name)}(?!\w)" for name in longest)
    text = text.replace("·", "*").replace("×", "*")
    return (re.sub(pattern, placed, text), found) if pattern else (text, found)


def _formula(text: str, columns: Mapping[str, RawColumn], where: str) -> RawColumn:
    """Return the column that a formula of columns comes to; what is no number in one of them is none in it.

    Its unit is that of its columns, or text that no quantity has as a unit ("deg+rad"), so that it is asked for.
    RecordingError for what is no sum or product.
    """
    placed, _ = _with_places(text, columns)
    places = {f"c{k}": column for k, column in enumerate(columns.values())}
    try:
        with np.errstate(all="ignore"):
            values, unit = _value(parse(placed, places), places)
    except ExpressionError as error:
        remedy = f"sums, differences, products and numbers, as 12*(target-actual), are read; {error.what}"
        raise RecordingError(f"{text!r} is no formula of columns", where=where, remedy=remedy) from error
    return RawColumn(text, np.where(np.isfinite(values), values, np.nan), unit)


def _value(node: Node, columns: Mapping[str, RawColumn]) -> tuple[Float, str]:
    """Return the value of a formula, and its unit, "" where it has none."""
    if isinstance(node, Number):
        return np.array(node.value), ""
    if isinstance(node, Name) and node.name in columns:
        column = columns[node.name]
        return column.values, "" if column.unit in DIMENSIONLESS else column.unit
    if isinstance(node, Unary):
        value, unit = _value(node.operand, columns)
        return -value, unit
    if isinstance(node, Binary) and node.operator in SIGNS:
        (left, unit), (right, other) = _value(node.left, columns), _value(node.right, columns)
        value = np.asarray(SIGNS[node.operator](left, right), dtype=float)
        if node.operator == "/":
            return value, f"{unit or 1}/{other}" if other else unit
        units = [each for each in (unit, other) if each]
        return value, "*".join(units) if node.operator == "*" else "+".join(dict.fromkeys(units))
    raise ExpressionError("nothing else is")


SIGNS: Mapping[str, Any] = {"+": np.add, "-": np.subtract, "*": np.multiply, "/": np.divide}


def factors_of(text: str, names: Collection[str]) -> list[str]:
    """Return the columns that `text` names in a mapping: one of the `names`, the factors of "duty*volts", or those of a
    formula.
    """
    placed, found = _with_places(text, names)
    if is_formula(text, names):
        return found
    wrong = [word.strip() for word in re.findall(r"[^\W\d][\w ]*", placed) if not re.fullmatch(r"c\d+ *", word)]
    if text not in names and found and wrong and re.search(r"[*/()]", text):
        return [*found, *wrong]  # a formula with a column that is not there
    parts = [part.strip() for part in re.split(r"[*·×]", text)]
    return [text] if text in names or len(parts) > MOST_FACTORS or not all(parts) else parts


def _called(table: RawTable, wanted: str, name: str, where: str) -> RawColumn:
    """Return the one column that is called `wanted`, to be read as `name`; RecordingError where there is none."""
    found = [c for c, n in zip(table.columns, numbered(table.names), strict=True) if wanted in (c.name, n)]
    found = found or [c for c in table.columns if c.name.lower() == wanted.strip().lower()]
    if len(found) == 1:
        return found[0]
    close = nearest(wanted, table.names, 1, cutoff=0.5)
    hint = f"did you mean {close[0]!r}? " if close and not found else ""
    what = "is not in the file" if not found else f"stands {len(found)} times in the file"
    hint = f"write {wanted}#1 for the first of them. " if found else hint
    remedy = f"{hint}columns found: {listed(table.names)}"
    raise RecordingError(f"column {wanted!r} ({name}) {what}", where=where, remedy=remedy)


def _product(text: str, factors: tuple[RawColumn, ...]) -> RawColumn:
    """Return the product of columns; what is no number in one of them is none in it."""
    unit = "*".join(column.unit for column in factors if column.unit not in DIMENSIONLESS)
    with np.errstate(over="ignore", invalid="ignore"):
        values = np.prod([column.values for column in factors], axis=0)
    texts = {row: cell for column in factors for row, cell in column.texts.items()}
    return RawColumn(text, values, unit, texts, sum(column.text_count for column in factors), factors=factors)


def numbered(names: Sequence[str]) -> list[str]:
    """Return names that can be distinguished: of several alike, the second is "name#2"."""
    return [f"{name}#{names[:k].count(name) + 1}" if names.count(name) > 1 else name for k, name in enumerate(names)]


def listed(names: Sequence[str], most: int = 20) -> str:
    """Return names for a message, the long tail cut."""
    text = ", ".join(name[:40] or "(no name)" for name in names[:most])
    return text + (f" and {len(names) - most} more" if len(names) > most else "")
