"""Place of a model's error: in which variables of a joint's motion, and in which stretches of it.

A curve counts with what it takes from what the curves before it leave, so that the shares of a joint never add up to
more than its whole error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

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
SLOW: Threshold = 0.1
"""rad/s, or as much of a slide, below which a joint counts as slow: errors of reversal spread over all speeds"""
AT_LIMIT: Threshold = 0.05
"""share of the range at either end that counts as its end: a stop hides in the whole range"""
BINS = 24
BLOCK = 2.0
"""s, stretches of time whose means scatter independently of each other."""
CONCENTRATED: Threshold = 2.0
"""times more error than time that a region holds: every region has some"""
LEAST_REGION: Threshold = 0.15
"""share of the error that a region holds: a short peak beside the rest of it"""


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
    """Return the ranked list: curves that predict unseen error, and the regions in which the error gathers."""
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
    return _with_regions(now, joint, found, left)


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


def _with_regions(now: FittedModel, joint: str, found: dict[str, Where], left: Float) -> list[Where]:
    """Return the places `found`, with the regions (slow motion, the ends of the range) that hold much error.

    A region of a variable that has a line already is said there; another counts with what is `left` (K,) of the error.
    """
    number = now.model.joint_names.index(joint) + 1
    moved = now.model.joints[number - 1]
    slow, unit = SLOW * moved.reach, moved.unit("q")
    at = samples_of(now, joint, f"q{number}", train=True)
    error, rest = at.y**2, left**2
    total = float(error.sum())
    edge = AT_LIMIT * float(np.ptp(at.x))
    high, low = at.x.max() - edge, at.x.min() + edge
    regions = (
        (f"dq{number}", np.abs(at.speed) < slow, f"within ±{slow:g} {unit}/s, where it creeps or reverses"),
        (f"q{number}", at.x > high, f"above {high:.2f} {unit}, at the upper end"),
        (f"q{number}", at.x < low, f"below {low:.2f} {unit}, at the lower end"),
    )
    more = []
    for variable, mask, words in regions:
        time, known = float(mask.mean()), found.get(variable)
        share = float((error if known else rest)[mask].sum()) / total
        if not share > max(CONCENTRATED * time, LEAST_REGION):
            continue
        place = f"{words}, in {100 * time:.0f} % of the time"
        if known:
            text = f"{known.sentence}; {100 * share:.0f} % of the whole sits {place}"
            found[variable] = replace(known, sentence=text)
        else:
            further = "a further " if found else ""
            text = f"{joint}: {further}{100 * share:.0f} % of the squared error sits {place}"
            more.append(Where(joint, variable, share, text))
            rest = np.where(mask, 0.0, rest)
    return [*found.values(), *more]
