"""Likely meanings of columns whose names say none: what the error that asks for them proposes, and never taken."""

from __future__ import annotations

import re
import shlex
from collections.abc import Mapping, Sequence

import numpy as np

from exoid.ground.suggest import nearest
from exoid.measurement.reading.names import FOREIGN, WORDS, joints_of, quantity_of, words_in
from exoid.measurement.reading.raw import RawColumn
from exoid.symbolic.joints import Joint
from exoid.symbolic.motion import Float
from exoid.symbolic.units import QUANTITIES, plain_unit

HINTS: Mapping[str, frozenset[str]] = {
    "q": frozenset((*WORDS["q"], "encoder", "enc", "counts", "ticks", "steps", "potentiometer", "tilt", "state")),
    "tau": frozenset((*WORDS["tau"], *WORDS["i"], *WORDS["f"], "load", "loadcell", "strain", "pwm", "duty")),
}
OTHERS = frozenset((*WORDS["dq"], *WORDS["ddq"], "index", "frame", "episode", "temperature", "voltage"))
FOLLOWS = 0.9
"""Correlation from which a column is the rate of another: noise of the difference takes some of it."""


def counted_joints(names: Sequence[str]) -> int:
    """Number of joints of columns that are angles and torques by their names, from 0 or from 1: as many of one
    as of the other, 0 where that is not so.
    """
    stems: dict[str, dict[str, set[int]]] = {quantity: {} for quantity in HINTS}
    for name in names:
        found = re.fullmatch(r"(\D*)(\d{1,2})(\D*)", name)
        words = words_in(name) - {found[2]} if found else frozenset()
        if not found or (OTHERS | FOREIGN) & words:
            continue
        for quantity, hints in HINTS.items():
            if hints & words:
                stems[quantity].setdefault(f"{found[1]}#{found[3]}", set()).add(int(found[2]))
    counts = (
        {len(item) for item in found.values() if max(item) - min(item) + 1 == len(item) and min(item) < 2}
        for found in stems.values()
    )
    return max(set.intersection(*counts), default=0)


def likely_option(
    missing: Sequence[str], free: Sequence[RawColumn], time: Float | None, joints: Sequence[Joint]
) -> tuple[str, bool, dict[str, RawColumn]]:
    """Return the --map for all the `missing` columns, COLUMN where nothing is likely, and --passive for joints that
    have no torque beside others that do; whether every column was found; and these.
    """
    found = _guessed(missing, free, time, joints)
    torques = [name for name in missing if quantity_of(name) == "tau"]
    idle = [name for name in torques if name not in found]
    driven = any(name in found for name in torques) or len(torques) < len(joints)
    driven &= all(name in found for name in missing if name not in torques)
    passive = [joints[int(name.removeprefix("tau")) - 1].name for name in idle] if driven and found else []
    said = [f"{name}={found.get(name, 'COLUMN')}" for name in missing if name not in idle or not passive]
    options = f"--map {shlex.quote(','.join(said))}" if said else ""
    options += f" --passive {','.join(passive)}" if passive else ""
    every = bool(found) and not any(name not in found for name in missing if name not in idle)
    return options.strip(), every, {name: next(c for c in free if c.name == own) for name, own in found.items()}


def _guessed(
    missing: Sequence[str], free: Sequence[RawColumn], time: Float | None, joints: Sequence[Joint]
) -> dict[str, str]:
    """Return {canonical name: column} of what is likely."""
    usable = [column for column in free if _measured(column)]
    found: dict[str, str] = {}
    for quantity in ("q", "tau"):
        lacking = [name for name in missing if quantity_of(name) == quantity]
        hinted = [c for c in usable if _says(c, quantity) and not OTHERS & words_in(c.name)]
        found |= _of_joints(lacking, hinted, joints) if lacking else {}
        if quantity == "q" and lacking and not found and time is not None:
            found |= dict(zip(lacking, _with_rates(usable, time), strict=False))
    for name in missing:  # spelling alone
        rest = [column.name for column in usable if column.name not in found.values()]
        if name not in found and (close := nearest(name, rest, 1, cutoff=0.5)):
            found[name] = close[0]
    return found


def _says(column: RawColumn, quantity: str) -> bool:
    """True if a word of the column's name or its unit is of this quantity."""
    return bool(HINTS[quantity] & words_in(column.name)) or plain_unit(column.unit) in QUANTITIES[quantity]


def _measured(column: RawColumn) -> bool:
    good = np.isfinite(column.values)
    changes = bool(good.mean() > 0.5 and np.ptp(column.values[good]) > 0.0) if good.any() else False
    return changes and not FOREIGN & words_in(column.name)


def _of_joints(lacking: Sequence[str], columns: Sequence[RawColumn], joints: Sequence[Joint]) -> dict[str, str]:
    """Return whose the `columns` of one quantity are: by their numbers, by a joint in the name, or in order."""
    stems: dict[str, list[str]] = {}
    for column in columns:
        stems.setdefault(re.sub(r"\d+", "#", column.name), []).append(column.name)
    counted = next((names for names in stems.values() if len(names) >= len(joints) > 1), None)
    if counted:
        return {name: counted[int(name.lstrip("qtau")) - 1] for name in lacking}
    out: dict[str, str] = {}
    for name in lacking:
        own = [c.name for c in columns if joints_of(c.name, tuple(joints)) == {int(name.lstrip("qtau"))}]
        out |= {name: own[0]} if own else {}
    plain = [c.name for c in columns if not joints_of(c.name, tuple(joints))]
    return out or dict(zip(lacking, plain, strict=False))


def _with_rates(columns: Sequence[RawColumn], time: Float) -> list[str]:
    """Return the columns of which another is the rate, as in a state of positions and velocities."""
    good = np.isfinite(time)
    for column in columns:
        good &= np.isfinite(column.values)
    if good.sum() < 20 or np.any(np.diff(time[good]) <= 0):
        return []
    values = [column.values[good] for column in columns]
    out = []
    for column, value in zip(columns, values, strict=True):
        rate = np.gradient(value, time[good])
        others = [other for other in values if other is not value]
        if any(np.corrcoef(rate, other)[0, 1] > FOLLOWS for other in others):
            out.append(column.name)
    return out
