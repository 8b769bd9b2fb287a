"""Scores of a block: how much of each column, of the model's own and of the whole catalogue, its residual contains.

Only two numbers of a block and a column are kept: a = Σ x w r and i = Σ x w x, from which a / i is the size of the
column that the block wants, on top of the reference.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from exoid.diagnosis.evidence.gain import RecordingEvidence, robust_weight
from exoid.diagnosis.rules import RULES
from exoid.symbolic.motion import Float


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
    least = min(int(RULES.min_shift * block.rate), samples // 4)
    out = []
    for shift in rng.integers(least, samples - least, size=draws):
        found = scores(columns, np.roll(residual, shift, axis=1), np.roll(block.use, shift, axis=1), scale, block)
        out.append(found.slope / np.sqrt(np.maximum(found.power, 1e-300)))
    return np.array(out)
