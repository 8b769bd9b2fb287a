"""Numbers as the registers of a drive hold them: whole ones, whose sign is written in a way of its own, and counts.

A sign is put right where the samples leave no doubt; what one count is only a person can say.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from exoid.ground.errors import RecordingError
from exoid.measurement.finding import Finding
from exoid.measurement.reading.columns import Assigned
from exoid.measurement.reading.counts import REACH, Counts, always_negative, are_counts, question
from exoid.measurement.reading.names import kind_of, quantity_of
from exoid.measurement.reading.outside import CONTACT
from exoid.measurement.reading.signs import Signed, below_zero, continued, is_whole, signed
from exoid.measurement.reading.units import is_product
from exoid.symbolic.joints import Joint
from exoid.symbolic.motion import Float
from exoid.symbolic.units import DEGREE

COUNTED = "counts of {}"
"""What a finding is called that says that an angle counts the steps of an encoder."""


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
        if name not in ("t", CONTACT):
            found = _signed(name, item, where, joints)
            values, how = found.values, found.how
            if how:
                mended[name] = how
            if found.doubt:
                findings.append(_doubt(name, item, found.doubt, where))
            if item.told and (negative := always_negative(name, Counts(item.column.name, item.column.values))):
                findings.append(_warning(*negative, where))
            if quantity in REACH and is_whole(values):
                # Their rates count what the angles do.
                own = quantity not in ("q", "tau") and f"q{name.removeprefix(quantity)}" in counted
                if not item.told and (own or are_counts(name, values, bool(how), joints)):
                    counts[name] = values
                if quantity == "q" and item.told and is_product(item.unit) and kind_of(name, joints) == "q":
                    counted.add(name)
                    what = f"{name} counts the steps of an encoder, whose zero may lie anywhere"
                    findings.append(Finding(COUNTED.format(name), "info", what, where, item.factor))
        columns[name] = values * item.factor
    asked = {
        name: Counts(assigned[name].column.name, values)
        for name, values in counts.items()
        if quantity_of(name) in ("q", "tau")
    }
    if asked:
        what, units, notes = question(asked, joints)
        raise RecordingError(what, where=where, remedy=f"--units {units} {notes}")
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


def _signed(name: str, item: Assigned, where: str, joints: Sequence[Joint]) -> Signed:
    """Return the numbers of a column with their sign; RecordingError where they jump like a register without one, and
    nothing says which.
    """
    values = item.column.values
    turning = kind_of(name, joints) == "q"
    if turning and not is_whole(values) and _by_turns(values, item.factor):
        return Signed(values)  # what is mended with the angles
    found = signed(values)
    if turning and not found.how and is_whole(values):
        continues, how = continued(values)
        if how:
            return Signed(continues, how)
        if span := below_zero(values):  # where the zero lies is free, and the numbers say how fine the steps are
            return Signed(values - span, f"stays close under {span:.0f}")
    if quantity_of(name) in ("q", "tau") and found.doubt and not found.register:
        doubt = _doubt(name, item, found.doubt, where)
        raise RecordingError(doubt.what, where=where, remedy=doubt.remedy)
    return found


def _by_turns(values: Float, factor: float) -> bool:
    """True if an angle jumps by whole turns, in its unit or in degrees."""
    good = values[np.isfinite(values)]
    jump = float(np.abs(np.diff(good)).max(initial=0.0))
    return any(abs(jump * unit - 2 * np.pi) < 0.5 for unit in (factor, factor * DEGREE))


def _doubt(name: str, item: Assigned, doubt: str, where: str) -> Finding:
    """Return that a column may be a register that was read without its sign, and what to do."""
    what = f"{name} ({item.column.name!r}) {doubt}: the register of a drive, read without the sign of its numbers?"
    remedy = "log it with its sign, or give the whole numbers of the register and say what one is with --units"
    return _warning(what, remedy, where)


def _warning(what: str, remedy: str, where: str) -> Finding:
    consequence = "every parameter is wrong"
    return Finding("registers", "warning", what, where, None, None, remedy, consequence, "likely")
