"""Angles whose size can only be degrees: read as such and said, where nobody stated a unit.

A joint of a limb stops long before two turns, so an angle beyond that is not in rad. What else it could be leaves the
question open, and the audit asks it: counts of an encoder, another machine, or turns of a motor before its gear, where
the name says so or the torques do.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from exoid.measurement.auditing.checks.units import CHECK as UNITS
from exoid.measurement.auditing.checks.units import EACH, ROUND, TURNS
from exoid.measurement.auditing.convention import better_reading
from exoid.measurement.auditing.power_left import motions_of
from exoid.measurement.reading.angles import sampled
from exoid.measurement.reading.columns import Assigned
from exoid.measurement.reading.draft import Draft
from exoid.measurement.reading.names import words_in
from exoid.measurement.recording import Recording, base_columns
from exoid.symbolic.units import DEGREE

LIMBS = frozenset({"hip", "knee", "ankle", "shoulder", "elbow", "wrist"})
"""Words of a joint of a person or of what a person wears, which stops within a turn."""
BEFORE_GEAR = frozenset({"motor", "drive", "actuator", "encoder", "enc", "counts", "ticks", "raw", "rotor"})
"""Words of a column that may count turns of a shaft, or steps of an encoder."""


def read_degrees(draft: Draft, assigned: Mapping[str, Assigned]) -> Draft:
    """Return the draft with angles, and velocities with them, read in degrees where they can be nothing else."""
    angles = [f"q{k + 1}" for k in range(len(draft.joints))]
    reach = {name: _reach(draft, name) for name in angles}
    if not _certain(draft, assigned, reach):
        return draft
    known = [name for name, unit in base_columns(draft.joints).items() if unit == "rad" and name in draft.columns]
    base = [name for name in known if _reach(draft, name) > EACH]
    rates = [name for name in draft.columns if name in {f"{d}{angle}" for d in ("d", "dd") for angle in angles}]
    converted = [name for name in (*angles, *base, *rates) if name not in draft.told]
    columns = {n: v * DEGREE if n in converted else v for n, v in draft.columns.items()}
    largest = max(angles, key=lambda name: reach[name])
    what = f"{largest} reaches {reach[largest]:.4g}, in rad impossible for the "
    what += f"{draft.joints[angles.index(largest)].name}: {', '.join(converted)} were read in degrees"
    remedy = "if that is wrong, say so with --units q=rad; a header 'q1 [deg]' avoids the question"
    return replace(draft, columns=columns).noted(
        UNITS, "repaired", what, f"column {largest}", value=reach[largest], limit=float(TURNS), remedy=remedy,
        confidence="likely",
    )  # fmt: skip


def _certain(draft: Draft, assigned: Mapping[str, Assigned], reach: Mapping[str, float]) -> bool:
    """True if all angles can only be degrees: nobody said a unit, all reach further than any in rad, and neither names
    nor torques say that they are turns of a motor before its gear.
    """
    limbs = all(joint.turns and not LIMBS.isdisjoint(words_in(joint.name)) for joint in draft.joints)
    if draft.told.intersection(reach) or not limbs:
        return False
    if not (TURNS < max(reach.values()) < ROUND and min(reach.values()) > EACH):
        return False
    for name in reach:
        some = sampled(draft.columns[name][draft.good(name)])
        if BEFORE_GEAR.intersection(words_in(assigned[name].column.name)) or np.all(some == np.round(some)):
            return False
    count = len(draft.joints)
    if count == 1:  # of whose gear torques say nothing: on a spring or a damper its inertia fits any ratio
        return True
    columns = [f"{key}{k + 1}" for key in ("q", "tau") for k in range(count)]
    values = np.column_stack([draft.columns[name] for name in columns])
    good = np.all([draft.good(name) for name in columns], axis=0)
    q, tau = values[:, :count], values[:, count:]
    found = better_reading(motions_of([Recording(draft.file, draft.columns["t"], q, tau, good, joints=draft.joints)]))
    return found is None or not any("-motor" in name.name for name in found.reading.names)


def _reach(draft: Draft, name: str) -> float:
    """Return the largest distance of a column from zero, but for its largest fiftieth."""
    some = sampled(draft.columns[name][draft.good(name)])
    return float(np.percentile(np.abs(some), 98)) if some.size else 0.0
