"""The words a torque text may use for the motion and for the model's own torque."""

from __future__ import annotations

from functools import lru_cache

from symbolic.language.deflection import SLOPES
from symbolic.language.parser import parse
from symbolic.language.tree import CONSTANTS, FUNCTIONS, OPERATORS, Node
from symbolic.units import NONE, TIME, TORQUE, Dimension

OWN = ("theta", "dtheta", "ddtheta", "tau_rigid", "tau_model")
"""Words that mean the effect's own joint; with 1 or 2 behind them they mean hip or knee."""

NUMBERED = tuple(f"{stem}{index}" for stem in OWN for index in (1, 2))

FEEDBACK = frozenset(f"{stem}{index}" for stem in ("tau_rigid", "tau_model") for index in ("", "1", "2")) | SLOPES
"""Words for the model's own torque and its derivatives."""

MODEL_TORQUE = frozenset(("tau_model", "tau_model1", "tau_model2"))

RESERVED = frozenset((*OWN, *NUMBERED, *SLOPES, "t", *CONSTANTS, *FUNCTIONS, *OPERATORS))
"""Words no coefficient and no shape may be called."""

_DIMENSIONS = dict(zip(OWN, (NONE, TIME**-1, TIME**-2, TORQUE, TORQUE), strict=True))

DIMENSIONS: dict[str, Dimension] = {
    "t": TIME,
    **{f"{stem}{index}": _DIMENSIONS[stem] for stem in OWN for index in ("", "1", "2")},
    **{word: TORQUE / _DIMENSIONS[word.partition("_by_")[2][:-1]] for word in SLOPES},
}
"""Dimensions of the words, for joints that turn."""


def own_names(joint: int) -> dict[str, str]:
    """Return {word for the own joint: canonical word} at a joint index."""
    return {stem: f"{stem}{joint + 1}" for stem in OWN}


def allowed_words(own: bool, numbers: tuple[str, ...]) -> frozenset[str]:
    """Return the words of a text with coefficients and shapes called `numbers`; `own` if it has a joint of its own."""
    return frozenset((*(OWN if own else ()), *NUMBERED, *SLOPES, "t", *CONSTANTS, *numbers))


@lru_cache(maxsize=1024)
def read_text(text: str, own: bool, numbers: tuple[str, ...]) -> Node:
    """Return the tree of a torque text; ExpressionError points at what the grammar refuses."""
    return parse(text, allowed_words(own, numbers))
