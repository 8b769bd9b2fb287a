"""A machine from its table of Denavit and Hartenberg: one row a joint, with `theta, d, a, alpha`.

    joint,theta [deg],d,a,alpha [deg],gear
    a1,0,0.675,0.35,-90,257

As a robot's data sheet has it (`standard`: Denavit, Hartenberg 1955; a row leads from the joint's frame to the next
one), or as Craig writes it (`modified`: `a` and `alpha` lead to the joint's own frame). Lengths are in m, angles in rad
unless the header says deg; `theta` of a turning joint and `d` of a sliding one are what they are where the joint reads
zero. `kind` (revolute, prismatic), `gear` and `joint` may be left out.
"""

from __future__ import annotations

import csv
import math
import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Literal

import numpy as np

from exoid.ground.errors import ExoidError, refused
from exoid.ground.inputs import open_input
from exoid.symbolic.joints import MOST, Joint, Origin
from exoid.symbolic.mechanics.spatial import rotation
from exoid.symbolic.model import Model
from exoid.symbolic.model_structure import STANDARD_GRAVITY
from exoid.symbolic.motion import Float
from exoid.symbolic.planar_machine import plain_name
from exoid.symbolic.spatial_machine import origin_at

Kind = Literal["standard", "modified"]
COLUMNS = ("joint", "kind", "theta", "d", "a", "alpha", "gear")
NEEDED = ("d", "a", "alpha")
LARGEST = 100_000
"""Bytes of a table, which has a line a joint."""
_HEAD = re.compile(r"\s*([A-Za-z]+)\s*(?:[\[(]\s*(rad|deg|°|m|mm)\s*[\])])?\s*")
UNITS: Mapping[str, float] = {"deg": math.pi / 180.0, "°": math.pi / 180.0, "mm": 1e-3, "rad": 1.0, "m": 1.0}


class TableError(ExoidError):
    """A table of Denavit and Hartenberg that cannot be read."""


def dh_machine(path: str | Path, kind: Kind = "standard", gravity: float = STANDARD_GRAVITY) -> Model:
    """Return the machine of the table at `path`; `gravity` in m/s² pulls along -z of the first joint's frame.

    TableError says what is wrong, and in which line.
    """
    where = str(path)
    with refused(TableError, "cannot be read: {}", where, "check the path"), open_input(path) as stream:
        data = stream.read(LARGEST + 1)
    try:
        text = data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise TableError("is not a text in UTF-8", where=where, remedy="save the table as CSV") from error
    lines = [line for line in text.splitlines() if line.strip() and not line.lstrip().startswith("#")]
    if len(data) > LARGEST or not 2 <= len(lines) <= MOST + 1:
        what = f"has {max(0, len(lines) - 1)} rows below its header"
        raise TableError(what, where=where, remedy=f"give one row for each of 1 to {MOST} joints")
    split = max(",;\t", key=lines[0].count)
    head, *rows = csv.reader(lines, delimiter=split)
    units = _header(head, where)
    return made_of([_row(row, units, k, where) for k, row in enumerate(rows, 1)], kind, gravity, Path(path).stem)


def made_of(
    rows: Sequence[Mapping[str, str | float]],
    kind: Kind = "standard",
    gravity: float = STANDARD_GRAVITY,
    name: str = "robot",
) -> Model:
    """Return the machine of `rows` {"theta", "d", "a", "alpha", "joint", "kind", "gear"} in rad and m."""
    joints: list[Joint] = []
    last = np.eye(4)
    for k, row in enumerate(rows, 1):
        theta, d, a, alpha, gear = (float(row.get(key, 0.0)) for key in ("theta", "d", "a", "alpha", "gear"))
        along, across = _about(2, theta, d), _about(0, alpha, a)
        place, last = (across @ along, last) if kind == "modified" else (last, along @ across)
        called = plain_name(str(row.get("joint") or f"joint_{k}"))
        made = Joint(called, str(row.get("kind") or "revolute"), axis=(0.0, 0.0, 1.0), origin=origin_at(place))
        joints.append(replace(made, motor=((called, gear),)) if gear else made)
    return Model(plain_name(name), gravity=gravity, limits={}, joints=tuple(joints))


def _about(axis: int, angle: float, length: float) -> Float:
    """Return the motion (4, 4) by an angle about an axis and a length along it."""
    rpy, out = [0.0, 0.0, 0.0], np.eye(4)
    rpy[axis] = angle
    out[:3, :3] = rotation(Origin(rpy=(rpy[0], rpy[1], rpy[2])))
    out[axis, 3] = length
    return out


def _header(head: Sequence[str], where: str) -> list[tuple[str, float]]:
    """Return name and unit of every column."""
    found = []
    for cell in head:
        match = _HEAD.fullmatch(cell)
        name = match[1].lower() if match else ""
        unit = match[2] if match else None
        lengths = unit in ("m", "mm")
        if name not in COLUMNS or (unit and (name in ("joint", "kind", "gear") or lengths != (name in ("d", "a")))):
            remedy = "name the columns joint, theta [deg], d, a, alpha [deg] and, if you like, kind and gear"
            raise TableError(f"column {cell.strip()[:40]!r} is none of a table", where=where, remedy=remedy)
        found.append((name, UNITS[unit or "m"]))
    names = [name for name, _ in found]
    missing = [name for name in NEEDED if name not in names]
    if missing or len({*names}) < len(names):
        what = f"has no column {' and '.join(missing)}" if missing else "names a column twice"
        raise TableError(what, where=where, remedy="give the columns joint, theta, d, a and alpha, each once")
    return found


def _row(cells: Sequence[str], units: Sequence[tuple[str, float]], number: int, where: str) -> dict[str, str | float]:
    """Return one row in rad and m."""
    at = f"{where}, row {number}"
    if len(cells) != len(units):
        what = f"has {len(cells)} cells, and the header {len(units)}"
        raise TableError(what, where=at, remedy="give one cell for each column")
    out: dict[str, str | float] = {}
    for (name, unit), cell in zip(units, cells, strict=True):
        if name in ("joint", "kind"):
            out[name] = cell.strip()
        elif cell.strip():
            try:
                value = float(cell) * unit
            except ValueError:
                value = math.nan
            if not math.isfinite(value):
                raise TableError(f"{name} is {cell.strip()[:40]!r}", where=at, remedy="give a number")
            out[name] = value
    return out
