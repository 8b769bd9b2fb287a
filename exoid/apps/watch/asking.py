"""Differences between windows from before and from after, asked of the model as it is usually."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from exoid.apps.watch.memory import TOGETHER
from exoid.apps.watch.window import Window, joined_windows, prepared
from exoid.diagnosis.against.differences import BeforeAfter
from exoid.diagnosis.against.result import Differences
from exoid.diagnosis.evidence.fitted import FittedModel, fitted_model
from exoid.diagnosis.rules import Rules
from exoid.symbolic.effect import Effect
from exoid.symbolic.motion import Float


def asked_of(now: FittedModel, before: Sequence[Window], after: Sequence[Window]) -> FittedModel:
    """Return the model as it is usually, at its numbers, on windows `before` and `after`."""
    question = prepared(now.model.joints, before, joined_windows(after, TOGETHER))
    shapes = np.broadcast_to(now.shape, (len(question.train), now.shape.size))
    return fitted_model(replace(now.fit, shapes=shapes), question)


def differences_of(
    asked: FittedModel, seed: int, extra: Sequence[Effect], rules: Rules, most: int, known: Mapping[str, Float]
) -> Differences:
    """Return the differences, `most` at most; `known` {name: numbers} are those known already."""
    return BeforeAfter(asked, seed, tuple(extra), rules, most, known).run()
