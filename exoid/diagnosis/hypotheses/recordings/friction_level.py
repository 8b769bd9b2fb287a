"""A joint is stiffer or easier to move in some recordings, cold or freshly greased: its friction times a number, all of
it, or the dry part alone (a brake that drags), or the viscous part alone (cold grease), or these two but no effect.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial

import numpy as np

from exoid.diagnosis.hypotheses.recordings import Claim, Seen, StateColumn, at_joint, each_said, than_usual
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float

BASE = "dry and viscous "
"""What the level of the base model's friction is told of, where effects have one of their own."""


def claims(model: Model, columns: Sequence[StateColumn]) -> tuple[Claim, ...]:
    """Return another level of each joint's friction, of all or of a part, a factor to the others' level."""
    return tuple(
        Claim("friction_level", joint.name, "1", at_joint(k, part), (-1.0, 4.0), 1.0, factor=True, of=of)
        for k, joint in enumerate(model.joints)
        for of, part in (*frictions(model, k).items(), *_parts(k).items())
    )


def frictions(model: Model, joint: int) -> dict[str, Callable[[Seen], Float]]:
    """Return the frictions (K,) of one joint that change as one: all of it and, where some has been added to the base
    model, that of the base model.
    """
    added = any(term.effect.family == "friction" and joint in term.reaches for term in model.terms)
    whole: dict[str, Callable[[Seen], Float]] = {"": partial(_all, joint)}
    return whole | ({BASE: partial(_of_base, (0, 1), joint)} if added else {})


def _parts(joint: int) -> dict[str, Callable[[Seen], Float]]:
    return {"dry ": partial(_of_base, (0,), joint), "viscous ": partial(_of_base, (1,), joint)}


def _all(joint: int, seen: Seen) -> Float:
    """Return the friction (K,) of one joint: of the base model, and what friction has been added there."""
    model = seen.model
    own = {term.name for term in model.terms if term.effect.family == "friction"}
    base = range(model.friction.start, model.friction.stop)
    which = [k for k, parameter in enumerate(model.parameters) if k in base or parameter.term in own]
    return np.asarray(seen.columns[joint][:, which] @ seen.linear[which])


def _of_base(parts: Sequence[int], joint: int, seen: Seen) -> Float:
    """Return the dry (0) and the viscous friction (1), or one of them, of the base model."""
    at = [seen.model.friction.start + 2 * joint + part for part in parts]
    return np.asarray(seen.columns[joint][:, at] @ seen.linear[at])


def said(claim: Claim, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on the levels {recording: words} of friction."""
    what = f"{claim.of}friction of the {claim.place} is another"
    return f"{than_usual(what, when)}: {each_said(values)} times as much"
