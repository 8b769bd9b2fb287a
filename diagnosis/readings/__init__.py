"""Readings of the channels and of the geometry that are suspected as effects are: another length, a file each.

A reading is an entry of the search that no catalogue has. What accepts it names no effect: the answer is what to
correct, and effects are looked for when that is done.
"""

from __future__ import annotations

from exoid.diagnosis.evidence.channel_doubt import Doubt
from exoid.diagnosis.readings import link_length, thigh_length
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.effect import Effect
from exoid.symbolic.model import Model

READINGS = (thigh_length, link_length)
"""Of each module: EFFECT; `entry(model, prepared)`, that effect where it may be the case, or None; and
`what_is_wrong(fit, name)`, what is to be said where it was accepted."""
_BY_ID = {one.EFFECT.id: one for one in READINGS}


def readings_of(model: Model, prepared: Prepared) -> tuple[Effect, ...]:
    """Return the entries of the readings that may be the case."""
    entries = (one.entry(model, prepared) for one in READINGS)
    return tuple(one for one in entries if one is not None)


def is_reading(name: str) -> bool:
    """Whether the term called `name` is a reading."""
    return name.partition(":")[0] in _BY_ID


def reading_said(name: str) -> str:
    """Return what a reading is, in words."""
    return _BY_ID[name.partition(":")[0]].EFFECT.title.lower()


def reading_doubt(fit: Fit, name: str) -> Doubt:
    """Return what is to be said where the reading called `name` was accepted, by a fit in which it is."""
    return _BY_ID[name.partition(":")[0]].what_is_wrong(fit, name)
