"""Whole numbers without a unit that can only be counts, and what is asked of them in one line that can be typed.

What one count is only a person can say.
"""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from exoid.measurement.reading.limits import FASTEST
from exoid.measurement.reading.names import kind_of, quantity_of
from exoid.measurement.reading.raw import RawColumn
from exoid.measurement.reading.signs import below_zero, is_whole, signed
from exoid.symbolic.joints import Joint
from exoid.symbolic.motion import Float
from exoid.symbolic.units import SI_UNIT

REACH: Mapping[str, float] = {"q": 4 * np.pi, "dq": FASTEST, "ddq": np.inf, "tau": 1000.0}
"""rad, rad/s and N·m that whole numbers without a unit go to, beyond which they are counts: nobody logs two turns, or
the torque of a strong drive, without a decimal."""
CIRCLES = (1024, 4096, 8192, 16384, 65536, 262144, 1048576)
"""Counts of one turn that encoders have."""
TURN = 360.0


class Counts(NamedTuple):
    """Whole numbers (N,) of a column of the file, with their sign."""

    column: str
    values: Float


class Asked(NamedTuple):
    """A question about counts: `what`, the values of --units to type, and what is to be done with them."""

    what: str
    units: str
    notes: str


def counts_in(columns: Mapping[str, RawColumn], joints: Sequence[Joint]) -> dict[str, Counts]:
    """Return the angles and torques among columns without a unit, by their canonical names, that can only be counts."""
    found: dict[str, Counts] = {}
    for name, column in columns.items():
        if quantity_of(name) in ("q", "tau") and is_whole(column.values):
            values, how, _, _ = signed(column.values)
            if are_counts(name, values, bool(how), joints):
                found[name] = Counts(column.name, values)
    return found


def are_counts(name: str, values: Float, register: bool, joints: Sequence[Joint]) -> bool:
    """True if whole numbers without a unit can only be counts: a `register` held them, or they go too far."""
    turning = kind_of(name, joints) in ("q", "tau")
    reach = REACH[quantity_of(name)] if turning else np.inf
    return register or bool(np.nanmax(np.abs(values), initial=0.0) > reach)


def question(counts: Mapping[str, Counts], joints: Sequence[Joint]) -> Asked:
    """Return the question about counts without a unit."""
    shown, options, notes = [], [], []
    reach = {name: float(np.abs(item.values[np.isfinite(item.values)]).max()) for name, item in counts.items()}
    most = max((size for name, size in reach.items() if quantity_of(name) == "q"), default=0.0)
    circle = next((entry for entry in CIRCLES if entry > most), CIRCLES[-1])  # encoders of one machine are mostly alike
    for name, count in counts.items():
        low, high = float(np.nanmin(count.values)), float(np.nanmax(count.values))
        shown.append(f"{name} ({count.column!r}, {low:.0f} to {high:.0f})")
        if quantity_of(name) == "tau":
            options.append(f"{name}=Nm*0.001")
            notes.append(f"{name}: {SI_UNIT[kind_of(name, joints)]} of one count")
        elif most < TURN:
            options.append(f"{name}=deg")
            notes.append("angles: here degrees; deg/NUMBER where you know the counts of a degree")
        else:
            options.append(f"{name}=deg/{circle / TURN:.6g}")
            notes.append(f"angles: here {circle} counts a turn; rad/NUMBER where you know the counts of a radian")
        if negative := always_negative(name, count):
            notes.append(f"{negative[0]}, {negative[1]}")
    angles = all(quantity_of(name) == "q" for name in counts)
    kind = "degrees, or counts of an encoder" if angles and most < TURN else "counts"
    si = "rad" if angles else "rad or N·m"
    what = f"{' and '.join(shown)} are whole numbers without a unit: {kind}, and not {si}"
    if len(shown) == 1:
        what = what.replace(" are whole", " holds whole")
    sure = "with your numbers" if any("/" in option or "*" in option for option in options) else "if it is so"
    return Asked(what, ",".join(options), f"{sure} ({'; '.join(dict.fromkeys(notes))})")


def always_negative(name: str, one: Counts) -> tuple[str, str] | None:
    """Return that a torque is never far from the end of a register, as one that is always negative, and what to do."""
    span = below_zero(one.values) if quantity_of(name) == "tau" else 0.0
    if not span:
        return None
    what = f"{name} ({one.column!r}) stays close under {span:.0f}, as the negative numbers of an unsigned register do"
    return what, f"if they are: --map {shlex.quote(f'{name}={one.column}-{span:.0f}')}"
