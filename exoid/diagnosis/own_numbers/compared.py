"""Two models compared on the same recordings, block by block of each."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.own_numbers.state import UNCUT, Cuts
from exoid.diagnosis.rules import Rules
from exoid.symbolic.motion import Float


def predicts_better(last: FittedModel, rival: FittedModel, rules: Rules, cuts: Cuts = UNCUT) -> bool:
    """True where a model beside what belongs to recordings, or to the parts into which `cuts` divide some, predicts
    clearly better than the `last` one without, and unseen motion not worse by a part worth telling.
    """
    once, then = (item.recording_losses(last.scale, rules, cuts, last.prepared) for item in (last, rival))
    worse = rival.unseen_loss(last.scale, rules) > (1.0 + rules.worth_telling) * last.unseen_loss(last.scale, rules)
    return not worse and falls_clearly(once, then, rules, rules.clear)


def falls_clearly(once: Sequence[Float], then: Sequence[Float], rules: Rules, clear: float) -> bool:
    """True if losses `then` are below `once` by a part worth telling, and by so many standard errors."""
    return total(then) <= (1.0 - rules.worth_telling) * total(once) and clearer(once, then) >= clear


def explained_by(last: FittedModel, rival: FittedModel) -> float:
    """Share of itself by which the loss of all recordings falls from the `last` model to a rival."""
    once, then = (total(item.recording_losses(last.scale)) for item in (last, rival))
    return 1.0 - then / once


def clearer(once: Sequence[Float], then: Sequence[Float]) -> float:
    """Standard errors by which losses `then`, blocks of each recording or part, are below `once`.

    What belongs to a recording, or to a part of it, shows there and nowhere else: blocks are compared with their own.
    """
    falls = [a - b for a, b in zip(once, then, strict=True)]
    fall = float(sum(item.sum() for item in falls))
    spread = float(np.sqrt(sum(np.sum((entry - entry.mean()) ** 2) for entry in falls)))
    least = 1e-9 * float(sum(element.sum() for element in once))
    return fall / max(spread, least) if abs(fall) > least else 0.0


def total(losses: Sequence[Float]) -> float:
    """Loss of all recordings together."""
    return float(sum(loss.sum() for loss in losses))
