"""Doubts about channels: reasons why they cannot be what they say, a file each, found by reading the folder.

Where one holds nothing is accepted: an effect named on top of it is nonsense. Those asked `FIRST`, before anything
outside is looked for, and those asked `BEFORE` the search need no more than the model that was given; those asked
`AFTER` it are about the best model that it found.
"""

from __future__ import annotations

import sys
from dataclasses import dataclass
from functools import cache
from types import ModuleType

from exoid.diagnosis.evidence.channel_doubt import Doubt
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.remainder import Remainder
from exoid.diagnosis.rules import RULES, Rules
from exoid.ground.folder import modules_in

FIRST, BEFORE, AFTER = "first", "before", "after"


@dataclass(frozen=True, eq=False)
class Asked:
    """Subject of a doubt, on all recordings: the model that was given (`base`), the best found (`last`), if any, and
    the `curve` that what it leaves follows.
    """

    base: FittedModel
    last: FittedModel
    rules: Rules
    curve: Remainder | None = None


@cache
def _doubts(when: str) -> tuple[ModuleType, ...]:
    """Return the modules of this folder that are asked then, in their order. Each has `WHEN` and `ORDER`, and
    `doubt(asked)`, which returns a Doubt, or None where nothing speaks against the channels.
    """
    found = [module for module in modules_in(sys.modules[__name__]).values() if when == module.WHEN]
    return tuple(sorted(found, key=lambda module: int(module.ORDER)))


def doubts_first(base: FittedModel, rules: Rules = RULES) -> Doubt | None:
    """Doubt in whose presence nothing outside can be told either; None without any."""
    return _first(FIRST, Asked(base, base, rules))


def doubts_before(base: FittedModel, rules: Rules = RULES) -> Doubt | None:
    """Doubt that makes a search pointless, judged with the model that is there; None where nothing does."""
    return _first(BEFORE, Asked(base, base, rules))


def doubts_after(
    base: FittedModel, last: FittedModel, rules: Rules = RULES, curve: Remainder | None = None
) -> Doubt | None:
    """Doubt by which the best model that was found (`last`) is no answer, with the `curve` that what it leaves follows;
    None without any.
    """
    return _first(AFTER, Asked(base, last, rules, curve))


def _first(when: str, asked: Asked) -> Doubt | None:
    return next(filter(None, (module.doubt(asked) for module in _doubts(when))), None)
