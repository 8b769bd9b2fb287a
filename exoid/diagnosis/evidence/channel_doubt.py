"""A doubt about channels that cannot be what they say, and the share of each torque that a model leaves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from exoid.diagnosis.evidence.fitted import FittedModel
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
    count = len(fitted.prepared.train)
    parts = [slice(0, count)] + ([slice(count, None)] if fitted.verified else [])
    joints = len(fitted.model.joints)
    out = np.full((len(parts), joints), np.nan)
    for joint in range(joints):
        known = [p.torque[joint, p.used[joint]] for p in fitted.prepared.all if p.driven[joint]]
        whole = float(np.concatenate(known).var()) if sum(t.size for t in known) else 0.0
        for row, part in enumerate(parts):
            pairs = zip(fitted.residuals[part], fitted.prepared.all[part], strict=True)
            left = [r[joint][p.used[joint]] for r, p in pairs if p.driven[joint]]
            if whole > 0.0 and sum(r.size for r in left):
                out[row, joint] = np.mean(np.concatenate(left) ** 2) / whole
    seen = np.isfinite(out).any(axis=0)
    return np.where(seen, np.max(np.where(np.isfinite(out), out, -np.inf), axis=0), np.nan)
