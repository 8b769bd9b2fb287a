"""Files that were given, on the command line or dropped into the page: read, mapped, and what is doubtful in them."""

from __future__ import annotations

import difflib
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from exoid.ground.errors import ExoidError, RecordingError, error_json
from exoid.ground.text import printable
from exoid.measurement.reading.mapping import StatedMapping

if TYPE_CHECKING:
    from exoid.measurement.reading.raw import RawColumn, RawTable
    from exoid.measurement.recording import Recording
    from exoid.symbolic.joints import Joint

FIT, VERIFY = "fit", "verify"
SHOWN = 8
"""Values of each column in the preview."""


@dataclass(frozen=True, eq=False)
class Given:
    """A file: its `name` as the user knows it, where it lies, whether it is fitted or held out, what was `told` of it,
    what is in it, and `error`, why it cannot be used as it is.
    """

    id: int
    name: str
    path: Path
    role: str = FIT
    told: StatedMapping = field(default_factory=StatedMapping)
    recordings: tuple[Recording, ...] = ()
    error: ExoidError | None = None
    read: bool = False
    among: bool = False
    """Whether the file stood in a folder, where other files may stand."""

    @property
    def is_other(self) -> bool:
        """True if the file stood in a folder and is no recording."""
        return self.among and isinstance(self.error, RecordingError) and bool(self.error.kind)

    @property
    def files(self) -> frozenset[Path]:
        """The files that it is read from: of what lies in an archive, the archive."""
        named = (self.path, *(Path(file) for file, _ in self.told.join))
        return frozenset(next((part for part in (item, *item.parents) if part.is_file()), item) for item in named)


def safe_name(name: str) -> str:
    """Return a name under which a dropped file may be stored: its last part, without anything a shell or page obeys."""
    last = re.split(r"[/\\]", name)[-1]
    kept = re.sub(r"[^A-Za-z0-9._-]", "_", last).lstrip(".")[-80:]
    return kept or "recording.csv"


def shown_name(name: str) -> str:
    """Return the last part of a file's name as it is shown: control characters spelt out."""
    return printable(re.split(r"[/\\]", name)[-1])[:120] or "recording"


def read_given(given: Given, remembered: Path, joints: Sequence[Joint] | None = None) -> Given:
    """Return the file with its recordings, or with the reason why it cannot be used.

    What is known of files with the same columns is taken from the folder `remembered`, if nothing was said, or from
    that of the file: a copy of it lies elsewhere. `joints` are those of the machine; without them the columns say which
    there are.
    """
    from exoid.measurement.reading.mapping import remembered as mapping_for
    from exoid.measurement.reading.read import open_table, read_as_told
    from exoid.measurement.reading.sources import folder_of

    try:
        if not given.told.columns:
            names = open_table(given.path).names
            kept = mapping_for(remembered, names) or mapping_for(folder_of(given.path), names)
            given = replace(given, told=given.told.over(kept)) if kept else given
        recordings = read_as_told(given.path, given.told, joints)
    except ExoidError as error:
        return replace(given, recordings=(), error=error.about(given.name, given.path), read=True)
    return replace(given, recordings=_named(given, recordings), error=None, read=True)


def read_as_others(given: Given, answers: Sequence[StatedMapping], joints: Sequence[Joint] | None = None) -> Given:
    """Return a file that cannot be read as it is, read as was told of another one; as it is where that does not help.

    Of an answer counts what this file has: its leg, convention, passive joints and rate, and the columns and units of
    those that are there.
    """
    from exoid.measurement.reading.mapping import factors_of
    from exoid.measurement.reading.read import open_table, read_as_told

    try:
        names = set(open_table(given.path).names)
    except ExoidError:
        return given
    for said in answers:
        columns = {name: column for name, column in said.columns.items() if names.issuperset(factors_of(column, names))}
        units = {name: unit for name, unit in said.units.items() if not columns or name in columns}
        told = replace(
            given.told, columns=columns, units=units, leg=said.leg, convention=said.convention, passive=said.passive,
            rate=said.rate,
        )  # fmt: skip
        try:
            recordings = read_as_told(given.path, told, joints)
        except ExoidError:
            continue
        return replace(given, told=told, recordings=_named(given, recordings), error=None, read=True)
    return given


def _named(given: Given, recordings: tuple[Recording, ...]) -> tuple[Recording, ...]:
    """Return the recordings of a file; a single one is called as the file is."""
    stem = Path(given.name).stem or given.name
    if len(recordings) == 1:
        return (replace(recordings[0], name=stem),)
    sides = [recording.name.rpartition(" (")[2] for recording in recordings]
    return tuple(replace(item, name=f"{stem} ({side}") for item, side in zip(recordings, sides, strict=True))


def mapping_preview(given: Given, joints: Sequence[Joint]) -> dict[str, Any]:
    """Return the contents of a mapping dialog: columns with first values, the best guess, and what is doubtful."""
    from exoid.measurement.reading.columns import assign_usable, canonical_columns, legs, required
    from exoid.measurement.reading.conventions import conventions_of_machine
    from exoid.measurement.reading.mapping import numbered
    from exoid.measurement.reading.names import kind_of
    from exoid.measurement.reading.read import open_table
    from exoid.symbolic.units import SI_UNIT

    table = open_table(given.path)
    told = given.told
    names = numbered(table.names)
    called = {id(column): name for name, column in zip(names, table.columns, strict=True)}

    def shown(column: RawColumn) -> str:
        return called.get(id(column), column.name)  # a product of columns is none of the table

    drives = {f"tau{k}": joint.name for k, joint in enumerate(joints, start=1)}
    sides = legs(table, joints)
    guesses = {}
    for side in dict.fromkeys((told.leg if told.leg in sides else "", *sides)):
        try:
            said = replace(told, leg=side)
            found, _ = assign_usable(table, said, where=given.name, joints=joints, partial=True)
        except ExoidError:
            continue
        guesses[side] = {n: {"column": shown(item.column), "unit": item.unit} for n, item in found.items()}
    guess = next(iter(guesses.values()), {})
    return {
        "id": given.id,
        "name": given.name,
        "columns": [{"name": n, **_column(c)} for n, c in zip(names, table.columns, strict=True)],
        "wanted": [
            {"name": name, "required": name in required(joints), "si": SI_UNIT[kind_of(name, joints)],
             "joint": drives.get(name, ""), "said": _in_words(name, joints)}
            for name in canonical_columns(joints)
        ],
        "guess": guess,
        "sides": list(sides),
        "guesses": guesses,
        "told": {
            "leg": told.leg, "passive": told.passive, "columns": dict(told.columns), "units": dict(told.units),
            "rate": told.rate,
        },
        "convention": told.convention,
        "conventions": [{"name": c.name, "what": c.what} for c in conventions_of_machine(tuple(joints)).values()],
        "error": None if given.error is None else error_json(given.error),
        "findings": [f.to_json() for recording in given.recordings for f in recording.findings],
    }


def _in_words(name: str, joints: Sequence[Joint]) -> str:
    """Return the name of an angle, a torque, ... of a joint ("knee torque"), other columns by their names."""
    from exoid.measurement.auditing.channels import WORDS
    from exoid.measurement.reading.names import quantity_of

    quantity = quantity_of(name)
    number = name.removeprefix(quantity)
    if quantity not in WORDS or not number:
        return {"t": "time"}.get(name, name)
    joint = joints[int(number) - 1]
    return f"{joint.name} {WORDS[quantity][not joint.turns]}"


def remember_mapping(folder: Path, table: RawTable, told: StatedMapping) -> None:
    """Keep a mapping for the next file with these columns."""
    from exoid.measurement.reading.mapping import remember as keep

    if told:
        folder.mkdir(parents=True, exist_ok=True)
        keep(folder, table.names, told, replacing=True)


def told_of_all(given: Sequence[Given]) -> StatedMapping:
    """Return the statements that hold for a further file as well: the convention in which all files so far are read."""
    found = {entry.told.convention for entry in given}
    return StatedMapping(convention=found.pop() if len(found) == 1 else "")


def keep_mappings(folder: Path, path: Path) -> None:
    """Keep every mapping in a file of `exoid map`; RecordingError where it is none."""
    from exoid.measurement.reading.mapping import entries
    from exoid.measurement.reading.mapping import remember as keep

    folder.mkdir(parents=True, exist_ok=True)
    for header, told in entries(path):
        keep(folder, header, told, replacing=True)


def numbers_meant(entry: dict[str, Any]) -> dict[str, Any]:
    """Return an effect whose numbers have units. One of which nothing was said and that resembles a word of the
    language (dthta) is no number: it is left out, and refused where it stands.
    """
    from exoid.symbolic.language.words import OWN

    out = dict(entry)
    for kind in ("coefficients", "shape"):
        out[kind] = {
            name: {"unit": "1", **said}
            for name, said in dict(entry.get(kind, {})).items()
            if said or not difflib.get_close_matches(name, OWN, cutoff=0.75)
        }
    return out


def _column(column: Any) -> dict[str, Any]:
    import numpy as np

    values = column.values
    good = values[np.isfinite(values)]
    first = [column.texts.get(k) or (None if v != v else float(v)) for k, v in enumerate(values[:SHOWN].tolist())]
    return {
        "unit": column.unit,
        "low": float(good.min()) if good.size else None,
        "high": float(good.max()) if good.size else None,
        "first": first,
    }
