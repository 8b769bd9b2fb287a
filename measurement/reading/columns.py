"""Which column of a file is which: usual names, units in the header, and what the user maps by hand.

A name is cut into words; if the words that remain after fillers ("measured", "joint", ...) are a known
quantity and a known joint, the column is recognised. Anything else in the name ("desired", "ref", "error")
forbids it, so a set-point is never taken for a measurement.
"""

from __future__ import annotations

import difflib
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from ground.errors import RecordingError
from measurement.reading.raw import RawColumn, RawTable
from measurement.reading.units import QUANTITIES, factor

REQUIRED = ("t", "q1", "q2", "tau1", "tau2")
OPTIONAL = ("dq1", "dq2", "ddq1", "ddq2", "f1", "f2")
CANONICAL = REQUIRED + OPTIONAL
SI = {"t": "s", "q": "rad", "dq": "rad/s", "ddq": "rad/s²", "tau": "N·m", "f": "N"}

WORDS: Mapping[str, tuple[str, ...]] = {
    "t": ("t", "time", "timestamp", "timestamps", "zeit", "clock", "elapsed", "elapsedtime", "seconds",
          "stamp", "rowtimes", "datetime"),
    "q": ("q", "theta", "angle", "angles", "pos", "position", "phi", "winkel", "th"),
    "dq": ("dq", "qd", "qdot", "qp", "dtheta", "thetadot", "thetad", "theta dot", "omega", "vel", "velocity",
           "speed", "w", "anglevelocity", "angularvelocity", "anglerate", "dth"),
    "ddq": ("ddq", "qdd", "qddot", "qpp", "ddtheta", "thetaddot", "thetadd", "acc", "acceleration",
            "angularacceleration", "ddth"),
    "tau": ("tau", "torque", "torques", "trq", "moment", "drehmoment", "effort", "efforts", "u"),
    "f": ("f", "force", "cuffforce", "interactionforce", "fint", "fdis", "fcuff", "kraft"),
}  # fmt: skip
JOINTS: Mapping[str, int] = {"1": 1, "2": 2, "01": 1, "02": 2, "hip": 1, "h": 1, "knee": 2, "k": 2, "kn": 2,
                             "thigh": 1, "shank": 2, "hüfte": 1, "huefte": 1, "knie": 2}  # fmt: skip
FILLERS = frozenset(
    {
        "joint",
        "measured",
        "meas",
        "actual",
        "act",
        "sensor",
        "motor",
        "of",
        "in",
        "the",
        "encoder",
        "data",
        "value",
        "values",
        "signal",
    }
)
FOREIGN = frozenset(
    {
        "ref",
        "reference",
        "desired",
        "des",
        "cmd",
        "command",
        "commanded",
        "setpoint",
        "target",
        "error",
        "err",
        "model",
        "simulated",
        "predicted",
        "feedforward",
    }
)
"""Anywhere in a name, also in that of its group, these say that it is not a measurement."""
GREEK = {
    "θ̈": " ddtheta ",
    "θ̇": " dtheta ",
    "θ": " theta ",
    "ϑ": " theta ",
    "φ": " phi ",
    "τ": " tau ",
    "ω": " omega ",
}
_QUANTITY = {word.replace(" ", ""): quantity for quantity, words in WORDS.items() for word in words}


@dataclass(frozen=True)
class Assigned:
    """A canonical column: where it comes from, `factor` to SI, and whether its unit was `told` by
    somebody."""

    name: str
    column: RawColumn
    unit: str
    factor: float
    told: bool


def quantity_of(name: str) -> str:
    """Return the quantity of a canonical column name: "dq1" -> "dq"."""
    return name.rstrip("12")


def recognise(name: str) -> tuple[str, str, int] | None:
    """Return (canonical name, unit hidden in the name, number of filler words) or None: "tau1_mNm" ->
    ("tau1", "mNm", 0)."""
    for sign, word in GREEK.items():
        name = name.replace(sign, word)
    if FOREIGN.intersection(re.split(r"[\W\d_]+", _spaced(name).lower())):
        return None
    path = [part for part in re.split(r"[./:]", name) if part]
    for depth in (1, 2):  # "run.q1" and "run.hip.angle"; a unit such as "rad/s" also looks like a path
        found = _recognised(" ".join(path[-depth:])) or _recognised(name)
        if found:
            return found
    return None


def _recognised(text: str) -> tuple[str, str, int] | None:
    parts = [part for part in re.split(r"[\W_]+", text) if part]
    for used in (2, 1):  # a unit at the end may be cut in two: "rad_s"
        tail = "/".join(parts[-used:])
        found = _match(parts[:-used]) if len(parts) > used and not tail.isdigit() else None
        if found and factor(quantity_of(found[0]), tail) is not None:
            return found[0], tail, found[1]
    found = _match(parts)
    return (found[0], "", found[1]) if found else None


def _spaced(name: str) -> str:
    """Return `name` with a blank between words and numbers written as one: "hipAngle", "q1"."""
    name = re.sub(r"(?<=[a-z])(?=[A-Z])", " ", name)
    return re.sub(r"(?<=[^\W\d_])(?=\d)|(?<=\d)(?=[^\W\d_])", " ", name)


def _match(parts: Sequence[str]) -> tuple[str, int] | None:
    lower = _spaced(" ".join(parts)).lower().split()
    kept = [word for word in lower if word not in FILLERS]
    joints = {JOINTS[word] for word in kept if word in JOINTS}
    quantity = _QUANTITY.get("".join(word for word in kept if word not in JOINTS))
    if quantity == "t" and not joints:
        return "t", len(lower) - len(kept)
    if quantity in (None, "t") or len(joints) != 1:
        return None
    return f"{quantity}{joints.pop()}", len(lower) - len(kept)


def assign(
    table: RawTable, mapping: Mapping[str, str] | None, units: Mapping[str, str] | None, *, where: str
) -> dict[str, Assigned]:
    """Return {canonical name: column}; raises RecordingError for a missing, doubtful or doubly used column.

    `mapping` is {canonical: column in the file}; `units` is {quantity, canonical name or column: unit}.
    """
    mapping, units = dict(mapping or {}), dict(units or {})
    _check_keys(mapping, CANONICAL, "--map", where)
    _check_keys(units, (*SI, *CANONICAL, *table.names), "--units", where)
    chosen = _mapped(table, mapping, where)
    taken = {id(column) for column in chosen.values()}
    aliases = _counted_from_one(table.names)
    offers: dict[str, list[tuple[int, RawColumn]]] = {}
    hidden: dict[int, str] = {}
    for column in table.columns:
        found = None if id(column) in taken else recognise(aliases.get(column.name, column.name))
        if found:
            offers.setdefault(found[0], []).append((found[2] + 100 * column.rank, column))
            hidden[id(column)] = found[1]
    for name, columns in offers.items():
        if name in chosen:
            continue
        fewest = min(rank for rank, _ in columns)
        best = [column for rank, column in columns if rank == fewest]
        # Time series of Simulink each carry the same time.
        if any(not np.array_equal(best[0].values, other.values, equal_nan=True) for other in best[1:]):
            names = ", ".join(repr(name) for name in numbered([column.name for column in best]))
            raise RecordingError(
                f"more than one column can be {name}: {names}",
                where=where,
                remedy=f"say which: --map {name}={numbered([column.name for column in best])[0]}",
            )
        chosen[name] = best[0]
    _check_missing(chosen, table, where)
    return {name: _with_unit(name, chosen[name], units, hidden, where) for name in CANONICAL if name in chosen}


def _check_keys(given: Mapping[str, str], known: Sequence[str], option: str, where: str) -> None:
    for key in given:
        if key not in known:
            close = difflib.get_close_matches(key, known, 1)
            hint = f"did you mean {close[0]!r}? " if close else ""
            raise RecordingError(
                f"{option} names {key!r}, which is not a column exoid knows",
                where=where,
                remedy=f"{hint}known: {', '.join(known)}",
            )


def _mapped(table: RawTable, mapping: Mapping[str, str], where: str) -> dict[str, RawColumn]:
    chosen: dict[str, RawColumn] = {}
    for name, wanted in mapping.items():
        found = [c for c, n in zip(table.columns, numbered(table.names), strict=True) if wanted in (c.name, n)]
        found = found or [c for c in table.columns if c.name.lower() == wanted.strip().lower()]
        if len(found) != 1:
            close = difflib.get_close_matches(wanted, table.names, 1, cutoff=0.5)
            hint = f"did you mean {close[0]!r}? " if close and not found else ""
            what = "is not in the file" if not found else f"stands {len(found)} times in the file"
            hint = f"write {wanted}#1 for the first of them. " if found else hint
            raise RecordingError(
                f"column {wanted!r} ({name}) {what}",
                where=where,
                remedy=f"{hint}columns found: {listed(table.names)}",
            )
        double = [other for other, column in chosen.items() if column is found[0]]
        if double:
            raise RecordingError(
                f"column {wanted!r} is mapped to both {double[0]} and {name}",
                where=where,
                remedy="map each column once",
            )
        chosen[name] = found[0]
    return chosen


def _check_missing(chosen: Mapping[str, RawColumn], table: RawTable, where: str) -> None:
    missing = [name for name in REQUIRED if name not in chosen]
    if not missing:
        return
    used = {id(column) for column in chosen.values()}
    free = [column.name for column in table.columns if id(column) not in used]
    close = difflib.get_close_matches(missing[0], free, 1, cutoff=0.5)
    example = f"{missing[0]}={close[0] if close else 'COLUMN'}"
    raise RecordingError(
        f"no column for {', '.join(missing)} was found (columns found: {listed(table.names)})",
        where=where,
        remedy=f"{'did you mean' if close else 'say which column it is:'} --map {example}" + "?" * bool(close),
    )


def numbered(names: Sequence[str]) -> list[str]:
    """Return names that can be told apart: of several alike, the second is "name#2"."""
    return [f"{name}#{names[:k].count(name) + 1}" if names.count(name) > 1 else name for k, name in enumerate(names)]


def _counted_from_one(names: Sequence[str]) -> dict[str, str]:
    """Return {name: the same counted from 1} for joints counted from 0: there is a 0 and a 1, but no 2."""
    out: dict[str, str] = {}
    for name in names:
        found = re.fullmatch(r"(.*?)(?<!\d)0(\D*)", name)
        if not found:
            continue
        first, second = (f"{found[1]}{k}{found[2]}" for k in (1, 2))
        if first in names and second not in names:
            out |= {name: first, first: second}
    return out


def listed(names: Sequence[str], most: int = 20) -> str:
    """Return names for a message, the long tail cut."""
    text = ", ".join(name[:40] or "(no name)" for name in names[:most])
    return text + (f" and {len(names) - most} more" if len(names) > most else "")


def _with_unit(
    name: str, column: RawColumn, units: Mapping[str, str], hidden: Mapping[int, str], where: str
) -> Assigned:
    quantity = quantity_of(name)
    told = units.get(name) or units.get(column.name) or units.get(quantity)
    unit = told or column.unit or hidden.get(id(column), "")
    if not unit or unit in ("-", "1"):
        return Assigned(name, column, SI[quantity], 1.0, False)
    scale = factor(quantity, unit)
    if scale is None:
        raise RecordingError(
            f"unit {unit!r} of column {column.name!r} ({name}) is not known",
            where=where,
            remedy=f"--units {name}=UNIT with one of {', '.join(QUANTITIES[quantity])}",
        )
    return Assigned(name, column, unit, scale, True)
