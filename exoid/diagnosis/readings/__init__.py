"""Readings of the channels and of the geometry that are suspected as effects are: another length, a file each.

A reading is an entry of the search that no catalogue has. What accepts it names no effect: the answer is what to
correct, and effects are looked for when that is done.
"""

from __future__ import annotations

import sys
from functools import cache
from types import ModuleType

from exoid.diagnosis.evidence.channel_doubt import Doubt
from exoid.ground.folder import modules_in
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.effect import Effect
from exoid.symbolic.model import Model


@cache
def _readings() -> dict[str, ModuleType]:
    """Return the modules of this folder by the id of what each defines: EFFECT; `entry(model, prepared)`, that effect
    where it may be the case, or None; `what_is_wrong(fit, name)`, what is to be said where it was accepted; and
    `change(fit, name)`, by what share of itself what it reads would change.
    """
    return {item.EFFECT.id: item for item in modules_in(sys.modules[__name__]).values()}


def readings_of(model: Model, prepared: Prepared) -> tuple[Effect, ...]:
    """Return the entries of the readings that may be the case."""
    entries = (reading.entry(model, prepared) for reading in _readings().values())
    return tuple(entry for entry in entries if entry is not None)


def is_reading(name: str) -> bool:
    """True if the term called `name` is a reading."""
    return name.partition(":")[0] in _readings()


def reading_said(name: str) -> str:
    """Title of a reading, in words."""
    return str(_readings()[name.partition(":")[0]].EFFECT.title.lower())


def reading_doubt(fit: Fit, name: str) -> Doubt:
    """Doubt where the reading called `name` was accepted, by a fit in which it is."""
    found: Doubt = _readings()[name.partition(":")[0]].what_is_wrong(fit, name)
    return found


def reading_change(fit: Fit, name: str) -> float:
    """Return by what share of itself a length would change where the reading called `name` was accepted."""
    return float(_readings()[name.partition(":")[0]].change(fit, name))
