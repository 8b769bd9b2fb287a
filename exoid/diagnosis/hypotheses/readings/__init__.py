"""Readings of the channels and of the geometry that are suspected as effects are: another length, a file each.

A reading is an entry of the search that no catalogue has. What accepts it names no effect: the answer is what to
correct, and effects are looked for when that is done.
"""

from __future__ import annotations

import sys
from collections.abc import Iterable, Mapping
from functools import cache
from types import ModuleType

from exoid.diagnosis.evidence.channel_doubt import Doubt
from exoid.diagnosis.hypotheses.recordings import listed
from exoid.diagnosis.rules import Rules
from exoid.ground.folder import modules_in
from exoid.optimisation.fitting.fit import Fit
from exoid.optimisation.preparation.prepare import Prepared
from exoid.symbolic.effect import Effect
from exoid.symbolic.model import Model

ALONE = "The torque of the {} does not belong to the motion as it is logged: it looks as if it {}."
SEVERAL = "The torques of {} do not belong to the motion as they are logged: it looks as if each {}."


@cache
def _readings() -> dict[str, ModuleType]:
    """Return the modules of this folder by the id of what each defines: EFFECT; `entry(model, prepared)`, that effect
    where it may be the case, or None; `objection(fit, name, explained, rules)`, why it is not although it helps, by the
    share of the squared error that it explains at its joints, or ""; and `what_is_wrong(fit, names)`, what is to be
    said where terms of these names were accepted.
    """
    return {item.EFFECT.id: item for item in modules_in(sys.modules[__name__]).values()}


def _of(name: str) -> ModuleType:
    return _readings()[name.partition(":")[0]]


def readings_of(model: Model, prepared: Prepared) -> tuple[Effect, ...]:
    """Return the entries of the readings that may be the case."""
    entries = (reading.entry(model, prepared) for reading in _readings().values())
    return tuple(entry for entry in entries if entry is not None)


def is_reading(name: str) -> bool:
    """True if the term called `name` is a reading."""
    return name.partition(":")[0] in _readings()


def reading_said(name: str) -> str:
    """Title of a reading, in words."""
    return str(_of(name).EFFECT.title.lower())


def reading_doubt(fit: Fit, names: Iterable[str]) -> Doubt | None:
    """Doubt where readings are among the terms called `names`, by a fit in which they are; None where none is."""
    by_module: dict[ModuleType, list[str]] = {}
    places = ["", *fit.model.joint_names]
    for name in sorted(filter(is_reading, names), key=lambda name: places.index(name.partition(":")[2])):
        by_module.setdefault(_of(name), []).append(name)
    found: list[Doubt] = [module.what_is_wrong(fit, some) for module, some in by_module.items()]
    if not found:
        return None
    return Doubt(found[0].rule, " ".join(doubt.sentence for doubt in found), "; ".join(doubt.remedy for doubt in found))


def reading_objection(fit: Fit, name: str, explained: float, rules: Rules) -> str:
    """Objection to a reading that helps, which explains so much of the error at its joints; "" for none."""
    return str(_of(name).objection(fit, name, explained, rules)) if is_reading(name) else ""


def unless_misread(effect: Effect, model: Model, prepared: Prepared) -> Effect | None:
    """Return an effect where no channel is misread otherwise."""
    return None if prepared.misread else effect


def only_in_part(fit: Fit, name: str, explained: float, rules: Rules) -> str:
    """Objection to a reading that should explain most of what is left at its joint."""
    if explained >= rules.half:
        return ""
    return f"it explains {100 * max(explained, 0.0):.0f} % of the squared error, where the wrong reading leaves most"


def unchanged(share: float, rules: Rules) -> str:
    """Objection to a length that would change by less than what counts, a `share` of itself."""
    if share >= rules.least_share:
        return ""
    return f"the length would change by {100 * share:.1g} %, which is practically the same"


def wrong_torques(logged: Mapping[str, str], remedy: str) -> Doubt:
    """Doubt where torques are not what they are logged as, but what {name of the term: words} says."""
    joints: dict[str, list[str]] = {}
    for name, what in logged.items():
        joints.setdefault(what, []).append(name.partition(":")[2])
    sentences = [(SEVERAL if own[1:] else ALONE).format(listed(own), what) for what, own in joints.items()]
    rule = "another reading of torques explains more than every entry of the catalogue, and more than its own placebos"
    return Doubt(rule, " ".join(sentences), remedy)
