"""Numbers as the registers of a drive hold them: whole ones, whose sign is written in a way of its own, and counts.

A sign is put right where the samples leave no doubt; what one count is only a person can say.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.ground.thresholds import threshold
from exoid.measurement.reading.columns import Assigned
from exoid.measurement.reading.names import kind_of, quantity_of
from exoid.symbolic.joints import Joint
from exoid.symbolic.motion import Float
from exoid.symbolic.units import SI_UNIT

WIDTHS = (16, 32)
"""Bits of a register in which -1 is written as the largest number."""
SIGN_BITS = (10, 11, 15)
"""Bits of which one alone says the sign, as servos on a bus have them."""
BOTH = threshold(
    __name__, "BOTH", 0.02,
    "of the samples that each sign has at least: a few codes for an error would be taken for negative numbers",
)  # fmt: skip
LEAST = threshold(
    __name__, "LEAST", 3,
    "times that the sign changes: a single step of what is measured would be taken for one",
)  # fmt: skip
REACH = {"q": 4 * np.pi, "dq": np.inf, "ddq": np.inf, "tau": 1000.0}
"""rad and N·m that whole numbers without a unit go to, beyond which they are counts: nobody logs two turns, or the
torque of a strong drive, without a decimal."""
CIRCLES = (1024, 4096, 8192, 16384, 65536, 262144, 1048576)
"""Counts of one turn that encoders have."""
TURN = 360.0


def in_si(
    assigned: Mapping[str, Assigned], where: str, joints: Sequence[Joint]
) -> tuple[dict[str, Float], list[str], list[str]]:
    """Return the columns {canonical name: (N,)} in SI, what was mended in them, and what was left out of them.

    RecordingError for angles and torques that are counts of which nobody said what one is.
    """
    columns: dict[str, Float] = {}
    mended: dict[str, str] = {}
    counts: dict[str, Float] = {}
    for name, item in assigned.items():
        values, quantity = item.column.values, quantity_of(name)
        if quantity in REACH and _whole(values):
            signed, how = _signed(values)
            if how:
                values, mended[name] = signed, how
            if not item.told and (how or np.nanmax(np.abs(values), initial=0.0) > _reach(name, joints)):
                counts[name] = values
        columns[name] = values * item.factor
    asked = {name: values for name, values in counts.items() if quantity_of(name) in ("q", "tau")}
    if asked:
        what, remedy = _question(asked, assigned, joints)
        raise RecordingError(what, where=where, remedy=remedy)
    spare = [name for name in counts if name not in asked]
    columns = {name: values for name, values in columns.items() if name not in spare}
    said = [f"{name} {how}: an unsigned register, read as signed" for name, how in mended.items() if name in columns]
    return columns, said, [f"{' and '.join(spare)} left out: counts without a unit"] if spare else []


def _whole(values: Float) -> bool:
    some = values[:: max(1, values.size // 50)]
    with np.errstate(invalid="ignore"):
        return bool(np.all((some == np.round(some)) | np.isnan(some)) and np.isfinite(some).any()) and bool(
            np.all((values == np.round(values)) | np.isnan(values))
        )


def _reach(name: str, joints: Sequence[Joint]) -> float:
    turning = kind_of(name, joints) in ("q", "tau")
    return REACH[quantity_of(name)] if turning else np.inf


def _signed(values: Float) -> tuple[Float, str]:
    """Return whole numbers with their sign, and how it was written; as they are, and "", where that is not certain.

    It is where both signs are there, every change of sign is a jump over half the register as the numbers stand, and
    none is a jump in what they mean.
    """
    good = values[np.isfinite(values)]
    if good.size < 10 or good.min() < 0:
        return values, ""
    for bits, low, high in (
        *((bits, 2.0 ** (bits - 1), 2.0**bits) for bits in WIDTHS),
        *((bit, 2.0**bit, 2.0 ** (bit + 1)) for bit in SIGN_BITS),
    ):
        if not low < good.max() < high:
            continue
        whole_register = high == 2.0**bits
        meant = np.where(good >= low, good - high if whole_register else low - good, good)
        negative = good >= low
        cross = np.flatnonzero(negative[1:] != negative[:-1])
        jumps, steps = np.abs(np.diff(good))[cross], np.abs(np.diff(meant))
        if min(negative.mean(), 1 - negative.mean()) < BOTH or cross.size < LEAST:
            continue
        if jumps.min() > low / 2 and steps.max() < low / 2:
            out = np.where(values >= low, values - high if whole_register else low - values, values)
            jump = f"jumps by {high:.0f}" if whole_register else f"has its sign in bit {bits} (jumps by {low:.0f})"
            return out, jump
    return values, ""


def _question(
    counts: Mapping[str, Float], assigned: Mapping[str, Assigned], joints: Sequence[Joint]
) -> tuple[str, str]:
    """Return what is asked of counts without a unit, and what to do."""
    shown, options, notes = [], [], []
    for name, values in counts.items():
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        unit = SI_UNIT[kind_of(name, joints)]
        shown.append(f"{name} ({assigned[name].column.name!r}, {low:.0f} to {high:.0f})")
        if quantity_of(name) == "tau":
            options.append(f"{name}=Nm*0.001")
            notes.append(f"{name}: {unit} of one count")
        elif max(high, -low) < TURN:
            options.append(f"{name}=deg")
            notes.append(f"{name}: degrees, or deg/NUMBER with the counts of a degree")
        else:
            circle = next((one for one in CIRCLES if one > max(high, -low)), CIRCLES[-1])
            options.append(f"{name}=deg/{circle / TURN:.6g}")
            notes.append(f"{name}: here {circle} counts a turn")
    what = f"{' and '.join(shown)} are whole numbers without a unit: counts, and not yet rad or N·m"
    if len(shown) == 1:
        what = what.replace(" are whole", " holds whole")
    return what, f"--units {','.join(options)} with your numbers ({'; '.join(notes)})"
