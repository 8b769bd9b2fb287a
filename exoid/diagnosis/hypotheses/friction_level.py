"""A joint is stiffer or easier to move in some recordings, cold or freshly greased: all its friction times a number."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from exoid.diagnosis.hypotheses import Claim, Seen, StateColumn, at_joint, each_said, than_usual
from exoid.symbolic.model import Model
from exoid.symbolic.motion import Float


def claims(model: Model, columns: Sequence[StateColumn]) -> tuple[Claim, ...]:
    """Return another level of each joint's friction, a factor to the others' level."""
    return tuple(
        Claim("friction_level", joint.name, "1", at_joint(k, partial(friction, k)), (-1.0, 4.0), usual=1.0, factor=True)
        for k, joint in enumerate(model.joints)
    )


def friction(joint: int, seen: Seen) -> Float:
    """Return the friction (K,) of one joint: of the base model, and what friction has been added there."""
    model = seen.model
    own = {term.name for term in model.terms if term.effect.family == "friction"}
    base = range(model.friction.start, model.friction.stop)
    which = [k for k, parameter in enumerate(model.parameters) if k in base or parameter.term in own]
    return np.asarray(seen.columns[joint][:, which] @ seen.linear[which])


def said(claim: Claim, values: dict[str, str], where: str, when: str) -> str:
    """Sentence on the levels {recording: words} of friction."""
    return f"{than_usual(f'friction of the {claim.place} is another', when)}: {each_said(values)} times as much"
