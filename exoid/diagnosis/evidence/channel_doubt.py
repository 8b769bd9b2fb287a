"""A doubt about channels that cannot be what they say, and the share of each torque that a model leaves."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.optimisation.preparation.filtering import PreparedRecording
from exoid.symbolic.motion import Float


@dataclass(frozen=True)
class Doubt:
    """Reason why the channels cannot be what they say: the rule that fired, the sentence, and what to do; and the
    `share` of the squared error that the other reading leaves, 0 where there is none.
    """

    rule: str
    sentence: str
    remedy: str
    share: float = 0.0


def left_share(fitted: FittedModel) -> Float:
    """Return the share (J,) of the variance of the torque that a model leaves, the larger of fitted and held out.

    The variance is that of all recordings: a held-out one that happens to need hardly any torque is no wrong channel.
    NaN for a joint that has no torque of its own to explain: undriven, or without a usable sample.
    """
    every, count = fitted.prepared.all, len(fitted.prepared.train)
    parts = [slice(count), slice(count, None)][: 1 + fitted.verified]
    whole = known([item.torque for item in every], every).var(axis=1)
    left = [(known(fitted.residuals[part], every[part]) ** 2).mean(axis=1) / whole for part in parts]
    return np.asarray(np.ma.stack(left).max(axis=0).filled(np.nan))


def known(rows: Sequence[Float], recordings: Sequence[PreparedRecording]) -> np.ma.MaskedArray[Any, Any]:
    """Return `rows` (J, K) of recordings behind one another, masked where no torque of a drive is known."""
    mask = [~(item.used & item.driven[:, None]) for item in recordings]
    return np.ma.masked_array(np.concatenate(rows, axis=1), np.concatenate(mask, axis=1))
