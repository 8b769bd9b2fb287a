"""The machine was in another state, as a further column says: a warm motor moves easier, a sensor's zero drifts."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from exoid.diagnosis.hypotheses.recordings import Claim, Seen, StateColumn, at_joint
from exoid.diagnosis.hypotheses.recordings.friction_level import frictions
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

MOST = 0.9
"""Part of a joint's friction, or of its gain, that may go with a column: more is another machine."""


def claims(model: Model, columns: Sequence[StateColumn]) -> tuple[Claim, ...]:
    """Return, for each column, that a joint's friction, torque gain or zero goes with it, alike in all recordings."""
    out: list[Claim] = []
    for column in columns:
        for k in range(len(model.joints)) if column.joint is None else (column.joint,):
            out += _at_joint(model, k, column)
    return tuple(out)


def _at_joint(model: Model, k: int, column: StateColumn) -> list[Claim]:
    joint, most = model.joints[k], MOST / column.reach
    below = f"/{column.unit}" if column.unit else ""
    at = f"of what it is at {column.middle:.3g} {column.unit}".rstrip()

    def claim(of: str, unit: str, torque: Callable[[Seen], Float], most: float, *, drive: bool = True) -> Claim:
        pieces = at_joint(k, partial(_times, torque, column))
        return Claim(
            f"logged:{column.name}", joint.name, unit + below, pieces, (-most, most), factor=unit == "1", drive=drive,
            common=True, of=of,
        )  # fmt: skip

    rubs = frictions(model, k).items()
    return [
        *(claim(f"{of}friction, {at}", "1", friction, most, drive=False) for of, friction in rubs),
        claim(f"torque as it is told, {at}", "1", lambda seen: seen.torque[k], most),
        claim("torque sensor's zero", joint.unit("tau"), lambda seen: np.ones(len(seen.t)), np.inf),
    ]


def _times(torque: Callable[[Seen], Float], column: StateColumn, seen: Seen) -> Float:
    return torque(seen) * (seen.logged[column.name].at(seen.t) - column.middle)


def said(claim: Claim, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on what goes with a column; the number is the same in all recordings."""
    column = claim.what.partition(":")[2]
    what, _, of = claim.of.partition(", ")
    text = f"The {claim.place} {what} goes with {column}: {next(iter(values.values()))}"
    return f"{text}, {of}" if of else text
