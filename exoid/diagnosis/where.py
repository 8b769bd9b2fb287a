"""Place of a model's error: in which variables of a joint's motion.

A curve counts with what it takes from what the curves before it leave, so that the shares of a joint never add up to
more than its whole error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from exoid.diagnosis.evidence.curves import signal_of, variables
from exoid.diagnosis.evidence.fitted import FittedModel
from exoid.diagnosis.evidence.remainder import Remainder
from exoid.ground.plain import AsJson
from exoid.ground.thresholds import Threshold
from exoid.ground.ties import ascending
from exoid.symbolic.motion import Float

Int = NDArray[np.int64]

LEAST_SHARE: Threshold = 0.01
"""share of a joint's squared error that is worth a line: what curves follow by chance"""
BINS = 24
BLOCK = 2.0
"""s, stretches of time whose means scatter independently of each other."""


@dataclass(frozen=True)
class Where(AsJson):
    """One place the error sits at: `share` of the joint's squared error beyond the places before it, in `sentence`.

    `split` is by what the sentence distinguishes: "direction" of motion, "recording", or "".
    """

    joint: str
    variable: str
    share: float
    sentence: str
    caution: str = ""
    split: str = ""


@dataclass(frozen=True, eq=False)
class ErrorSamples:
    """The residual `y` (K,) of a joint in every usable sample, over a variable `x` (K,).

    `speed` (K,) is the joint's velocity, `recording` (K,) and `block` (K,) number the recording and the stretch of time
    a sample belongs to.
    """

    x: Float
    y: Float
    speed: Float
    recording: Int
    block: Int


def samples_of(now: FittedModel, joint: str, variable: str, *, train: bool = False) -> ErrorSamples:
    """Return the samples of all recordings, or of those that are fitted (`train`)."""
    j = now.model.joint_names.index(joint)
    parts = []
    recordings = now.prepared.train if train else now.prepared.all
    for number, (item, residual) in enumerate(zip(recordings, now.residuals, strict=False)):
        used = item.used[j]
        block = 1000 * number + np.arange(len(item.t)) // max(1, int(BLOCK * item.kept_rate))
        x, speed = signal_of(item, now, variable, j)[item.kept], item.motion.dq[item.kept, j]
        parts.append([column[used] for column in (x, residual[j], speed, np.full(len(block), number), block)])
    x, y, speed, index, block = (np.concatenate(column) for column in zip(*parts, strict=True))
    return ErrorSamples(x, y, speed, index, block)


def where_it_sits(now: FittedModel, curves: Sequence[Remainder]) -> tuple[Where, ...]:
    """Variables of which a curve predicts unseen error, the largest share first."""
    found = [item for joint in now.model.joint_names for item in _at_joint(now, joint, curves)]
    return tuple(ascending(found, lambda w: -w.share, 1.0))


def _at_joint(now: FittedModel, joint: str, curves: Sequence[Remainder]) -> list[Where]:
    left = samples_of(now, joint, "t", train=True).y
    total = float(left @ left)
    found: dict[str, Where] = {}
    if not total:
        return []
    for item in curves:
        if item.joint != joint or item.joint_share < LEAST_SHARE or item.variable in found:
            continue
        after = left - _followed(item, samples_of(now, joint, item.variable, train=True), left)
        share = min(item.joint_share, float(left @ left - after @ after) / total)
        if share < LEAST_SHARE:
            continue
        direction = " and the direction of motion" if item.directed else ""
        moved = ", at a place that differs between recordings" if item.own else ""
        words = variables(now.model.joints)[item.variable][0]
        more = "a further " if found else ""
        text = f"{joint}: {more}{100 * share:.0f} % of the squared error follows the {words}{direction}{moved}"
        caution = "" if item.unseen > 0.0 else "not so on the verification recordings"
        split = "direction" if item.directed else "recording" if item.own else ""
        found[item.variable] = Where(joint, item.variable, share, text, caution, split)
        left = after
    return [*found.values()]


def _followed(one: Remainder, at: ErrorSamples, y: Float) -> Float:
    """Part of `y` (K,) that follows the variable of a curve: its mean in bins, times the factor of the curve."""
    factor = {"sign": np.sign(at.speed), "speed": at.speed}.get(one.factor, np.ones(len(y)))
    x = np.abs(at.x) if one.directed and one.variable.startswith("dq") else at.x
    edges = np.unique(np.quantile(x, np.linspace(0.0, 1.0, BINS + 1)))
    group: Int = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, max(0, len(edges) - 2))
    if one.own:
        group = np.asarray(group + BINS * at.recording)
    top, bottom = np.bincount(group, factor * y), np.bincount(group, factor * factor)
    return np.asarray((top / np.maximum(bottom, 1e-300))[group] * factor)
