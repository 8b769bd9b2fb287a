"""Circular shifts in time, which make placebos of a candidate's columns: which are drawn, and the transforms in which
all of them are multiplied at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache

import numpy as np

from exoid.diagnosis.evidence.columns import Columns
from exoid.diagnosis.rules import Rules
from exoid.symbolic.motion import Float


def spectra_of(columns: Columns, node: int) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the conjugate transforms of the columns of one node, and of their products, at each of its joints."""
    out: list[tuple[np.ndarray, np.ndarray]] = []
    if columns.is_absent:
        return out
    first, second = upper_pairs(columns.values.shape[3])
    for x in columns.values[node]:
        rows = np.ascontiguousarray(x.T)
        both = np.conj(np.fft.rfft(np.concatenate([rows, rows[first] * rows[second]])))
        out.append((both[: len(rows)], both[len(rows) :]))
    return out


@lru_cache
def upper_pairs(width: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the rows and columns of the upper triangle of a square matrix."""
    return np.triu_indices(width)


def draw_shifts(
    motions: Sequence[tuple[Float, float]], draws: int, rng: np.random.Generator, rules: Rules
) -> list[np.ndarray]:
    """Return (draws,) shifts in samples for each recording of angles (K, J) at a rate in Hz, away from zero and from
    repeats of the motion.
    """
    out = []
    for motion, rate in motions:
        samples = len(motion)
        least = min(int(rules.min_shift * rate), samples // 4)
        centred = motion - motion.mean(axis=0)
        spectrum = np.abs(np.fft.rfft(centred, axis=0)) ** 2
        alike = np.fft.irfft(spectrum, samples, axis=0)
        alike = (alike / np.maximum(alike[:1], 1e-300)).mean(axis=1)
        lag = np.arange(samples)
        allowed = (lag >= least) & (lag <= samples - least)
        fresh = np.flatnonzero(allowed & (alike < rules.half))
        out.append(rng.choice(fresh if fresh.size > 20 else np.flatnonzero(allowed), size=draws))
    return out
