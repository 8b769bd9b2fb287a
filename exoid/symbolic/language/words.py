"""The words a torque text may use for the motion and for the model's own torque."""

from __future__ import annotations

import re
from functools import lru_cache

from exoid.symbolic.joints import MOST
from exoid.symbolic.language.deflection import SLOPES
from exoid.symbolic.language.parser import parse
from exoid.symbolic.language.tree import CONSTANTS, FUNCTIONS, OPERATORS, Node
from exoid.symbolic.units import FORCE, LENGTH, NONE, TIME, TORQUE, Dimension

OWN = ("theta", "dtheta", "ddtheta", "tau_rigid", "tau_model")
"""Words that mean the effect's own joint. With a number behind them they mean the joint of that number (1: the first),
with _next the joint after the own one, with a name in square brackets the joint of that name.
"""

NUMBERED = tuple(f"{stem}{index}" for stem in OWN for index in (1, 2))
_SUFFIXES = ("", "_next", *(str(index) for index in range(1, MOST + 1)))

FEEDBACK = frozenset(f"{stem}{suffix}" for stem in ("tau_rigid", "tau_model") for suffix in _SUFFIXES) | SLOPES
"""Words for the model's own torque and its derivatives."""

MODEL_TORQUE = frozenset(f"tau_model{suffix}" for suffix in _SUFFIXES)

RESERVED = frozenset((*OWN, *NUMBERED, *SLOPES, "t", *CONSTANTS, *FUNCTIONS, *OPERATORS))
"""Words no coefficient and no shape may be called."""

_DIMENSIONS = dict(zip(OWN, (NONE, TIME**-1, TIME**-2, TORQUE, TORQUE), strict=True))

_SLIDING = dict(zip(OWN, (LENGTH, LENGTH / TIME, LENGTH / TIME**2, FORCE, FORCE), strict=True))

_WORD = re.compile(
    r"(?P<stem>d{0,2}theta|tau_rigid|tau_model)"
    r"(?:(?P<number>[0-9]{1,2})|(?P<next>_next)|\[(?P<name>[A-Za-z][A-Za-z0-9_]*)\])?"
)


def stem_of(word: str) -> str | None:
    """Stem in OWN of a word of some joint: "dtheta" for dtheta2, dtheta_next, dtheta[knee]; None for others."""
    found = _WORD.fullmatch(word)
    return None if found is None else found["stem"]


def word_dimension(word: str, turns: bool = True) -> Dimension:
    """Return the dimension of a word for the motion or the time, of a joint that turns or slides."""
    stem = stem_of(word)
    if word in SLOPES:
        return TORQUE / _DIMENSIONS[word.partition("_by_")[2].rstrip("0123456789")]
    return TIME if stem is None else (_DIMENSIONS if turns else _SLIDING)[stem]


def joint_of(word: str, own: int, names: tuple[str, ...]) -> int | None:
    """Return the index of the joint a word speaks of, seen from joint `own`; None where there is no such joint."""
    found = _WORD.fullmatch(word)
    if found is None:
        return None
    if found["number"]:
        index = int(found["number"]) - 1
    elif found["name"]:
        return names.index(found["name"]) if found["name"] in names else None
    else:
        index = own + 1 if found["next"] else own
    return index if 0 <= index < len(names) else None


def allowed_words(own: bool, numbers: tuple[str, ...]) -> frozenset[str]:
    """Return the words of a text with coefficients and shapes called `numbers`; `own` if it has a joint of its own."""
    return frozenset((*(OWN if own else ()), *NUMBERED, *SLOPES, "t", *CONSTANTS, *numbers))


@lru_cache(maxsize=1024)
def read_text(text: str, own: bool, numbers: tuple[str, ...]) -> Node:
    """Return the tree of a torque text; ExpressionError points at what the grammar refuses.

    Which joints a machine has is not known here: every number and every name of a joint is accepted.
    """
    others = {found.group() for found in _WORD.finditer(str(text)) if found["number"] or found["name"]}
    if own:
        others |= {f"{stem}_next" for stem in OWN}
    return parse(text, allowed_words(own, numbers) | others)
