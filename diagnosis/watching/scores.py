"""Scores of a block: how much of each column, of the model's own and of the whole catalogue, its residual contains.

Only two numbers of a block and a column are kept: a = Σ x w r and i = Σ x w x, from which a / i is the size of the
column that the block wants, on top of the reference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from diagnosis.evidence.candidates import unfiltered_columns
from diagnosis.evidence.fitted import FittedModel
from diagnosis.evidence.gain import RecordingEvidence, robust_weight
from diagnosis.watching.questions import PLACES, Asked, Questions
from diagnosis.watching.window import Window
from ground.thresholds import Threshold
from symbolic.motion import Float

NODES = 1
"""Values of the shapes of an effect that are watched: an alarm only has to see it, a name is searched finely."""
SHIFT = Threshold(1.0, "s, shortest shift of a placebo: one that is nearly the column itself")


@dataclass(frozen=True, eq=False)
class Watched:
    """What is watched: a candidate at few nodes of its shapes."""

    asked: Asked
    nodes: Float


def watched(questions: Questions) -> tuple[Watched, ...]:
    """Return every change that is asked about, at few nodes of its shapes."""
    found = []
    for one in questions.candidates:
        if isinstance(one, Asked) and not one.always:
            nodes = one.nodes[0]
            at = np.unique(np.linspace(0, len(nodes) - 1, NODES + 2).round().astype(int)[1:-1])
            found.append(Watched(one, nodes[at]))
    return tuple(found)


def columns_of(questions: Sequence[Watched], window: Window, base: Float, now: FittedModel) -> Float:
    """Return all watched columns (C, J, K) on one window: effects, then numbers, then loads.

    `base` (J, K, P) are the columns of the model there.
    """
    joints = base.shape[0]
    own, loads, effects = [], [], []
    for one in questions:
        asked = one.asked
        if asked.number is not None:
            own.append(base[None, :, :, asked.number])
        elif asked.link is not None:
            loads.append(asked.load(now.model, base, PLACES[len(PLACES) // 2 :][:1]))
        else:
            found = unfiltered_columns(asked, one.nodes, window, now)(one.nodes)  # (V, A, m, N)
            whole = np.zeros((found.shape[0] * found.shape[2], joints, found.shape[3]))
            whole[:, list(asked.joints)] = np.moveaxis(found, 1, 2).reshape(len(whole), -1, found.shape[3])
            effects.append(whole)
    # All effects pass the filter together.
    filtered = [window.smooth_rows(np.concatenate(effects), range(joints), 1)] if effects else []
    return np.concatenate([*filtered, *own, *loads])


@dataclass(frozen=True, eq=False)
class Scores:
    """`slope` (C,) = Σ x w r and `power` (C,) = Σ x w x of a block, in units of the scale before."""

    slope: Float
    power: Float


def scores(columns: Float, residual: Float, use: np.ndarray, scale: Float, block: RecordingEvidence) -> Scores:
    """Return the scores of columns (C, J, K) with a residual (J, K) N·m."""
    weight = robust_weight(replace(block, residual=residual, use=use), scale) / scale[:, None] ** 2
    count = len(columns)
    flat = columns.reshape(count, -1)
    return Scores(flat @ (weight * residual).ravel(), (flat**2) @ weight.ravel())


def placebos(
    columns: Float, residual: Float, block: RecordingEvidence, scale: Float, draws: int, rng: np.random.Generator
) -> Float:
    """Return a² / i (draws, C) with its sign, of residuals shifted circularly in time: what chance makes of a block."""
    samples = residual.shape[1]
    least = min(int(SHIFT * block.rate), samples // 4)
    out = []
    for shift in rng.integers(least, samples - least, size=draws):
        found = scores(columns, np.roll(residual, shift, axis=1), np.roll(block.use, shift, axis=1), scale, block)
        out.append(found.slope / np.sqrt(np.maximum(found.power, 1e-300)))
    return np.array(out)
