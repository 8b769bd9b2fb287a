"""Numbers as the registers of a drive hold them: whole ones, whose sign is written in a way of its own, and counts.

A sign is put right where the samples leave no doubt; what one count is only a person can say.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.ground.thresholds import threshold
from exoid.measurement.finding import Finding
from exoid.measurement.reading.columns import Assigned
from exoid.measurement.reading.limits import FASTEST
from exoid.measurement.reading.names import kind_of, quantity_of
from exoid.measurement.reading.units import is_product
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
NEAR_ZERO = threshold(
    __name__, "NEAR_ZERO", 0.1,
    "of the largest number of each sign that the smallest has at most: two levels would be taken for two signs",
)  # fmt: skip
COUNTED = "counts of {}"
"""What a finding is called that says that an angle counts the steps of an encoder."""
REACH = {"q": 4 * np.pi, "dq": FASTEST, "ddq": np.inf, "tau": 1000.0}
"""rad, rad/s and N·m that whole numbers without a unit go to, beyond which they are counts: nobody logs two turns, or
the torque of a strong drive, without a decimal."""
CIRCLES = (1024, 4096, 8192, 16384, 65536, 262144, 1048576)
"""Counts of one turn that encoders have."""
TURN = 360.0


def in_si(
    assigned: Mapping[str, Assigned], where: str, joints: Sequence[Joint]
) -> tuple[dict[str, Float], tuple[Finding, ...]]:
    """Return the columns {canonical name: (N,)} in SI, and what was found of registers and counts in them.

    RecordingError for angles and torques that are counts of which nobody said what one is.
    """
    columns: dict[str, Float] = {}
    mended: dict[str, str] = {}
    counts: dict[str, Float] = {}
    counted: set[str] = set()
    findings: list[Finding] = []
    for name, item in assigned.items():
        values, quantity = item.column.values, quantity_of(name)
        if quantity in REACH and _whole(values):
            signed, how = _signed(values)
            if how:
                values, mended[name] = signed, how
            own = quantity not in ("q", "tau") and f"q{name.removeprefix(quantity)}" in counted  # a rate of counts
            if not item.told and (how or own or np.nanmax(np.abs(values), initial=0.0) > _reach(name, joints)):
                counts[name] = values
            if quantity == "q" and item.told and is_product(item.unit) and kind_of(name, joints) == "q":
                counted.add(name)
                what = f"{name} counts the steps of an encoder, whose zero may lie anywhere"
                findings.append(Finding(COUNTED.format(name), "info", what, where))
        columns[name] = values * item.factor
    asked = {name: values for name, values in counts.items() if quantity_of(name) in ("q", "tau")}
    if asked:
        what, remedy = _question(asked, assigned, joints)
        raise RecordingError(what, where=where, remedy=remedy)
    spare = [name for name in counts if name not in asked]
    columns = {name: values for name, values in columns.items() if name not in spare}
    for name, how in mended.items():
        if name in columns:
            what = f"{name} {how}: an unsigned register, read as signed"
            findings.append(Finding("registers", "repaired", what, where, remedy="nothing"))
    if spare:
        what = f"{' and '.join(spare)} left out: counts without a unit"
        findings.append(Finding("columns", "info", what, where))
    return columns, tuple(findings)


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

    It is where both signs are there and come near zero, every change of sign is a jump over half the register as the
    numbers stand, and none is a jump in what they mean.
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
        sizes = (-meant[negative], meant[~negative])
        through = all(size.min() <= NEAR_ZERO * size.max() for size in sizes)
        if through and jumps.min() > low / 2 and steps.max() < low / 2:
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
